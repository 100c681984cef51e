"""The player of a recording: its position, its speed, and the view of the console there."""

from __future__ import annotations

import os
import threading
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from math import floor
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from archo_tui.base.clock import Clock, time_of_day
from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import state_file
from archo_tui.recordings import store
from archo_tui.recordings.console import JOURNAL
from archo_tui.recordings.replay.bag import BagFile, BagMessage
from archo_tui.recordings.replay.state import (
    ROSOUT,
    Checkpoint,
    ReplayState,
)
from archo_tui.robot.state.events import OWN_LEVELS
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file import load
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.alarms import Alarm, AlarmBoard, AlarmState
from archo_tui.station.conditions import Situation, conditions
from archo_tui.station.history import History
from archo_tui.station.view import View
from archo_tui.text.event import event_text

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
_SPAN = 3600.0  # Seconds in memory.
_CHECKPOINT_EVERY = 250  # Messages.
_MAX_SILENCE = 3600  # Seconds without a message that are looked at.
_FRAME = 0.1  # Seconds between two updates while it plays or is being read.


class TimelineMark(NamedTuple):
    """Something that happened."""

    time: float  # Unix time, in s.
    text: str  # On the time line; "" for what only a report tells.
    line: str  # Of a report.


class _Window:
    """The messages of an hour, with checkpoints. One thread fills it while another one reads."""

    def __init__(self, begin: float, end: float) -> None:
        self.begin = begin
        self.end = end  # Of too many messages, `fill` makes it the time of the last one.
        self.is_complete = False  # True when all messages are read, or an error has ended that.
        self.unreadable = 0  # Messages that could not be applied; such an error counts as one.
        self.marks: list[TimelineMark] = []
        self.history = History()
        self._checkpoints: list[Checkpoint] = []
        self._messages: list[BagMessage] = []
        self._times: list[float] = []
        self._applied = -1  # Messages applied to the reader's state; -1: it has no checkpoint yet.
        self._is_cut = False  # True if there were too many messages for one window.
        self._second = begin  # That is looked at next.
        self._active = frozenset[str]()  # The names of the alarms that were not over then.
        # The alarms of each second in which no console has recorded its own.
        self._board = AlarmBoard()
        self._alarms: list[tuple[float, tuple[Alarm, ...]]] = [(begin, ())]

    def fill(self, state: ReplayState, messages: Iterable[BagMessage]) -> Iterator[None]:
        """Take all messages, their marks and trends; yield every few hundred: one may give up."""
        last_event = 0
        self._checkpoints.append(state.checkpoint())
        for number, message in enumerate(messages):
            if number % _CHECKPOINT_EVERY == 0:
                if number > 0:
                    self._checkpoints.append(state.checkpoint())
                yield
            self._pass_seconds(state, message.time)
            try:
                state.apply(*message)
                self.history.observe(state.curve_snapshot, message.time)
            except Exception:  # A hostile message may raise anything; the others are applied.
                self.unreadable += 1
            event = state.last_event if message.topic in (JOURNAL, ROSOUT) else None
            if event is not None and event.number > last_event:
                last_event = event.number
                text = f"{event.level}: {event.text}" if event.level in OWN_LEVELS else ""
                self.marks.append(TimelineMark(message.time, text, event_text(event)))
            self._messages.append(message)
            self._times.append(message.time)
        if self._is_cut and self._times:  # The next window reads the rest.
            self.end = self._times[-1]
        self._pass_seconds(state, self.end)
        # A goal may have ended in the last part of a second.
        self.history.observe(state.snapshot, self.end)
        self.is_complete = True

    def _pass_seconds(self, state: ReplayState, until: float) -> None:
        """Look at history and alarms as the console did, each second, in a silence for an hour."""
        seconds = range(max(floor(until - self._second) + 1, 0))
        for number in (*seconds[:_MAX_SILENCE], *seconds[_MAX_SILENCE:][-1:]):
            now, snapshot = self._second + number, state.snapshot
            self.history.observe(snapshot, now)
            if not state.has_console_state:
                found = conditions(Situation(snapshot, now))
                self._board.update(found.texts, now, now, unknown=found.unknown)
                self._alarms.append((now, self._board.all()))
            self._mark_alarms(state.alarms(snapshot, now, self._board.all()), now)
        self._second += len(seconds)

    def alarms_at(self, time: float) -> tuple[Alarm, ...]:
        """Return the alarms that a console would have raised by then; none if not read yet."""
        if not self.covers(time):
            return ()
        return self._alarms[max(bisect_right(self._alarms, time, key=itemgetter(0)) - 1, 0)][1]

    def _mark_alarms(self, alarms: tuple[Alarm, ...], now: float) -> None:
        active = {alarm.name: alarm for alarm in alarms if not alarm.is_over}
        for name, alarm in active.items():
            if name not in self._active and alarm.state == AlarmState.UNACKNOWLEDGED:
                since, line = max(alarm.since, self.begin), f"{alarm.priority.value}: {alarm.text}"
                self.marks.append(TimelineMark(since, alarm.text, line))
        for name in sorted(self._active - active.keys()):
            self.marks.append(TimelineMark(now, "", f"over: {name}"))
        self._active = frozenset(active)

    def cut(self) -> None:
        """Note that messages are missing before `end`: it becomes the time of the last one."""
        self._is_cut = True

    def abort(self) -> None:
        self.unreadable += 1
        self.is_complete = True

    def covers(self, time: float) -> bool:
        """Return True if a time is in the window and all messages up to it are read."""
        return self.begin <= time <= self.end and (
            self.is_complete or bool(self._times and time < self._times[-1])
        )

    def advance(self, state: ReplayState, time: float) -> None:
        """Bring a state, always the same one, to a time that `covers` has."""
        count = bisect_right(self._times, time)
        if not 0 <= count - self._applied <= _CHECKPOINT_EVERY or self._applied < 0:
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
        """Return the time of the next message (1) or the one before (-1); None if there is none."""
        after, before = bisect_right(self._times, time), bisect_left(self._times, time) - 1
        place = after if step > 0 else before
        return self._times[place] if 0 <= place < len(self._times) else None


