"""A node on the graph: when its messages came, what it has, and the level of its log."""

from __future__ import annotations

from typing import Any, NamedTuple

LEVELS = {"UNSET": 0, "DEBUG": 10, "INFO": 20, "WARN": 30, "ERROR": 40, "FATAL": 50}
_WORDS = {number: word for word, number in LEVELS.items() if number}

Names = tuple[tuple[str, str], ...]  # Each with its type.


class NodeState(NamedTuple):
    """A node on the graph.

    Recordings have the names of the attributes.
    """

    name: str
    heard: float | None = None  # When its last message or log line came, in monotonic seconds.
    rate: float | None = None  # The rate in Hz of its messages that the console reads.
    # The state of a managed node, as `inactive`, or `inactive, no answer` if it did not answer the
    # last question; "" if it is not managed, or was not asked yet.
    lifecycle: str = ""

    def is_silent(self, now: float) -> bool:
        """Return True if nothing was received for three intervals of its rate, at least 2.5 s.

        Before the first message, or without a rate, it is False.
        """
        if self.heard is None or not self.rate:
            return False
        return now - self.heard > max(3 / self.rate, 2.5)


def level_word(number: Any) -> str:
    """Return the word for a log message's level: 10 is `DEBUG`; INFO for anything unknown."""
    return _WORDS.get(number, "INFO") if isinstance(number, int) else "INFO"


class LogLevel(NamedTuple):
    """The level of a node's log, as words of LEVELS."""

    own: str  # The level that was set for it; UNSET if none was.
    in_force: str  # The level that holds: its own, or that of its process.

    @property
    def text(self) -> str:
        """The level as text: `DEBUG and above`, or `INFO and above, the level of its process`."""
        process = ", the level of its process" if self.own == "UNSET" else ""
        return f"{self.in_force} and above{process}"


class NodeInfo(NamedTuple):
    """The topics, services and actions of one node, without those that every node has."""

    publishes: Names = ()  # The topics that it publishes.
    subscribes: Names = ()  # The topics to which it subscribes.
    serves: Names = ()  # The services that it serves.
    calls: Names = ()  # The services for which it has a client.
    actions: Names = ()  # The actions that it serves.
    sends: Names = ()  # The actions for which it has a client.
    transitions: tuple[str, ...] = ()  # The transitions that a managed node can make now.
    level: LogLevel | None = None  # The level of its log; None if the node does not report it.
    no_level: str = ""  # Why `level` is None; "" if it is not.
