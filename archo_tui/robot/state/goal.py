"""A goal as it is shown."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, NamedTuple

from archo_tui.base.clock import Monotonic, UnixTime
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot_file.model import GoalKind

GIVEN_UP = 30.0  # Our choice: the seconds that a goal is LOST until its end is not awaited more.


class Phase(Enum):
    """The phase of a goal; the value is the word on the screen."""

    SENT = "SENT"
    REFUSED = "REFUSED"
    MOVING = "MOVING"
    CANCELLING = "CANCELLING"
    CANCELLED = "CANCELLED"
    ARRIVED = "ARRIVED"
    ABORTED = "ABORTED"
    UNKNOWN = "UNKNOWN"  # The server has not answered in time.
    LOST = "LOST"  # No server is found, or the feedback ended.
    DISPUTED = "ENDED"  # The status of the action and its result differ.
    GONE = "GONE"  # Its node has left: no message will tell how it ended.


_CODES = {  # Of the phases of ended goals.
    Phase.ARRIVED: Code.ARRIVED,
    Phase.CANCELLED: Code.CANCELLED,
    Phase.ABORTED: Code.ABORTED,
    Phase.REFUSED: Code.REFUSED,
    Phase.DISPUTED: Code.NOT_CONFIRMED,
    Phase.GONE: Code.TIMEOUT,
}
RUNNING = (Phase.SENT, Phase.MOVING, Phase.CANCELLING, Phase.UNKNOWN, Phase.LOST)


def values_text(kind: GoalKind, values: Mapping[str, Any]) -> str:
    """Return the values of a goal for people: `12` for a single one, else `x 1.5, y 2`."""
    if len(values) == 1:
        return text_of(*values.values())
    labels = {path: kind.form[path].label or path for path in values if path in kind.form}
    return ", ".join(f"{labels.get(path, path)} {text_of(v)}" for path, v in values.items())


# All of them our choice; times are in seconds.
_WAY_SPAN = 2.0  # The remaining ways of so long tell the present speed,
_WAY_STEP = 0.1  # one in so long,
_LEAST_WAY = 3  # and at least so many.
_LEAST_SHARE = 0.8  # Two speeds that differ by more are not one.
_LATE = 1.0  # An end that is so late was estimated wrongly.


class Goal(NamedTuple):
    """A goal of this console or of another client."""

    kind: GoalKind  # Its kind, in the robot file or made for `send_goal`.
    fields: Mapping[str, Any]  # The values that were typed, by dotted path.
    phase: Phase
    sent: Monotonic
    time: UnixTime  # The Unix time of the last change of its phase.
    length: float | None = None  # The length of the whole way, in the unit of `remaining`.
    # The way that is left by the last feedback, in the unit of the robot file.
    remaining: float | None = None
    heard: Monotonic | None = None  # When the last feedback or answer came.
    started: Monotonic | None = None  # When it was accepted.
    ended: Monotonic | None = None
    cancel_asked: Monotonic | None = None  # When its cancel was requested.
    lost: Monotonic | None = None  # Since when it is LOST.
    unreadable: str = ""  # The last remaining way as received, if it is none; else "".
    feedback: str = ""  # The last feedback as text, field by field.
    message: str = ""  # Why it ended, in the robot's words, or in the console's if there are none.
    mine: bool = True  # False for another client's goal, whose values are not on the graph.
    number: int = 0  # A number that no other goal of this session has.
    # True if `length` is the longest remaining way so far: no node tells it.
    length_is_guessed: bool = False
    result: Any = None  # The result message of the action; None before, and if none came.
    is_found: bool = False  # True if it was underway when it was first seen.
    # The remaining way of the last seconds, by which `seconds_left` goes: pairs of time and way,
    # oldest first.
    way: tuple[tuple[Monotonic, float], ...] = ()
    id: str = ""  # On the ROS graph, in hexadecimal digits; "" before it was sent.

    @property
    def target(self) -> str:
        """The values as typed: `12`, or `x 1.5, y 2`."""
        return values_text(self.kind, self.fields)

    @property
    def name(self) -> str:
        """The goal's name in a sentence: `shelf 12`, `fibonacci 10`, or `another client's goal`."""
        if not self.mine:
            return "another client's goal"
        return f"{self.kind.noun or self.kind.title.lower()} {self.target}".rstrip()

    @property
    def word(self) -> str:
        """The word for its phase on the screen; GONE reads `LOST`.

        A kind of goal without a noun in the robot file is RUNNING and SUCCEEDED instead of MOVING
        and ARRIVED.
        """
        if self.phase == Phase.GONE:
            return str(Phase.LOST.value)
        words = {} if self.kind.noun else {Phase.MOVING: "RUNNING", Phase.ARRIVED: "SUCCEEDED"}
        return words.get(self.phase, str(self.phase.value))

    @property
    def code(self) -> Code | None:
        """The code of its end: TIMEOUT for GONE, NOT_CONFIRMED for DISPUTED; None while it runs."""
        return _CODES.get(self.phase)

    def outcome_at(self, now: float) -> Outcome | None:
        """Return the outcome for a client that waits for the end; None while the goal runs.

        A goal that has been LOST for GIVEN_UP has the outcome TIMEOUT though it is still tracked:
        its end may never be reported.
        """
        if self.lost is not None and now - self.lost >= GIVEN_UP:
            silent = now - (self.heard or self.sent)
            reason = f"no word from it for {silent:.0f} s, the robot may still be moving"
            return Outcome(Code.TIMEOUT, f"goal lost: {reason}")
        if self.code is None:
            return None
        text = self.message or self.word.lower()
        return Outcome(self.code, f"goal lost: {text}" if self.phase == Phase.GONE else text)

    @property
    def is_running(self) -> bool:
        """True while its phase is one of RUNNING, which a goal that is LOST or UNKNOWN still is."""
        return self.phase in RUNNING

    def elapsed(self, now: float) -> float:
        """Return the seconds from its start to its end, or to `now` while it runs."""
        start = self.sent if self.started is None else self.started
        return (now if self.ended is None else self.ended) - start

    def seconds_left(self, now: float) -> float | None:
        """Return an estimate of the seconds to its end by its present speed; None without one."""
        if len(self.way) < _LEAST_WAY:
            return None
        (begun, before), (heard, left) = self.way[0], self.way[-1]
        recently = [at for at in self.way[:-1] if heard - at[0] >= (heard - begun) / 4]
        whole, present = (
            (away - left) / (heard - at) if heard > at else 0.0
            for at, away in ((begun, before), recently[-1])
        )
        if present <= 0 or not _LEAST_SHARE <= whole / present <= 1 / _LEAST_SHARE:
            return None
        seconds = left / present - (now - heard)
        return max(seconds, 0.0) if seconds > -_LATE else None

    def way_with(self, now: float, remaining: float) -> tuple[tuple[float, float], ...]:
        """Return `way` with one more remaining way, received at `now` in monotonic seconds."""
        way = self.way
        if len(way) > 1 and way[-1][0] - way[-2][0] < _WAY_STEP:
            way = way[:-1]
        recent = tuple(at for at in way if now - at[0] <= _WAY_SPAN)
        return (*(recent if len(recent) > _LEAST_WAY else way[-_LEAST_WAY:]), (now, remaining))

    def fraction(self) -> float:
        """Return the driven share of the way, 0 .. 1; 0 if it is not known."""
        if not self.length or self.remaining is None:
            return 0.0
        return min(max(1 - self.remaining / self.length, 0.0), 1.0)
