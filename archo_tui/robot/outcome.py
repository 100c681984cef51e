"""How a command ended: a word that programs read, and a text that people do."""

from __future__ import annotations

from enum import Enum
from typing import Any, NamedTuple

CALL_WAIT = 30.0  # s that the answer of a service is waited for that is called by its name
# of a request that nobody waits for any more
NOT_TAKEN_BACK = "waiting no longer: the robot may still do it"


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


class Answer(Outcome):
    """The outcome of a call that was answered; `message` is the answer."""

    message: Any

    @classmethod
    def of(cls, outcome: Outcome, message: Any) -> Answer:
        """Return that outcome with an answer."""
        made = cls(*outcome)
        made.message = message
        return made


def answer_of(outcome: Outcome) -> Any:
    """Return the message that a service has answered; None: the outcome has none."""
    return outcome.message if isinstance(outcome, Answer) else None
