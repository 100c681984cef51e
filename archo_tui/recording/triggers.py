"""The events that begin a recording. Pure functions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.station.alarms import Alarm, AlarmState, Priority
from archo_tui.station.view import View

STOP = "STOP"


def reasons_to_record(before: View, now: View, changed: Sequence[Alarm]) -> list[str]:
    """Return the reasons to begin or prolong a recording, in a few words each; mostly none.

    They are a STOP, an alarm of high priority that is active and unacknowledged, and a goal that
    failed.

    Args:
        before: The view of the last call.
        now: The view of this one.
        changed: Alarms whose state differs from the last call.
    """
    return [*_stop_reasons(before, now), *_alarm_reasons(changed), *_goal_reasons(before, now)]


def _stop_reasons(before: View, now: View) -> Iterator[str]:
    """Yield `STOP` if anybody sent a STOP since `before`, or the robot reports a new stop.

    A stop that the robot reported from the beginning on is not new.
    """
    old, new = before.snapshot, now.snapshot
    stops_now = new.motion.stopped and old.motion.received is not None and not old.motion.stopped
    if (
        stops_now
        or (new.open_stop is not None and old.open_stop is None)
        or _has_new_stop_event(old, new)
    ):
        yield STOP


def _has_new_stop_event(old: Snapshot, new: Snapshot) -> bool:
    """Return True if an event that `old` lacks tells of a STOP, which may be over by now."""
    if new.events is old.events:
        return False
    known = max((event.number for event in old.events), default=0)
    since = (event.audit_record for event in new.events if event.number > known)
    return any(record is not None and record.verb == "stop" for record in since)


def _alarm_reasons(changed: Sequence[Alarm]) -> Iterator[str]:
    """Yield the name of each alarm of high priority that is active and unacknowledged."""
    for alarm in changed:
        if alarm.priority == Priority.HIGH and alarm.state == AlarmState.UNACKNOWLEDGED:
            yield alarm.name


def _goal_reasons(before: View, now: View) -> Iterator[str]:
    """Yield name and end of each goal that has failed since `before`, the oldest first.

    A goal has failed if it had started, and neither arrived nor was cancelled by request.
    """
    known = max((goal.number for goal in before.snapshot.history), default=0)
    for goal in reversed(now.snapshot.history):
        if goal.number > known and _failed(goal):
            yield f"{goal.name}: {goal.word.lower()}"


def _failed(goal: Goal) -> bool:
    called_off = goal.phase == Phase.CANCELLED and goal.cancel_asked is not None
    return goal.started is not None and goal.phase != Phase.ARRIVED and not called_off
