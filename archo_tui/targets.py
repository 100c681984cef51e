"""The queue: goals that are driven one after the other, and what holds them. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.alarms import CONTACT_LOST, EMPTY, LOW, Alarm, State
from archo_tui.robot.state import Phase, Snapshot, target
from archo_tui.robots.model import GoalKind


class Target(NamedTuple):
    """A goal that is to be sent."""

    kind: GoalKind
    values: Mapping[str, Any]
    stops: int = 0  # that had been read when it was typed, or continued

    @property
    def text(self) -> str:
        """`7`, or `x 1.5, y 2`."""
        return target(self.kind, self.values) or self.kind.title


class Targets:
    """What is still to be driven. Held, nothing is sent until the operator says so."""

    def __init__(self) -> None:
        self.waiting: list[Target] = []
        self.held = ""  # why
        self._seen: int | None = None  # the goal whose end was looked at last
        self._sending = False  # the robot has not answered yet, or its goal is not seen yet
        self._before: int | None = None  # the goal before the one that is being sent

    @property
    def is_going(self) -> bool:
        """True while something is sent, or will be by itself."""
        return self._sending or (bool(self.waiting) and not self.held)

    def submit(self, targets: Sequence[Target], snapshot: Snapshot) -> Target | None:
        """The operator wants these: returns the first when it can be sent now; the rest waits."""
        if self._sending or snapshot.running_goal is not None:
            self.waiting += targets
            return None
        self.waiting += targets[1:]
        return self._begin(targets[0], snapshot)

    def resume(self, stops: int = 0) -> None:
        """Go on, whatever held it; so many STOPs had been read when that was said."""
        self.held = ""
        self.waiting = [target._replace(stops=stops) for target in self.waiting]

    def not_sent(self, target: Target) -> None:
        """A STOP came before it left: it waits again."""
        self._sending = False
        self.waiting.insert(0, target)
        self.hold("STOP")

    def drop(self) -> None:
        """Without the next one."""
        del self.waiting[:1]

    def hold(self, why: str) -> None:
        """Send nothing more."""
        if self.waiting and not self.held:
            self.held = why

    def answered(self, *, ok: bool) -> None:
        """The robot has answered what was sent last."""
        if not ok:
            self._sending = False
            self.hold("refused")

    def next(self, snapshot: Snapshot, alarms: Iterable[Alarm], stops: int = 0) -> Target | None:
        """What is to be sent now, taken out of the queue; `stops` have been read."""
        goal = snapshot.goal
        if goal is not None and goal.number != self._before:
            self._sending = False
        ended = ""
        if goal is not None and not goal.is_running and goal.number != self._seen:
            self._seen = goal.number
            ended = "" if goal.phase == Phase.ARRIVED else goal.word.lower()
        if not self.waiting:
            self.held = ""
            return None
        if _is_stopped(snapshot) or any(target.stops < stops for target in self.waiting):
            self.held = "STOP"  # whether the goal that it ended is heard of before or after it
        else:
            self.hold(ended or _in_the_way(alarms))
        if self.held or self._sending or snapshot.running_goal is not None:
            return None
        return self._begin(self.waiting.pop(0), snapshot)

    def _begin(self, target: Target, snapshot: Snapshot) -> Target:
        self._sending = True
        self._before = None if snapshot.goal is None else snapshot.goal.number
        return target


def _is_stopped(snapshot: Snapshot) -> bool:
    return snapshot.open_stop is not None or bool(snapshot.motion.stopped)


def _in_the_way(alarms: Iterable[Alarm]) -> str:
    """The alarm that holds every queue."""
    for alarm in alarms:
        if alarm.name == CONTACT_LOST and not alarm.is_over:
            return CONTACT_LOST
        if alarm.name in (LOW, EMPTY) and alarm.state == State.UNACKNOWLEDGED:
            return alarm.name
    return ""
