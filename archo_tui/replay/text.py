"""What happened in a recording, line by line, for a report."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from math import floor

from archo_tui.clock import time_of_day
from archo_tui.recording.console_recorder import JOURNAL, STATE
from archo_tui.replay.bag_file import BagFile
from archo_tui.replay.player import named
from archo_tui.replay.story import LONGEST, ROSOUT, Story
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.alarms import Alarm, State
from archo_tui.words.event import event_text


def lines(bag: BagFile, file: RobotFile) -> Iterator[str]:
    """First what it is; then events and alarms with their times; last what could not be read."""
    seconds = bag.end - bag.start
    begin = datetime.fromtimestamp(bag.start)
    yield f"{bag.path.name}: {file.name}, {begin:%Y-%m-%d %H:%M:%S}, {seconds:.0f} s"
    story, alarms, unreadable = Story(file, bag.types, named(bag, file)), frozenset[str](), 0
    second, wanted, told = floor(bag.start), story.wanted, 0  # the number of the last event
    for said in bag.messages(bag.start, bag.end, wanted):
        if not story.is_ours:  # an alarm may come and go where no message says anything
            for each in range(second + 1, floor(said.time) + 1)[:LONGEST]:
                found = _alarms(story, float(each))
                yield from _changes(alarms, found, float(each))
                alarms = frozenset(found)
        try:
            story.apply(*said)
        except Exception:  # whatever a file says: the others are told
            unreadable += 1
            continue
        event = story.snapshot.events[-1:] if said.topic in (JOURNAL, ROSOUT) else ()
        if event and event[0].number > told:
            told = event[0].number
            yield f"{time_of_day(said.time)}  {event_text(event[0])}"
        if said.topic == STATE or floor(said.time) > second:
            second = floor(said.time)
            found = _alarms(story, said.time)
            yield from _changes(alarms, found, said.time)
            alarms = frozenset(found)
    if unreadable:
        yield f"{unreadable} messages are unreadable"
    yield from bag.faults


def _alarms(story: Story, now: float) -> dict[str, Alarm]:
    """Those whose condition holds at that Unix time, by name."""
    return {one.name: one for one in story.alarms(story.snapshot, now) if not one.is_over}


def _changes(before: frozenset[str], found: dict[str, Alarm], time: float) -> Iterator[str]:
    """Which of them came, and which are over."""
    now = time_of_day(time)
    for name, alarm in found.items():
        if name not in before and alarm.state == State.UNACKNOWLEDGED:
            yield f"{now}  {alarm.priority.value}: {alarm.text}"
    yield from (f"{now}  over: {name}" for name in sorted(before - found.keys()))
