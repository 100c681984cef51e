"""What of a bag cannot be read, said once each and in a bounded number of lines."""

from __future__ import annotations

from collections import Counter

from archo_tui.robot.text import harmless

_MOST_LINES = 100
_MOST_MESSAGES = 100_000  # that are told apart; a higher count is of no use
_LONGEST = 200  # characters of why


class Faults:
    """Collects them."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}  # in order, each once
        self._unreadable: dict[tuple[int, int], str] = {}  # topics of such messages, by place
        self._why: dict[str, str] = {}  # the first one of a topic cannot be read

    def add(self, said: str) -> None:
        """A line, which is made safe for a terminal."""
        said = harmless(said)
        if said not in self._lines:
            self._lines[said if len(self._lines) < _MOST_LINES else "and more"] = None

    def add_message(self, topic: str, place: tuple[int, int], why: str) -> None:
        """One that cannot be read; it counts once, however often that is tried."""
        if len(self._unreadable) < _MOST_MESSAGES:
            self._unreadable[place] = topic
            self._why.setdefault(topic, why[:_LONGEST])

    def lines(self) -> list[str]:
        """All of them; of messages, a line for each topic."""
        counts = Counter(self._unreadable.values())
        messages = [
            harmless(f"{topic}: messages that cannot be read: {counts[topic]} ({why})")
            for topic, why in self._why.items()
        ]
        return [*self._lines, *messages[:_MOST_LINES]]
