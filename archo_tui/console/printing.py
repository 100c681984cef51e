"""The lines of `--plain`: news of the robot, each fact once; a reader that stalls holds nobody."""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import threading
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from archo_tui.base.clock import time_of_day
from archo_tui.base.safe_text import safe
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.screen.terminal.ascii import ascii_only, in_ascii
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.station.approvals import LIFETIME
from archo_tui.text import line_by_line
from archo_tui.text.event import event_text, is_of_own_file
from archo_tui.verbs.show import Status

if TYPE_CHECKING:
    from archo_tui.station.station import Station

MAX_WAITING = 1_000_000  # Bytes that wait to be written.
_CHUNK = 4096  # Bytes written at once, unless a line is longer.
_PRINTED_LEVELS = ("YOU", "SHELL", "AI", "PEER", "WARN", "ERROR", "FATAL")


class Printer:
    """The printer of events, goals, alarms and requests, each change once; it never waits."""

    def __init__(
        self, station: Station, output: Output, status: Status, is_ending: Callable[[], bool]
    ) -> None:
        self._station, self._output, self._status = station, output, status
        self._clock, self._is_ending = station.clock, is_ending
        self._ascii = ascii_only()
        self._printed_events: set[int] = set()  # Numbers of events in the last snapshot.
        self.goal: Goal | None = None
        self.has_failed = False  # The exit code is 1 then.
        self.requests_shown_at: dict[int, float] = {}  # Monotonic s, by number.

    def print_news(self, snapshot: Snapshot) -> None:
        """Print the events and the goal's state that are news; set `goal` and `has_failed`."""
        for event in snapshot.events:
            if event.number not in self._printed_events and is_event_news(
                event, snapshot.goal, self._station.host.states(), is_ending=self._is_ending()
            ):
                self.print_timed(event_text(event), event.time)
        self._printed_events = {event.number for event in snapshot.events}
        self._print_goal(snapshot)

    def _print_goal(self, snapshot: Snapshot) -> None:
        goal, before = snapshot.goal, self.goal
        self.goal = goal
        if any(ended.mine and ended.phase != Phase.ARRIVED for ended in snapshot.history):
            self.has_failed = True
        if goal is None:
            return
        if before is not None and before.number != goal.number:
            before = None
        now = self._clock.monotonic()
        for at, state in goal_states(before, goal, now):
            if is_goal_news(before, state):
                text = line_by_line.goal_text(snapshot._replace(goal=state), at, self._status.ask)
                self.print_timed(f"goal {text}", self._clock.now() + at - now)
            before = state

    def print_alarms(self, changed: list[Alarm]) -> None:
        """Print the new state of each alarm, with the text and a remedy of a raised one."""
        for alarm in changed:
            is_new = alarm.state == AlarmState.UNACKNOWLEDGED
            snapshot = self._station.robot.snapshot
            text = self._status.advice(alarm, snapshot) if is_new else alarm.name
            self.print_timed(f"alarm {alarm.state.value}: {text}")

    def print_requests(self) -> None:
        """Print each new request of an assistant, and what to type to answer it."""
        for request in self._station.view.requests:
            if request.number not in self.requests_shown_at:
                self.requests_shown_at[request.number] = self._clock.monotonic()
                ways = f"allow {request.number} or deny {request.number}, within {LIFETIME:g} s"
                self.print_timed(f"{request.requester.source} wants: {request.text} ({ways})")

    def print_failure(self, text: str) -> None:
        self.print_timed(f"failed: {text}")
        self.has_failed = True

    def print_timed(self, text: str, at: float | None = None) -> None:
        """Print a text behind a time of day; `at` is Unix time in seconds, None for now."""
        self.print_text(f"{time_of_day(self._clock.now() if at is None else at)} {text}")

    def print_text(self, text: str) -> None:
        """Print lines, with a mark in place of each control character.

        On a terminal that takes only ASCII, other characters are replaced.
        """
        lines = [safe(line) for line in text.splitlines()]
        self._output.put(
            "".join(f"{in_ascii(line) if self._ascii else line}\n" for line in lines).encode()
        )


def is_event_news(
    event: Event, goal: Goal | None, hosted: Iterable[Hosted], *, is_ending: bool
) -> bool:
    """Return True if a line is printed for an event.

    None is printed for DEBUG and GOAL, nor for INFO except of the user's own files, nor for what
    another line reports: a failed command, unless the console `is_ending`, and why this console's
    goal was refused.
    """
    if event.level not in _PRINTED_LEVELS:
        return event.level == "INFO" and is_of_own_file(event, hosted)
    record = event.audit_record
    if event.level == "YOU" and record is not None and not Outcome(record.code, "").ok:
        # `failed: ...` reports what failed of the typed line. There is no such line while the
        # console ends, nor for what fails after the line was answered.
        return is_ending or "later" in record.arguments
    if goal is None or not goal.mine or not goal.kind.refusals:
        return True
    # The server logs why it refuses a goal, and `failed: ...` repeats that reason.
    is_refusal = event.text.startswith(goal.kind.refusals)
    is_repeated = event.text.removeprefix(goal.kind.refusals) == goal.message
    is_of_goal = goal.phase == Phase.SENT or (goal.phase == Phase.REFUSED and is_repeated)
    return not (is_refusal and is_of_goal)


