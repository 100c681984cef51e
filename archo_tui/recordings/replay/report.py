"""The events of a recording line by line, for `archo-tui replay --text`."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from math import floor

from archo_tui.clock import time_of_day
from archo_tui.recordings.console import JOURNAL, STATE
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.replay.player import namespace_of
from archo_tui.recordings.replay.state import MAX_SILENCE, ROSOUT, ReplayState
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.text.event import event_text


def report_lines(bag: BagFile, file: RobotFile) -> Iterator[str]:
    """Yield the lines of a report: the bag, its events and alarms by time, its faults."""
    seconds = bag.end - bag.start
    begin = datetime.fromtimestamp(bag.start)
    yield f"{bag.path.name}: {file.name}, {begin:%Y-%m-%d %H:%M:%S}, {seconds:.0f} s"
    state = ReplayState(file, bag.types, namespace_of(bag, file))
    alarms, unreadable = frozenset[str](), 0
    second, topics, last_event = floor(bag.start), state.topics, 0
    for message in bag.messages(bag.start, bag.end, topics):
        if not state.has_console_state:  # Alarms may come and go while no message arrives.
            for quiet_second in range(second + 1, floor(message.time) + 1)[:MAX_SILENCE]:
                found = _active_alarms(state, float(quiet_second))
                yield from _alarm_changes(alarms, found, float(quiet_second))
                alarms = frozenset(found)
        try:
            state.apply(*message)
        except Exception:  # A hostile message may raise anything; the others are reported.
            unreadable += 1
            continue
        event = state.snapshot.events[-1:] if message.topic in (JOURNAL, ROSOUT) else ()
        if event and event[0].number > last_event:
            last_event = event[0].number
            yield f"{time_of_day(message.time)}  {event_text(event[0])}"
        if message.topic == STATE or floor(message.time) > second:
            second = floor(message.time)
            found = _active_alarms(state, message.time)
            yield from _alarm_changes(alarms, found, message.time)
            alarms = frozenset(found)
    if unreadable:
        yield f"{unreadable} messages are unreadable"
    yield from bag.faults


def _active_alarms(state: ReplayState, now: float) -> dict[str, Alarm]:
    """Return the alarms that are not over at a Unix time, by name."""
    return {alarm.name: alarm for alarm in state.alarms(state.snapshot, now) if not alarm.is_over}


def _alarm_changes(before: frozenset[str], found: dict[str, Alarm], time: float) -> Iterator[str]:
    """Yield a line for each alarm that is new and unacknowledged, and for each that is over."""
    now = time_of_day(time)
    for name, alarm in found.items():
        if name not in before and alarm.state == AlarmState.UNACKNOWLEDGED:
            yield f"{now}  {alarm.priority.value}: {alarm.text}"
    yield from (f"{now}  over: {name}" for name in sorted(before - found.keys()))
