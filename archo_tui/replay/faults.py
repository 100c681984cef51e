"""The report of what could not be read in a bag, in a bounded number of lines."""

from __future__ import annotations

from collections import Counter

from archo_tui.safe_text import harmless

_MAX_LINES = 100
_MAX_MESSAGES = 100_000  # Counted apart; a higher count is of no use.
_MAX_REASON = 200  # Characters.


class Faults:
    """A collector of faults; equal ones count once.

    Attributes:
        is_cut: True if something was too much, and the rest is left out.
    """

    def __init__(self) -> None:
        self.is_cut = False
        self._lines: dict[str, None] = {}  # In order, each once.
        self._unreadable: dict[tuple[int, int], str] = {}  # Topics by message.
        self._reasons: dict[str, str] = {}  # By topic, for its first message.

    def add(self, text: str) -> None:
        """Add a line; it is made safe for a terminal."""
        text = harmless(text)
        if text not in self._lines:
            self._lines[text if len(self._lines) < _MAX_LINES else "and more"] = None

    def add_cut(self, text: str) -> None:
        """Add a line that says what was too much, so that the rest is left out."""
        self.is_cut = True
        self.add(f"{text}: the rest is left out")

    def add_message(self, topic: str, order: tuple[int, int], reason: str) -> None:
        """Count a message that cannot be read; it counts once, however often it is tried.

        Args:
            topic: Its topic.
            order: The number of its file range and its offset there, which identify it.
            reason: Why it cannot be read.
        """
        if len(self._unreadable) < _MAX_MESSAGES:
            self._unreadable[order] = topic
            self._reasons.setdefault(topic, reason[:_MAX_REASON])

    def lines(self) -> list[str]:
        """Return all lines; unreadable messages make one line for each topic."""
        counts = Counter(self._unreadable.values())
        messages = [
            harmless(f"{topic}: messages that cannot be read: {counts[topic]} ({reason})")
            for topic, reason in self._reasons.items()
        ]
        return [*self._lines, *messages[:_MAX_LINES]]
