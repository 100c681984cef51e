"""An hour of a recording in memory, any moment of which can be shown within milliseconds."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from archo_tui.recording.console_recorder import JOURNAL
from archo_tui.replay.bag_file import BagMessage
from archo_tui.replay.replay_state import Checkpoint, ReplayState
from archo_tui.robot.state import OWN_LEVELS, Snapshot
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.station.history import History

SPAN = 3600.0  # Seconds.
_CHECKPOINT_EVERY = 250  # Messages.


class TimelineMark(NamedTuple):
    """An event or alarm on the time line."""

    time: float  # Unix time, in s.
    text: str


class Window:
    """The messages of a time span, with a checkpoint of the state at every few hundred.

    One thread fills it while another one reads.

    Attributes:
        begin: Unix time, in s.
        end: Unix time, in s; of 500,000 messages or more, `fill` makes it the time of the last one
            that it has taken.
        is_complete: True when `fill` is through, or `abort` was called.
        unreadable: The number of messages that could not be applied; `abort` counts as one.
        marks: The events and alarms read so far, in the order of reading.
        history: The samples of the trends, read so far.
    """

    def __init__(self, begin: float, end: float) -> None:
        """Create an empty window from one Unix time to another."""
        self.begin, self.end = begin, end
        self.is_complete = False  # True when all messages are read.
        self.unreadable = 0  # Messages that could not be applied.
        self.marks: list[TimelineMark] = []
        self.history = History()
        self._checkpoints: list[Checkpoint] = []
        self._messages: list[BagMessage] = []
        self._times: list[float] = []
        self._applied = -1  # Messages applied to the reader's state; -1: it has no checkpoint yet.
        self._is_cut = False  # True if there were too many messages for one window.
        self._last_time = begin  # The Unix time of the last `advance`.

    def fill(self, state: ReplayState, messages: Iterable[BagMessage]) -> Iterator[None]:
        """Take all messages, and record their marks and trends; set `is_complete` at the end.

        It is a generator that yields after each few hundred messages, so that the caller can give
        up. A message that cannot be applied is counted in `unreadable`.

        Args:
            state: A state before the first message, which nothing else uses.
            messages: The messages of the window, in the order of time.
        """
        second, alarms = self.begin, frozenset[str]()
        self._checkpoints.append(state.checkpoint())
        for number, message in enumerate(messages):
            if number % _CHECKPOINT_EVERY == 0:
                if number > 0:
                    self._checkpoints.append(state.checkpoint())
                yield
            while second <= message.time:  # As the console did, each second.
                snapshot = state.snapshot
                self.history.add_sample(snapshot, second)
                alarms = self._mark_alarms(state.alarms(snapshot, second), alarms)
                second += 1.0
            try:
                state.apply(*message)
                self.history.observe(state.curve_snapshot, message.time)
            except Exception:  # A hostile message may raise anything; the others are applied.
                self.unreadable += 1
            if message.topic == JOURNAL:
                self._mark_event(state.snapshot, message.time)
            self._messages.append(message)
            self._times.append(message.time)
        # A goal may have ended in the last part of a second.
        self.history.observe(state.snapshot, self.end)
        if self._is_cut and self._times:  # The next window reads the rest.
            self.end = self._times[-1]
        self.is_complete = True

    def cut(self) -> None:
        """Note that messages are missing before `end`: it becomes the time of the last one."""
        self._is_cut = True

    def abort(self) -> None:
        """End a reading that an error has stopped: what was read so far counts as everything.

        The error counts as one unreadable message.
        """
        self.unreadable += 1
        self.is_complete = True

    def _mark_event(self, snapshot: Snapshot, time: float) -> None:
        """Mark the last event if it is a command of somebody or the end of a goal."""
        event = snapshot.events[-1] if snapshot.events else None
        if event is not None and event.level in OWN_LEVELS:
            self.marks.append(TimelineMark(time, f"{event.level}: {event.text}"))

    def _mark_alarms(self, alarms: tuple[Alarm, ...], before: frozenset[str]) -> frozenset[str]:
        """Mark on the time line the alarms that have become unacknowledged.

        Args:
            alarms: All alarms at that time.
            before: The names that the last call returned.

        Returns:
            The names of the alarms that are active and unacknowledged, for the next call.
        """
        new = [alarm for alarm in alarms if alarm.state == AlarmState.UNACKNOWLEDGED]
        for alarm in new:
            if alarm.name not in before:
                self.marks.append(TimelineMark(max(alarm.since, self.begin), alarm.text))
        return frozenset(alarm.name for alarm in new)

    def covers(self, time: float) -> bool:
        """Return True if a Unix time is in the window and all messages up to it are read."""
        return self.begin <= time <= self.end and (
            self.is_complete or bool(self._times and time < self._times[-1])
        )

    def advance(self, state: ReplayState, time: float) -> None:
        """Bring a state forwards or backwards to a Unix time, for which `covers` has to be True.

        A message that cannot be applied is left out.

        Args:
            state: The same state at each call; it is restored from a checkpoint where that is
                nearer.
            time: Unix time, in s.
        """
        count = bisect_right(self._times, time)
        # Backwards, alarms evaluated during a later silence must be undone.
        is_back, self._last_time = time < self._last_time, time
        if is_back or not 0 <= count - self._applied <= _CHECKPOINT_EVERY or self._applied < 0:
            nearest = min(count // _CHECKPOINT_EVERY, len(self._checkpoints) - 1)
            state.restore(self._checkpoints[nearest])
            self._applied = nearest * _CHECKPOINT_EVERY
        for message in self._messages[self._applied : count]:
            try:
                state.apply(*message)
            except Exception:  # `fill` has counted it.
                continue
        self._applied = count

    def neighbour(self, time: float, step: int) -> float | None:
        """Return the time of the next message (1) or the one before (-1), of those read so far.

        Messages at `time` itself do not count. Return None if there is none.
        """
        after, before = bisect_right(self._times, time), bisect_left(self._times, time) - 1
        place = after if step > 0 else before
        return self._times[place] if 0 <= place < len(self._times) else None
