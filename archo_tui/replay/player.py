"""The player of a recording: its position, its speed, and the view of the console there."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import datetime
from math import floor

from archo_tui.clock import Clock
from archo_tui.recording.console_recorder import STATE
from archo_tui.recording.state import RecordedGoal
from archo_tui.replay.bag_file import BagFile
from archo_tui.replay.replay_state import ReplayState
from archo_tui.replay.topics import guess_namespace
from archo_tui.replay.window import SPAN, TimelineMark, Window
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.state import Snapshot
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.view import View

_FRAME = 0.1  # Seconds between two updates while it plays or is being read.
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)


class Player:
    """The player of one bag: a position in it, its speed, and what the console showed there.

    It is used on one thread, and reads an hour of the bag at a time on another.

    Attributes:
        bag: The bag.
        file: The robot.
        start: Unix time of the first message, in s.
        end: Unix time of the last message, in s.
        speed: One of SPEEDS, in recorded seconds for each second; 1.0 at first.
        is_playing: False while paused; True also while `refresh` holds the position.
    """

    def __init__(self, bag: BagFile, file: RobotFile, clock: Clock) -> None:
        """Find the robot's namespace in the bag, and begin to read the first hour.

        This call reads the bag for the namespace; another thread reads the hour. The player is
        paused at the start.

        Args:
            bag: The bag.
            file: The robot.
            clock: The machine's clock, by which the recording plays.
        """
        self.bag, self.file, self._clock = bag, file, clock
        self.start, self.end = bag.start, bag.end
        self.speed, self.is_playing = 1.0, False
        # A position, and the monotonic time at which it was reached.
        self._base, self._base_time = self.start, clock.monotonic()
        self._last_position = self._base  # The position at the last refresh.
        self._namespace = namespace_of(bag, file)
        self._state = self._new_state()
        self._window = Window(self.start, self.start + SPAN)
        self._read_for = self.start  # The position for which the window was made.
        self._start_reading(self._window)

    def _new_state(self) -> ReplayState:
        return ReplayState(self.file, self.bag.types, self._namespace)

    def _start_reading(self, window: Window) -> None:
        """Fill a window on a thread of its own, which ends early once another window is current."""

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
        """Return the Unix time that is shown; while playing it moves on, up to the end."""
        if not self.is_playing:
            return self._base
        passed = self._clock.monotonic() - self._base_time
        return min(self._base + passed * self.speed, self.end)

    def go_to(self, time: float) -> None:
        """Move the position to a Unix time, bounded by the recording; playing goes on from there.

        If the new position is outside of the loaded hour, begin to read the hour around it, on
        another thread.
        """
        self._base = self._last_position = min(max(time, self.start), self.end)
        self._base_time = self._clock.monotonic()
        if not self._window.begin <= self._base <= self._window.end:
            # If there were too many messages, the window ends before the position it was made for.
            is_dense = self._window.end < self._read_for
            span = self._window.end - self._window.begin if is_dense else SPAN
            begin, self._read_for = max(self._base - span / 2, self.start), self._base
            self._state = self._new_state()
            self._window = Window(begin, begin + SPAN)
            self._start_reading(self._window)

    def close(self) -> None:
        """End the reading; the player is of no use afterwards."""
        self._window = Window(self.start, self.start)

    def play(self, *, on: bool) -> None:
        """Play if `on`, else pause; at the end, playing begins again from the start."""
        self.go_to(self.start if on and self.position >= self.end else self.position)
        self.is_playing = on

    def refresh(self) -> None:
        """Keep up with the time that has passed while playing.

        Begin to read the hour around the position once it has passed the loaded one, hold the
        position while messages up to it are still being read, and pause at the end.
        """
        position = self.position
        if position > self._window.end:
            self.go_to(position)
        elif self.is_playing and self.is_reading:  # Wait, so that no message is skipped.
            self.go_to(self._last_position)
        elif self.is_playing and position >= self.end:
            self.play(on=False)
        self._last_position = self.position

    def change_speed(self, step: int) -> None:
        """Move the speed by `step` entries of SPEEDS, not beyond its first or last entry."""
        self.go_to(self.position)
        index = SPEEDS.index(self.speed) + step
        self.speed = SPEEDS[min(max(index, 0), len(SPEEDS) - 1)]

    def step_message(self, step: int) -> None:
        """Pause, and move to the time of the next message (1) or of the one before (-1).

        If no loaded message is on that side, only pause.
        """
        self.play(on=False)
        neighbour = self._window.neighbour(self.position, step)
        self.go_to(self.position if neighbour is None else neighbour)

    @property
    def marks(self) -> list[TimelineMark]:
        """Return the events and alarms of the loaded hour read so far, in the order of time."""
        return sorted(self._window.marks, key=lambda mark: mark.time)

    def step_mark(self, step: int) -> TimelineMark | None:
        """Pause, move to the next mark (1) or the one before (-1), and return it.

        If the loaded hour has no mark on that side, return None, and neither pause nor move.
        """
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
        """Return True until the messages up to the position are read, or an error ends that."""
        return not self._window.covers(self.position)

    @property
    def is_complete(self) -> bool:
        """Return True when the loaded hour is read, or an error has ended its reading."""
        return self._window.is_complete

    @property
    def unreadable(self) -> int:
        """Return how many messages of the loaded hour could not be applied so far.

        An error that has ended the reading counts as one more.
        """
        return self._window.unreadable

    async def follow(self, update: Callable[[], None]) -> None:
        """Call `update` ten times a second while the bag is played or read; never return.

        After the reading or playing ends, `update` is called at most once more.
        """
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
        """Return the state at a time, or an empty one while that time is still being read.

        The next call changes the state that is returned.
        """
        if not self._window.covers(now):
            return self._new_state()
        self._window.advance(self._state, now)
        return self._state

    def view(self) -> View:
        """Return what the console showed at the position; an empty view until that is read."""
        now = self.position
        replay_state = self._state_at(now)
        snapshot, state = replay_state.snapshot, replay_state.console
        return View(
            snapshot,
            now,
            float(floor(now)),
            now,
            state.engine,
            state.namespace,
            self._window.history.until(now),
            replay_state.alarms(snapshot, now),
            state.hosted,
            watching=True,
            queue=tuple(map(self._queued, state.queue)),
            held=state.held,
            clients=state.clients,
            replay=f"REPLAY {datetime.fromtimestamp(now):%Y-%m-%d %H:%M:%S}",
        )

    def _queued(self, goal: RecordedGoal) -> QueuedGoal:
        return QueuedGoal(self._state.goal_kind(goal.kind), goal.values)


def namespace_of(bag: BagFile, file: RobotFile) -> str:
    """Return the robot's namespace, as the recorded console state says or as the topics suggest.

    It reads from the disk the first second of the bag, in which the black box records a state.
    """
    state = ReplayState(file, bag.types, "/")
    for message in bag.messages(bag.start, bag.start + 1.0, (STATE,)):
        try:
            state.apply(*message)
        except Exception:  # A hostile file may raise anything.
            break
        return state.console.namespace
    return guess_namespace(bag.types, file)