class Player:
    """The player of one bag: a position in it, its speed, and what the console showed there.

    It is used on one thread. All times are Unix times.
    """

    def __init__(self, bag: BagFile, file: RobotFile, clock: Clock) -> None:
        """Pause at the start, and begin to read; `clock` is the machine's, by which it plays."""
        self.bag, self.file, self._clock = bag, file, clock
        self.start, self.end = bag.start, bag.end
        self.speed, self.is_playing = 1.0, False
        # A position, and the monotonic time at which it was reached.
        self._base, self._base_time = self.start, clock.monotonic()
        self._last_position = self._base  # The position at the last refresh.
        self._state = self._new_state()
        self._window = _Window(self.start, min(self.start + _SPAN, self.end))
        self._start_reading(self._window)

    def _new_state(self) -> ReplayState:
        return ReplayState(self.file, self.bag.types)

    def _start_reading(self, window: _Window) -> None:
        def read() -> None:
            state = self._new_state()
            messages = self.bag.messages(window.begin, window.end, state.topics, window.cut)
            try:
                for _ in window.fill(state, messages):
                    if window is not self._window:  # Another window has replaced this one.
                        return
            except Exception:  # A hostile file may raise anything; what was read is shown.
                window.abort()

        threading.Thread(target=read, name="replay", daemon=True).start()

    @property
    def position(self) -> float:
        """The time that is shown; while playing it moves on, up to the end."""
        if not self.is_playing:
            return self._base
        passed = self._clock.monotonic() - self._base_time
        return min(self._base + passed * self.speed, self.end)

    def go_to(self, time: float) -> None:
        """Move the position; outside of the loaded hour, begin to read there."""
        self._base = self._last_position = min(max(time, self.start), self.end)
        self._base_time = self._clock.monotonic()
        if not self._window.begin <= self._base <= self._window.end:
            # Where messages are too many for an hour, the last window was shorter.
            span = self._window.end - self._window.begin
            begin = max(self._base - span / 2, self.start)
            self._state = self._new_state()
            self._window = _Window(begin, min(begin + _SPAN, self.end))
            self._start_reading(self._window)

    def close(self) -> None:
        """End the reading; the player is of no use afterwards."""
        self._window = _Window(self.start, self.start)

    def play(self, *, on: bool) -> None:
        """Play, from the start if it is at the end, or pause."""
        self.go_to(self.start if on and self.position >= self.end else self.position)
        self.is_playing = on

    def refresh(self) -> None:
        """Keep up with the time while playing; hold where messages are still being read."""
        position = self.position
        if position > self._window.end:
            self.go_to(position)
        elif self.is_playing and self.is_reading:  # Wait, so that no message is skipped.
            self.go_to(self._last_position)
        elif self.is_playing and position >= self.end:
            self.play(on=False)
        self._last_position = self.position

    def change_speed(self, step: int) -> None:
        """Move the speed by so many entries of SPEEDS, not beyond its first or last."""
        self.go_to(self.position)
        index = SPEEDS.index(self.speed) + step
        self.speed = SPEEDS[min(max(index, 0), len(SPEEDS) - 1)]

    def step_message(self, step: int) -> None:
        """Pause, at the next loaded message (1) or the one before (-1) if there is one."""
        self.play(on=False)
        neighbour = self._window.neighbour(self.position, step)
        self.go_to(self.position if neighbour is None else neighbour)

    @property
    def marks(self) -> list[TimelineMark]:
        """The events and alarms of the loaded hour read so far, in the order of time."""
        shown = (mark for mark in self._window.marks if mark.text)
        return sorted(shown, key=itemgetter(0))

    def step_mark(self, step: int) -> TimelineMark | None:
        """Pause at the next loaded mark (1) or the one before (-1), if any, and return it."""
        here, marks = self.position, self.marks
        neighbour = [m for m in marks if (m.time > here if step > 0 else m.time < here)]
        if not neighbour:
            return None
        mark = neighbour[0] if step > 0 else neighbour[-1]
        self.play(on=False)
        self.go_to(mark.time)
        return mark

    @property
    def is_reading(self) -> bool:
        """True until the messages up to the position are read, or an error ends that."""
        return not self._window.covers(self.position)

    @property
    def is_complete(self) -> bool:
        """True when the loaded hour is read, or an error has ended its reading."""
        return self._window.is_complete

    @property
    def unreadable(self) -> int:
        """The number of messages of the loaded hour that could not be applied so far."""
        return self._window.unreadable

    async def follow(self, update: Callable[[], None]) -> None:
        """Call `update` ten times a second while the bag is played or read; never return."""
        showed_all = False
        while True:
            whole = self.is_complete  # A jump may begin to read another hour.
            if self.is_playing or not (whole and showed_all):
                update()
            showed_all = whole
            await self._clock.sleep(_FRAME)

    def snapshot(self) -> Snapshot:
        """Return the state of the robot at the position; an empty one until that is read."""
        return self._state_at(self.position).snapshot

    def _state_at(self, now: float) -> ReplayState:
        """Return the state at a time, which the next call changes; an empty one if not read yet."""
        if not self._window.covers(now):
            return self._new_state()
        self._window.advance(self._state, now)
        return self._state

    def view(self) -> View:
        """Return what the console showed at the position; an empty view until that is read."""
        now = self.position
        state = self._state_at(now)
        snapshot, console = state.snapshot, state.console
        return View(
            snapshot,
            now,
            # The history's samples are that far apart, from the beginning of what was read.
            self._window.begin + floor(now - self._window.begin),
            now,
            console.engine,
            snapshot.namespace,
            self._window.history,
            state.alarms(snapshot, now, self._window.alarms_at(now)),
            console.hosted,
            watching=True,
            queue=tuple(goal._replace(kind=state.goal_kind(goal.kind)) for goal in console.queue),
            held=console.held,
            clients=console.clients,
            replay=f"REPLAY {datetime.fromtimestamp(now):%Y-%m-%d %H:%M:%S}",
        )


