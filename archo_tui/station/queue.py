"""The queue: goals that are driven one after the other, and what holds them. Pure."""

from __future__ import annotations

from asyncio import Future
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.robot.asker import YOU, Asker
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Phase, Snapshot, values_text
from archo_tui.robot_file.model import GoalKind
from archo_tui.station.alarms import CONTACT_LOST, EMPTY, LOW, Alarm, State
from archo_tui.station.ledger import Ledger

_HOLDING = (CONTACT_LOST, LOW, EMPTY)  # the alarms that hold every queue
_WAS = "was: "  # before the name of one that is over, as in the banner


class QueuedGoal(NamedTuple):
    """A goal that is to be sent."""

    kind: GoalKind
    values: Mapping[str, Any]
    stops: int = 0  # that had been read when it was typed, or continued
    asker: Asker = YOU
    end: Future[Outcome] | None = None  # where somebody waits for how it ends

    @property
    def text(self) -> str:
        """`7`, or `x 1.5, y 2`."""
        return values_text(self.kind, self.values) or self.kind.title


class GoalQueue:
    """What is still to be driven. Held, nothing is sent until the operator says so."""

    def __init__(self, ledger: Ledger | None = None) -> None:
        """`ledger` knows the goal that is on its way to the robot."""
        self._ledger = Ledger() if ledger is None else ledger
        self.waiting: list[QueuedGoal] = []
        self.held = ""  # why
        self._seen: int | None = None  # the goal whose end was looked at last

    @property
    def is_going(self) -> bool:
        """True while something is sent, or will be by itself."""
        return self._ledger.goal is not None or (bool(self.waiting) and not self.held)

    def submit(self, goals: Sequence[QueuedGoal], snapshot: Snapshot) -> QueuedGoal | None:
        """The operator wants these: returns the first when it can be sent now; the rest waits."""
        if self._ledger.running_goal(snapshot) is not None:
            self.waiting += goals
            return None
        self.waiting += goals[1:]
        return self._begin(goals[0], snapshot)

    def resume(self, stops: int = 0) -> None:
        """Go on, whatever held it; so many STOPs had been read when that was said."""
        self.held = ""
        self.waiting = [wanted._replace(stops=stops) for wanted in self.waiting]

    def not_sent(self, wanted: QueuedGoal) -> None:
        """A STOP came before it left: it waits again."""
        self._ledger.drop()
        self.waiting.insert(0, wanted)
        self.hold("STOP")

    def drop(self) -> QueuedGoal:
        """Without the next one, which is returned."""
        return self.waiting.pop(0)

    def take_out(self, asker: Asker) -> list[QueuedGoal]:
        """Without those that this one asked for, which are returned."""
        out = [wanted for wanted in self.waiting if wanted.asker is asker]
        self.waiting = [wanted for wanted in self.waiting if wanted.asker is not asker]
        return out

    def hold(self, why: str) -> None:
        """Send nothing more."""
        if self.waiting and not self.held:
            self.held = why

    def answered(self, *, ok: bool, why: str = "refused") -> None:
        """Take the answer to the goal that was sent last; where it is not `ok`, hold the rest."""
        if not ok:
            self._ledger.drop()
            self.hold(why)

    def next(
        self, snapshot: Snapshot, alarms: Iterable[Alarm], stops: int = 0
    ) -> QueuedGoal | None:
        """What is to be sent now, taken out of the queue; `stops` have been read."""
        goal = snapshot.goal
        self._ledger.take(snapshot)
        ended = ""
        if goal is not None and not goal.is_running and goal.number != self._seen:
            self._seen = goal.number
            ended = "" if goal.phase == Phase.ARRIVED else goal.word.lower()
        if not self.waiting:
            self.held = ""
            return None
        if snapshot.is_stopped or any(wanted.stops < stops for wanted in self.waiting):
            self.held = "STOP"  # whether the goal that it ended is heard of before or after it
        else:
            self.hold(ended or _in_the_way(alarms))
        self._renew_reason(alarms)
        if self.held or self._ledger.running_goal(snapshot) is not None:
            return None
        return self._begin(self.waiting.pop(0), snapshot)

    def _renew_reason(self, alarms: Iterable[Alarm]) -> None:
        """Say of an alarm that held the queue whether it is over; only the operator goes on."""
        name = self.held.removeprefix(_WAS)
        if name in _HOLDING:
            stands = any(alarm.name == name and not alarm.is_over for alarm in alarms)
            self.held = name if stands else f"{_WAS}{name}"

    def _begin(self, wanted: QueuedGoal, snapshot: Snapshot) -> QueuedGoal:
        self._ledger.send(wanted.kind, wanted.values, snapshot)
        return wanted


def _in_the_way(alarms: Iterable[Alarm]) -> str:
    """The alarm that holds every queue."""
    for alarm in alarms:
        if alarm.name == CONTACT_LOST and not alarm.is_over:
            return CONTACT_LOST
        if alarm.name in (LOW, EMPTY) and alarm.state == State.UNACKNOWLEDGED:
            return alarm.name
    return ""
