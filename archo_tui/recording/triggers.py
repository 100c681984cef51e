"""What makes the black box write. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.station.alarms import Alarm, Priority, State
from archo_tui.station.station import View

STOP = "STOP"


def happened(before: View, now: View, changed: Sequence[Alarm]) -> list[str]:
    """Why the last minute is to be kept, in a few words each; nothing when it is as any other."""
    return [*_stops(before, now), *_alarms(changed), *_goals(before, now)]


def _stops(before: View, now: View) -> Iterator[str]:
    """Whoever pressed it; or the robot says that it is stopped, and did not."""
    old, new = before.snapshot, now.snapshot
    stops_now = new.motion.stopped and old.motion.received is not None and not old.motion.stopped
    if stops_now or (new.open_stop is not None and old.open_stop is None) or _said(old, new):
        yield STOP


def _said(old: Snapshot, new: Snapshot) -> bool:
    """True when somebody has said it since: it may be confirmed between two looks."""
    if new.events is old.events:
        return False
    known = max((event.number for event in old.events), default=0)
    since = (event.act for event in new.events if event.number > known)
    return any(act is not None and act.verb == "stop" for act in since)


def _alarms(changed: Sequence[Alarm]) -> Iterator[str]:
    """Grave ones that have come: lost contact, a crashed node, an empty battery, and others."""
    for alarm in changed:
        if alarm.priority == Priority.HIGH and alarm.state == State.UNACKNOWLEDGED:
            yield alarm.name


def _goals(before: View, now: View) -> Iterator[str]:
    """Those that were accepted and ended neither arrived nor called off."""
    known = max((goal.number for goal in before.snapshot.history), default=0)
    for goal in reversed(now.snapshot.history):
        if goal.number > known and _failed(goal):
            yield f"{goal.name}: {goal.word.lower()}"


def _failed(goal: Goal) -> bool:
    called_off = goal.phase == Phase.CANCELLED and goal.cancel_asked is not None
    return goal.started is not None and goal.phase != Phase.ARRIVED and not called_off
