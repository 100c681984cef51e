"""The queue of goals: they are driven one after the other, until something holds them. Pure."""

from __future__ import annotations

from asyncio import Future
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.requester import YOU, Requester
from archo_tui.robot.state import Phase, Snapshot, values_text
from archo_tui.robot_file.model import GoalKind
from archo_tui.station.alarms import BATTERY_ALARMS, CONTACT_LOST, Alarm, AlarmState
from archo_tui.station.ledger import Ledger

_HOLDING_ALARMS = (CONTACT_LOST, *BATTERY_ALARMS)
_WAS = "was: "  # Before the name of an alarm that is over, as in the banner.


class QueuedGoal(NamedTuple):
    """A goal that is to be sent.

    Attributes:
        kind: The robot file's entry for it.
        values: The values of the goal, by dotted path in the goal message.
        stop_count: STOPs that had been read when it was typed, or when the queue was resumed.
        requester: The person or program that requested it.
        end: A future, set to the goal's outcome when it has ended, or to HELD when the queue is
            held; None if nobody waits for that.
        list_number: The number of the list of goals in which it was typed.
        is_first: True if it is the first of its list, without which the others are not driven.
    """

    kind: GoalKind
    values: Mapping[str, Any]
    stop_count: int = 0
    requester: Requester = YOU
    end: Future[Outcome] | None = None
    list_number: int = 0
    is_first: bool = False

    @property
    def text(self) -> str:
        """The values for people, as `7` or `x 1.5, y 2`; without values the goal's title."""
        return values_text(self.kind, self.values) or self.kind.title