def goal_states(before: Goal | None, goal: Goal, now: float) -> Iterable[tuple[float, Goal]]:
    """Yield a goal at each remaining way that came since `before`, and as it is; with the times."""
    base, way = (goal, goal.way[:-1]) if goal.is_running else (before, goal.way)
    since = before.way[-1][0] if before is not None and before.way else 0.0
    for at, remaining in way:
        if at > since and base is not None and not goal.unreadable:
            yield at, base._replace(remaining=remaining, heard=at)
    yield now, goal


def is_goal_news(before: Goal | None, goal: Goal) -> bool:
    """Return True if a line is printed for a goal: it reached a milestone no answer has told."""
    is_changed = before is None or _milestone(before) != _milestone(goal)
    return _is_long_step(before, goal) or (is_changed and not _is_in_answer(before, goal))


def _milestone(goal: Goal) -> tuple[Phase, bool, bool, int]:
    """Return the parts of a goal's state that are printed when one changes."""
    quarter = min(int(goal.fraction() * 4), 3)
    return goal.phase, bool(goal.unreadable), _has_feedback(goal), quarter


def _is_long_step(before: Goal | None, goal: Goal) -> bool:
    """Return True if a feedback is a sixth of the way or more from the one before."""
    if before is None or before.remaining is None or goal.remaining is None or not goal.length:
        return False
    return abs(before.remaining - goal.remaining) >= goal.length / 6


def _is_in_answer(before: Goal | None, goal: Goal) -> bool:
    """Return True if the answer to a line typed here has told this change of the goal already."""
    if before is None or before.phase == Phase.SENT:  # Otherwise the answer came late.
        has_just_begun = goal.phase == Phase.MOVING and not _has_feedback(goal)
        return goal.mine and (has_just_begun or goal.phase in (Phase.SENT, Phase.REFUSED))
    return goal.mine and goal.phase == Phase.CANCELLING and goal.cancel_asked is not None


def _has_feedback(goal: Goal) -> bool:
    """Return True if feedback was received, readable or not."""
    return bool(goal.unreadable or goal.feedback) or goal.remaining is not None


class Output:
    """A file descriptor to which whole lines are written, on a thread of its own.

    When more than MAX_WAITING bytes wait, the oldest lines are dropped, and a line in their place
    tells how many.
    """

    def __init__(self, descriptor: int, on_change: Callable[[], None]) -> None:
        """Create the output; `start` begins to write, and the descriptor stays open.

        `on_change` is called on the running loop when `has_room` or `is_done` may be true again,
        and when a write has failed.
        """
        self._descriptor, self._on_change = descriptor, on_change
        self._loop = asyncio.get_running_loop()
        self._condition = threading.Condition()  # Guards the attributes below; notified by `put`.
        self._waiting = bytearray()
        self._dropped = 0  # Lines dropped since the last line that told how many.
        self._is_writing = self._is_closed = False
        self.is_broken = False  # True once the reader has left, or the disk is full.

    def start(self) -> None:
        threading.Thread(target=self._run, name="stdout", daemon=True).start()

    def put(self, lines: bytes) -> None:
        """Add whole lines to be written, and return at once; drop the oldest if too many wait."""
        with self._condition:
            self._waiting += lines
            if len(self._waiting) > MAX_WAITING:
                end = self._waiting.find(b"\n", len(self._waiting) - MAX_WAITING - 1) + 1
                self._dropped += self._waiting.count(b"\n", 0, end)
                del self._waiting[:end]
            self._condition.notify()

    @property
    def has_room(self) -> bool:
        """True while less than half of MAX_WAITING bytes wait, or after a write has failed."""
        return self.is_broken or len(self._waiting) < MAX_WAITING // 2

    @property
    def is_done(self) -> bool:
        """True while every line is written or dropped and reported, or after a write has failed."""
        return self.is_broken or not (self._waiting or self._dropped or self._is_writing)

    def close(self) -> None:
        """Let the thread end once it has written the waiting lines, without waiting for it."""
        with self._condition:
            self._is_closed = True
            self._condition.notify()

    # Called on the thread.

    def _run(self) -> None:
        try:
            while chunk := self._next_chunk():
                self._write(chunk)
        except OSError:
            self.is_broken = True
            self._announce()

    def _next_chunk(self) -> bytes:
        """Wait for lines, and return the next ones; empty once all is written after `close()`."""
        with self._condition:
            self._is_writing = False
            if self.is_done:
                self._announce()
            self._condition.wait_for(lambda: not self.is_done or self._is_closed)
            self._is_writing = True  # Before lines are taken: `is_done` is read without the lock.
            had_room, dropped, self._dropped = self.has_room, self._dropped, 0
            # As many whole lines as fit, or the first line if none fits.
            end = self._waiting.rfind(b"\n", 0, _CHUNK) + 1 or self._waiting.find(b"\n") + 1
            chunk = bytes(self._waiting[:end])
            del self._waiting[:end]
            self._is_writing = bool(chunk)
            if self.has_room and not had_room:
                self._announce()
        if not dropped:
            return chunk
        lines = "1 line was" if dropped == 1 else f"{dropped} lines were"
        return f"... {lines} left out: the reader was too slow\n".encode() + chunk

    def _announce(self) -> None:
        with contextlib.suppress(RuntimeError):  # The loop is closed: nobody waits for it.
            self._loop.call_soon_threadsafe(self._on_change)

    def _write(self, data: bytes) -> None:
        """Write all bytes, however long the reader takes; OSError once it has left."""
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            # Another process that shares the descriptor made it non-blocking.
            except BlockingIOError:
                select.select([], [self._descriptor], [])
