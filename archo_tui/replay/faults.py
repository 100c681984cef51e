"""The report of what could not be read in a bag, in a bounded number of lines."""

from __future__ import annotations

from collections import Counter

from archo_tui.safe_text import harmless

_MAX_LINES = 100
_MAX_MESSAGES = 100_000  # Counted apart; a higher count is of no use.
_MAX_REASON = 200  # Characters.


class Faults:
    """A collector of fault lines, without repetitions: at most 100, then one line `and more`.

    Messages that cannot be read are counted apart, by topic.
    """

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}  # In order, each once.
        self._unreadable: dict[tuple[int, int], str] = {}  # Topics by message.
        self._reasons: dict[str, str] = {}  # By topic, for its first message.

    def add(self, text: str) -> None:
        """Add a line, safe for a terminal and cut to 500 characters, unless it is there already."""
        text = harmless(text)
        if text not in self._lines:
            self._lines[text if len(self._lines) < _MAX_LINES else "and more"] = None

    def add_message(self, topic: str, order: tuple[int, int], reason: str) -> None:
        """Count a message that cannot be read; it counts once, however often it is tried.

        Of a topic, the reason of the first message is kept. After 100,000 messages, no more are
        counted.

        Args:
            topic: Its topic.
            order: The number of its file range and its offset there, which identify it.
            reason: Why it cannot be read; cut at 200 characters.
        """
        if len(self._unreadable) < _MAX_MESSAGES:
            self._unreadable[order] = topic
            self._reasons.setdefault(topic, reason[:_MAX_REASON])

    def lines(self) -> list[str]:
        """Return the added lines, then a line for each topic with unreadable messages.

        Of these topics, at most 100 get a line; it has the number of messages and a reason.
        """
        counts = Counter(self._unreadable.values())
        messages = [
            harmless(f"{topic}: messages that cannot be read: {counts[topic]} ({reason})")
            for topic, reason in self._reasons.items()
        ]
        return [*self._lines, *messages[:_MAX_LINES]]