class GoalQueue:
    """The goals that are still to be sent. A held queue sends nothing until it is resumed.

    Attributes:
        waiting: The goals, the next one first.
        hold_reason: The reason why the queue is held, in words; "" if it is not.
    """

    def __init__(self, ledger: Ledger | None = None) -> None:
        """Make an empty queue.

        Args:
            ledger: Knows the goal that is on its way to the robot; None for one of its own.
        """
        self._ledger = Ledger() if ledger is None else ledger
        self.waiting: list[QueuedGoal] = []
        self.hold_reason = ""
        self._last_ended: int | None = None  # The number of the ended goal that was taken in last.

    @property
    def is_going(self) -> bool:
        """True if a goal is on its way to the robot, or goals wait and the queue is not held."""
        return self._ledger.goal is not None or (bool(self.waiting) and not self.hold_reason)

    def submit(self, goals: Sequence[QueuedGoal], snapshot: Snapshot) -> QueuedGoal | None:
        """Add goals that the operator wants, behind those that wait.

        If no goal runs or is on its way, the first one is entered in the ledger and goes before all
        others, also if the queue is held.

        Args:
            goals: At least one.
            snapshot: The state of the robot.

        Returns:
            The first goal, which the caller has to send now; None if all goals wait.
        """
        if self._ledger.running_goal(snapshot) is not None:
            self.waiting += goals
            return None
        self.waiting += goals[1:]
        return self._send(goals[0], snapshot)

    def resume(self, stop_count: int = 0) -> None:
        """End the hold of the queue, whatever its reason; the next `take_due` may hold it again.

        Args:
            stop_count: STOPs that had been read when the operator resumed. The goals count as
                typed then, so that only a later STOP holds them.
        """
        self.hold_reason = ""
        self.waiting = [goal._replace(stop_count=stop_count) for goal in self.waiting]

    def put_back(self, goal: QueuedGoal) -> None:
        """Put a goal that was not sent because of a STOP back in front, and hold the queue.

        The goal is removed from the ledger. A queue that is held already keeps its reason.
        """
        self._ledger.remove_goal()
        self.waiting.insert(0, goal)
        self.hold("STOP")

    def skip_next(self) -> QueuedGoal:
        """Remove the next goal and return it; the queue must not be empty."""
        return self.waiting.pop(0)

    def remove(self, is_meant: Callable[[QueuedGoal], bool]) -> list[QueuedGoal]:
        """Remove the goals for which `is_meant` is true, and return them."""
        removed = list(filter(is_meant, self.waiting))
        self.waiting = [goal for goal in self.waiting if not is_meant(goal)]
        return removed

    def restore(self, goals: Sequence[QueuedGoal]) -> None:
        """Take over the goals of the process before a restart; they are held."""
        self.waiting = [*goals]
        self.hold("restart")

    def hold(self, reason: str) -> None:
        """Hold the queue: no further goal is sent until it is resumed.

        An empty queue, or one that is held already, stays as it is.

        Args:
            reason: The reason in words; "" changes nothing.
        """
        if self.waiting and not self.hold_reason:
            self.hold_reason = reason

    def on_answer(self, *, ok: bool, reason: str = "refused") -> None:
        """Hold the queue and remove the goal from the ledger, if the robot did not accept it.

        An accepted goal stays in the ledger until a snapshot shows it.

        Args:
            ok: True if the robot accepted the goal that was sent last: nothing changes.
            reason: The reason of the hold.
        """
        if not ok:
            self._ledger.remove_goal()
            self.hold(reason)

    def take_due(
        self, snapshot: Snapshot, alarms: Iterable[Alarm], stop_count: int = 0
    ) -> QueuedGoal | None:
        """Remove and return the goal that is to be sent now, and enter it in the ledger.

        The queue is held here if the last goal, whoever sent it, ended without arriving, the robot
        is stopped, a STOP was read since a goal was typed, or an alarm holds every queue. An empty
        queue is not held any more. The ledger's goal is removed if the snapshot shows it.

        Args:
            snapshot: The state of the robot.
            alarms: All alarms that are on the board.
            stop_count: STOPs that have been read by now.

        Returns:
            The goal; None if the queue is empty or held, or a goal runs or is on its way.
        """
        goal = snapshot.goal
        self._ledger.remove_goal_if_shown(snapshot)
        failure = ""
        if goal is not None and not goal.is_running and goal.number != self._last_ended:
            self._last_ended = goal.number
            failure = "" if goal.phase == Phase.ARRIVED else goal.word.lower()
        if not self.waiting:
            self.hold_reason = ""
            return None
        if snapshot.is_stopped or any(goal.stop_count < stop_count for goal in self.waiting):
            # Also over the reason of a goal that this STOP ended, which may be heard of before it.
            self.hold_reason = "STOP"
        else:
            self.hold(failure or _holding_alarm(alarms))
        self._mark_past_alarm(alarms)
        if self.hold_reason or self._ledger.running_goal(snapshot) is not None:
            return None
        return self._send(self.waiting.pop(0), snapshot)

    def _mark_past_alarm(self, alarms: Iterable[Alarm]) -> None:
        """Update the reason of the hold: `was: NAME` while the alarm that held the queue is over.

        The queue stays held: only the operator resumes it. Other reasons stay as they are.
        """
        name = self.hold_reason.removeprefix(_WAS)
        if name in _HOLDING_ALARMS:
            is_active = any(alarm.name == name and not alarm.is_over for alarm in alarms)
            self.hold_reason = name if is_active else f"{_WAS}{name}"

    def _send(self, goal: QueuedGoal, snapshot: Snapshot) -> QueuedGoal:
        self._ledger.enter_goal(goal.kind, goal.values, snapshot)
        return goal


def _holding_alarm(alarms: Iterable[Alarm]) -> str:
    """Return the name of the first alarm that holds every queue; "" if there is none.

    These are a lost contact, acknowledged or not, and a low or empty battery whose alarm is active
    and not acknowledged.
    """
    for alarm in alarms:
        if alarm.name == CONTACT_LOST and not alarm.is_over:
            return CONTACT_LOST
        if alarm.name in BATTERY_ALARMS and alarm.state == AlarmState.UNACKNOWLEDGED:
            return alarm.name
    return ""
