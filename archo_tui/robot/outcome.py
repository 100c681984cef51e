"""How a command ended: a word that programs read, and a text that people do."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class Code(str, Enum):
    """How it ended. The words are part of what other programs rely on: they do not change."""

    DONE = "done"
    ACCEPTED = "accepted"  # a goal: how it ends is told later
    ARRIVED = "arrived"
    REFUSED = "refused"  # by the robot, or because it cannot be done now
    ABORTED = "aborted"
    CANCELLED = "cancelled"  # or not sent at all: a STOP came after it, or the console ends
    HELD = "held"  # it waits, and is not sent by itself
    TIMEOUT = "timeout"  # no answer; it may have been done, or be done later
    NOT_OFFERED = "not_offered"  # nobody is there to do it
    NOT_CONFIRMED = "not_confirmed"  # answered, but not in a way that says yes or no
    WATCHING = "watching"
    MISUSE = "misuse"  # what was typed cannot be meant; nothing was sent


_GOOD = (Code.DONE, Code.ACCEPTED, Code.ARRIVED)


class Outcome(NamedTuple):
    """How a command ended, and why."""

    code: Code
    text: str

    @property
    def ok(self) -> bool:
        """True when it did what it was for, as far as that can be said by now."""
        return self.code in _GOOD
