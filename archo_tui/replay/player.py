"""Where a replay is, and how fast it goes; what is shown there."""

from __future__ import annotations

import threading
from datetime import datetime
from math import floor

from archo_tui.clock import Clock
from archo_tui.recording.console_recorder import STATE
from archo_tui.recording.state import RecordedGoal
from archo_tui.replay.bag_file import BagFile
from archo_tui.replay.story import Story
from archo_tui.replay.topics import namespace
from archo_tui.replay.window import SPAN, Mark, Window
from archo_tui.robot.state import Snapshot
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.queue import QueuedGoal
from archo_tui.station.station import View

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)


class Player:
    """Plays one bag. Used on the loop; a thread of its own reads."""

    def __init__(self, bag: BagFile, file: RobotFile, clock: Clock) -> None:
        """`clock` is the machine's."""
        self.bag, self.file, self._clock = bag, file, clock
        self.start, self.end = bag.start, bag.end
        self.speed, self.is_playing = 1.0, False
        self._at, self._since = self.start, clock.monotonic()  # the position then
        self._seen = self._at  # the position at the last look
        self._namespace = named(bag, file)
        self._story = self._new_story()
        self._window = Window(self.start, self.start + SPAN)
        self._read(self._window)

    def _new_story(self) -> Story:
        return Story(self.file, self.bag.types, self._namespace)

    def _read(self, window: Window) -> None:
        def read() -> None:
            story = self._new_story()
            messages = self.bag.messages(window.begin, window.end, story.wanted)
            try:
                for _ in window.fill(story, messages):
                    if window is not self._window:  # nobody wants it any more
                        return
            except Exception:  # whatever a file says: what was read is shown
                window.give_up()

        threading.Thread(target=read, name="replay", daemon=True).start()

    # where it is

    @property
    def position(self) -> float:
        """Unix time of what is shown."""
        if not self.is_playing:
            return self._at
        passed = self._clock.monotonic() - self._since
        return min(self._at + passed * self.speed, self.end)

    def go_to(self, time: float) -> None:
        """Show that moment, and go on from there."""
        self._at = self._seen = min(max(time, self.start), self.end)
        self._since = self._clock.monotonic()
        if not self._window.begin <= self._at <= self._window.end:
            begin = max(self._at - SPAN / 2, self.start)
            self._story = self._new_story()
            self._window = Window(begin, begin + SPAN)
            self._read(self._window)

    def play(self, *, on: bool) -> None:
        """Begin, at the start when all was played; or pause."""
        self.go_to(self.start if on and self.position >= self.end else self.position)
        self.is_playing = on

    def look(self) -> None:
        """Pause at the end; behind the part that is held read the next one, and wait for it."""
        position = self.position
        if position > self._window.end:
            self.go_to(position)
        elif self.is_playing and self.is_reading:  # nothing is passed unseen
            self.go_to(self._seen)
        elif self.is_playing and position >= self.end:
            self.play(on=False)
        self._seen = self.position

    def faster(self, step: int) -> None:
        """One step in SPEEDS, up or down."""
        self.go_to(self.position)
        place = SPEEDS.index(self.speed) + step
        self.speed = SPEEDS[min(max(place, 0), len(SPEEDS) - 1)]

    def by_message(self, step: int) -> None:
        """To the next message, or the one before."""
        self.play(on=False)
        beside = self._window.beside(self.position, step)
        self.go_to(self.position if beside is None else beside)

    @property
    def marks(self) -> list[Mark]:
        """What happened, in the order in which it did."""
        return sorted(self._window.marks, key=lambda mark: mark.time)

    def to_mark(self, step: int) -> Mark | None:
        """To the next one, or the one before; None: there is none."""
        here, marks = self.position, self.marks
        beside = [m for m in marks if (m.time > here if step > 0 else m.time < here)]
        if not beside:
            return None
        mark = beside[0] if step > 0 else beside[-1]
        self.play(on=False)
        self.go_to(mark.time)
        return mark

    # what is shown

    @property
    def is_reading(self) -> bool:
        """True while what is to be shown is not read yet."""
        return not self._window.has(self.position)

    @property
    def is_whole(self) -> bool:
        """True when the part that is held is read."""
        return self._window.is_whole

    @property
    def unreadable(self) -> int:
        """Messages that say nonsense, so far."""
        return self._window.unreadable

    def snapshot(self) -> Snapshot:
        """What was known at the position."""
        return self._tell(self.position).snapshot

    def _tell(self, now: float) -> Story:
        """The story up to then; while that is not read yet, one in which nothing was heard."""
        if not self._window.has(now):
            return self._new_story()
        self._window.tell(self._story, now)
        return self._story

    def view(self) -> View:
        """All that was shown at the position."""
        now = self.position
        story = self._tell(now)
        snapshot, state = story.snapshot, story.state
        return View(
            snapshot,
            now,
            float(floor(now)),
            now,
            state.engine,
            state.namespace,
            self._window.history.until(now),
            story.alarms(snapshot, now),
            state.hosted,
            watching=True,
            queue=tuple(map(self._queued, state.queue)),
            held=state.held,
            clients=state.clients,
            replay=f"REPLAY {datetime.fromtimestamp(now):%Y-%m-%d %H:%M:%S}",
        )

    def _queued(self, wanted: RecordedGoal) -> QueuedGoal:
        return QueuedGoal(self._story.kind(wanted.kind), wanted.values)


def named(bag: BagFile, file: RobotFile) -> str:
    """The robot's namespace, as the recording says, or as its topics are called."""
    story = Story(file, bag.types, "/")
    for said in bag.messages(bag.start, bag.start + 1.0, (STATE,)):
        try:
            story.apply(*said)
        except Exception:  # it says nonsense
            break
        return story.state.namespace
    return namespace(bag.types, file)