_BEFORE_MARK = 5.0  # Seconds.
_MAX_FAULTS = 3  # In the error for a bag without a message.


def find_recording(given: str) -> Path:
    """Return the path of a recording: an existing path, a name, or for "" the newest."""
    # Unlike Path.exists, os.path.exists returns False for names that are too long.
    if given and (os.path.exists(given) or "/" in given):
        return Path(given)
    known = store.own_recordings()
    if not known:
        raise ArchoError(f"no recordings in {state_file('recordings')}: name a bag by its path")
    for recording in known:
        if given in ("", recording.name):
            return recording.folder
    raise ArchoError(f"no recording is called {given} (see archo-tui recordings)")


def open_bag(given: str) -> BagFile:
    """Open the bag that `find_recording` finds; raise ArchoError if no message can be in it."""
    bag = BagFile(find_recording(given))
    if not bag.count:
        faults = "".join(f"; {fault}" for fault in bag.faults[:_MAX_FAULTS])
        raise ArchoError(f"{bag.path}: no message is in it{faults}")
    return bag


def opening_time(path: Path, start: float) -> float:
    """Return the Unix time at which a replay opens: 5 s before the trigger, if that is known."""
    try:
        at = store.read_recording(path).at
    except (OSError, ValueError):  # Another tool's bag, or a single file.
        at = None
    return start if at is None else max(at - _BEFORE_MARK, start)


def load_robot_file(bag: BagFile, given: str) -> RobotFile:
    """Return the robot of a bag: the file given, else the one attached to the bag, else ARCHO."""
    if given:
        return load.load(Path(given))
    if bag.robot:
        return load.parse(bag.robot, bag.path / "robot.yaml")
    return load.load(load.default_path())


def make_player(bag: BagFile, robot: RobotFile, clock: Clock) -> Player:
    """Return the player of a bag, paused at its `opening_time`; it reads the disk."""
    player = Player(bag, robot, clock)
    player.go_to(opening_time(bag.path, bag.start))
    return player


# For `archo-tui replay --text`.


def report_lines(bag: BagFile, file: RobotFile) -> Iterator[str]:
    """Yield the lines of a report: the bag, its events and alarms by time, its faults."""
    seconds = bag.end - bag.start
    begin = datetime.fromtimestamp(bag.start)
    yield f"{bag.path.name}: {file.name}, {begin:%Y-%m-%d %H:%M:%S}, {seconds:.0f} s"
    window, state = _Window(bag.start, bag.end), ReplayState(file, bag.types)
    for _ in window.fill(state, bag.messages(bag.start, bag.end, state.topics)):
        pass
    for mark in sorted(window.marks, key=itemgetter(0)):  # An alarm is told after its beginning.
        yield f"{time_of_day(mark.time)}  {mark.line}"
    if window.unreadable:
        yield f"{window.unreadable} messages are unreadable"
    yield from bag.faults
