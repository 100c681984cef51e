"""A STOP: not confirmed yet, or the last one that was."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class StopAnswer(Enum):
    """The answer so far to a STOP that is not confirmed; the value is the word for it."""

    AWAITED = ""
    NONE = "no answer"  # Not from every server in time.
    NOT_SENT = "NOT SENT"
    REFUSED = "REFUSED"
    UNCONFIRMED = "ANSWERED, NOT CONFIRMED"


class OpenStop(NamedTuple):
    """A STOP that was requested and that the robot has not confirmed."""

    asked: float  # When it was requested, in monotonic seconds; a repeat does not change it.
    answer: StopAnswer = StopAnswer.AWAITED  # The answer so far.
    why: str = ""  # Details of the answer for people; "" if there are none.


class Latch(Enum):
    """The state of the last STOP that the robot or another console has reported as confirmed."""

    NONE = "none"  # There was none, or it was released.
    HELD = "held"
    UNCERTAIN = "uncertain"  # It may no longer hold; `Snapshot.latch_doubt` says why.
