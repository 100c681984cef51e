"""A part of a recording, held in memory: any moment of it within milliseconds."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from archo_tui.recording.console_recorder import JOURNAL
from archo_tui.replay.bag_file import Said
from archo_tui.replay.held import MOST_MESSAGES
from archo_tui.replay.story import Kept, Story
from archo_tui.robot.state import OWN_LEVELS, Snapshot
from archo_tui.station.alarms import Alarm
from archo_tui.station.alarms import State as AlarmState
from archo_tui.station.history import History

SPAN = 3600.0  # s that are held at a time
_EACH = 250  # messages between two moments from which the story can be told on


class Mark(NamedTuple):
    """Something happened."""

    time: float  # Unix time
    text: str


class Window:
    """The messages from `begin` on; one thread adds, another one looks."""

    def __init__(self, begin: float, end: float) -> None:
        """Unix times."""
        self.begin, self.end = begin, end
        self.is_whole = False  # all of it is here
        self.unreadable = 0  # messages that say nonsense
        self.marks: list[Mark] = []
        self.history = History()
        self._kept: list[Kept] = []  # before each _EACH messages
        self._said: list[Said] = []
        self._times: list[float] = []
        self._applied = -1  # how many messages the story of who looks has been told; -1: none yet
        self._told = begin  # up to which time

    def fill(self, story: Story, messages: Iterable[Said]) -> Iterator[None]:
        """Take what is in it, with a story of its own; gives others a turn after each _EACH."""
        second, alarms = self.begin, frozenset[str]()
        for number, said in enumerate(messages):
            if number % _EACH == 0:
                self._kept.append(story.kept())
                yield
            while second <= said.time:  # as the console did, each second
                snapshot = story.snapshot
                self.history.add(snapshot, second)
                alarms = self._mark_alarms(story.alarms(snapshot, second), alarms, second)
                second += 1.0
            try:
                story.apply(*said)
                self.history.take(story.readings, said.time)
            except Exception:  # whatever a file says: the others are told
                self.unreadable += 1
            if said.topic == JOURNAL:
                self._mark_event(story.snapshot, said.time)
            self._said.append(said)
            self._times.append(said.time)
        self.history.take(story.snapshot, self.end)  # what ended in the last, broken second
        if len(self._said) >= MOST_MESSAGES:  # the rest is read when it is asked for
            self.end = self._times[-1]
        self._kept = self._kept or [story.kept()]
        self.is_whole = True

    def give_up(self) -> None:
        """It cannot be read on."""
        self.unreadable += 1
        self.is_whole = bool(self._kept)

    def _mark_event(self, snapshot: Snapshot, time: float) -> None:
        """What somebody commanded, and how a goal ended."""
        event = snapshot.events[-1] if snapshot.events else None
        if event is not None and event.level in OWN_LEVELS:
            self.marks.append(Mark(time, f"{event.level}: {event.text}"))

    def _mark_alarms(
        self, alarms: tuple[Alarm, ...], before: frozenset[str], time: float
    ) -> frozenset[str]:
        """Those that came since."""
        new = [alarm for alarm in alarms if alarm.state == AlarmState.UNACKNOWLEDGED]
        for alarm in new:
            if alarm.name not in before:
                self.marks.append(Mark(max(alarm.since, self.begin), alarm.text))
        return frozenset(alarm.name for alarm in new)

    def has(self, time: float) -> bool:
        """True when that moment is here, or never comes."""
        return self.begin <= time <= self.end and (
            self.is_whole or bool(self._times and time < self._times[-1])
        )

    def tell(self, story: Story, time: float) -> None:
        """Bring the story to that time, from the nearest moment that is kept."""
        count = bisect_right(self._times, time)
        # back: it may have looked for alarms in a silence that was not so long then
        is_back, self._told = time < self._told, time
        if is_back or not 0 <= count - self._applied <= _EACH or self._applied < 0:
            nearest = min(count // _EACH, len(self._kept) - 1)
            story.put_back(self._kept[nearest])
            self._applied = nearest * _EACH
        for said in self._said[self._applied : count]:
            try:
                story.apply(*said)
            except Exception:  # counted as it was taken
                continue
        self._applied = count

    def beside(self, time: float, step: int) -> float | None:
        """The time of the message before (-1) or after (1) that one."""
        after, before = bisect_right(self._times, time), bisect_left(self._times, time) - 1
        place = after if step > 0 else before
        return self._times[place] if 0 <= place < len(self._times) else None
