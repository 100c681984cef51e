"""The events that begin a recording. Pure functions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.station.alarms import Alarm, AlarmState, Priority
from archo_tui.station.view import View

STOP = "STOP"


def reasons_to_record(before: View, now: View, changed: Sequence[Alarm]) -> list[str]:
    """Return why the last minute is worth recording, in a few words each; mostly none.

    Args:
        before: The view of the last call.
        now: The view of this one.
        changed: Alarms whose state differs from the last call.
    """
    return [*_stop_reasons(before, now), *_alarm_reasons(changed), *_goal_reasons(before, now)]


def _stop_reasons(before: View, now: View) -> Iterator[str]:
    """Yield STOP if anybody sent it since, or if the robot reports a stop and did not before."""
    old, new = before.snapshot, now.snapshot
    stops_now = new.motion.stopped and old.motion.received is not None and not old.motion.stopped
    if (
        stops_now
        or (new.open_stop is not None and old.open_stop is None)
        or _has_new_stop_event(old, new)
    ):
        yield STOP


def _has_new_stop_event(old: Snapshot, new: Snapshot) -> bool:
    """Return True if an event after `old` tells of a STOP, which may be over by now."""
    if new.events is old.events:
        return False
    known = max((event.number for event in old.events), default=0)
    since = (event.audit_record for event in new.events if event.number > known)
    return any(record is not None and record.verb == "stop" for record in since)


def _alarm_reasons(changed: Sequence[Alarm]) -> Iterator[str]:
    """Yield each alarm of high priority that has become active."""
    for alarm in changed:
        if alarm.priority == Priority.HIGH and alarm.state == AlarmState.UNACKNOWLEDGED:
            yield alarm.name


def _goal_reasons(before: View, now: View) -> Iterator[str]:
    """Yield each accepted goal that ended neither arrived nor cancelled by an operator."""
    known = max((goal.number for goal in before.snapshot.history), default=0)
    for goal in reversed(now.snapshot.history):
        if goal.number > known and _failed(goal):
            yield f"{goal.name}: {goal.word.lower()}"


def _failed(goal: Goal) -> bool:
    called_off = goal.phase == Phase.CANCELLED and goal.cancel_asked is not None
    return goal.started is not None and goal.phase != Phase.ARRIVED and not called_off
