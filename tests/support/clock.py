"""A clock that stands still until a test moves it, for the console and for the embedded engine.

Nothing waits for real time: a test lets everything come to rest, then moves the clock to what is
due next. So a move of 3 s or ten minutes on the shelf cost what their work costs, and nothing
races. On real ROS 2 there is no such clock: the same tests wait in real time.
"""

from __future__ import annotations

import asyncio
import heapq
import itertools
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext

from archo_tui.base.clock import Clock

NOW = 1000.0  # monotonic s at the start
TIME = 1_700_000_000.0  # Unix time at the start
LOOK = 0.0003  # s of real time between two looks at threads that work
_SPINNERS = ("/", "archo-client", "spin")  # how the names of threads begin that spin an executor


class _Waiter:
    """A thread that has let go of its condition until something comes or its time is there."""

    def __init__(
        self, condition: threading.Condition, idle: Callable[[], bool], until_ns: int | None
    ) -> None:
        self._condition, self._idle = condition, idle
        self.until_ns = until_ns
        self._woken = False

    def rests(self) -> bool:
        """True when it has nothing to do; a lock that is taken says that somebody is at work."""
        if self._woken or not self._condition.acquire(blocking=False):
            return False
        try:
            return self._idle()
        finally:
            self._condition.release()

    def expect(self) -> None:
        """Its time is there: it does not rest until it has been awake."""
        self._woken = True

    def wake(self) -> None:
        with self._condition:
            self._condition.notify_all()


class VirtualClock(Clock):
    """Both the console's clock and the engine's source of time, for the thread that makes it."""

    def __init__(self) -> None:
        self._now_ns = self._start_ns = int(NOW * 1e9)
        self._lock = threading.Lock()
        self._waiters: dict[threading.Thread, _Waiter] = {}
        self._sleepers: list[tuple[int, int, asyncio.Future[None]]] = []
        self._order = itertools.count()
        self._tester = threading.current_thread()
        self._stuck: set[threading.Thread] = set()
        self.moves = 0  # how often time moved or a thread woke

    # the console's clock

    def monotonic(self) -> float:
        return self._now_ns / 1e9

    def now(self) -> float:
        return TIME + (self._now_ns - self._start_ns) / 1e9

    async def sleep(self, seconds: float) -> None:
        passed: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        until = self._now_ns + max(int(seconds * 1e9), 0)
        heapq.heappush(self._sleepers, (until, next(self._order), passed))
        await passed

    # the engine's source of time

    def monotonic_ns(self) -> int:
        return self._now_ns

    def time_ns(self) -> int:
        return int(TIME * 1e9) + self._now_ns - self._start_ns

    def wait(
        self,
        condition: threading.Condition,
        idle: Callable[[], bool],
        until_ns: int | None = None,
    ) -> None:
        thread = threading.current_thread()
        if thread is self._tester:
            self._wait_here(condition, idle, until_ns)
            return
        with self._lock:
            if until_ns is not None and until_ns <= self._now_ns:
                return
            self._waiters[thread] = _Waiter(condition, idle, until_ns)
        try:
            condition.wait()
        finally:
            with self._lock:
                del self._waiters[thread]
                self.moves += 1

    def _wait_here(
        self, condition: threading.Condition, idle: Callable[[], bool], until_ns: int | None
    ) -> None:
        """The test itself waits: time moves on when all others rest."""
        while idle():
            if self.at_rest() and self.advance(until_ns):
                return
            condition.wait(LOOK)

    # what a test does with it

    @contextmanager
    def stuck(self) -> Iterator[None]:
        """Around what keeps a callback from returning: nobody is to wait for this thread."""
        self._stuck.add(threading.current_thread())
        try:
            yield
        finally:
            self._stuck.discard(threading.current_thread())

    def at_rest(self) -> bool:
        """True when every thread that spins waits, and has nothing queued."""
        with self._lock:
            waiters = dict(self._waiters)
        for thread in threading.enumerate():
            if thread is self._tester or thread in self._stuck:
                continue
            if thread.name.startswith(_SPINNERS) and not _is_idle_worker(thread):
                waiter = waiters.get(thread)
                if waiter is None or not waiter.rests():
                    return False
        return True

    def advance(self, until_ns: int | None = None) -> bool:
        """Move to what is due next, but not past `until_ns`; False when nothing is due."""
        with self._lock:
            while self._sleepers and self._sleepers[0][2].done():
                heapq.heappop(self._sleepers)
            due = [w.until_ns for w in self._waiters.values() if w.until_ns is not None]
            due += [until_ns] if until_ns is not None else []
            due += [self._sleepers[0][0]] if self._sleepers else []
            if not due:
                return False
            now = self._now_ns = max(min(due), self._now_ns)
            self.moves += 1
            woken = [w for w in self._waiters.values() if (w.until_ns or now + 1) <= now]
            for waiter in woken:
                waiter.expect()
        for waiter in woken:
            waiter.wake()
        while self._sleepers and self._sleepers[0][0] <= now:
            passed = heapq.heappop(self._sleepers)[2]
            if not passed.done():
                passed.set_result(None)
        return True

    def suspend(self, span: float) -> None:
        """Let that many seconds pass in which this process does nothing."""
        self._now_ns += int(span * 1e9)

    def settle(self) -> None:
        """Let every thread that spins do all that it has to do now."""
        end = time.monotonic() + 60.0
        while not self.at_rest():
            assert time.monotonic() < end, f"never at rest: {threading.enumerate()}"
            time.sleep(LOOK)


def _is_idle_worker(thread: threading.Thread) -> bool:
    """True for a thread of a pool that has nothing to do."""
    frame = sys._current_frames().get(thread.ident or 0)
    return frame is not None and frame.f_code.co_name == "_worker"


current: VirtualClock | None = None  # of the running test; None where it runs in real time


@contextmanager
def stuck() -> Iterator[None]:
    """Around what keeps a callback from returning, in either time."""
    with nullcontext() if current is None else current.stuck():
        yield


def release(event: threading.Event) -> None:
    """Let go of a callback that is `stuck()` on the event, and wait until it goes on."""
    event.set()
    while current is not None and current._stuck:
        time.sleep(LOOK)


def look() -> float:
    """Seconds between two looks: short where the clock is the test's, and nothing else waits."""
    return 0.01 if current is None else LOOK


def seconds() -> float:
    """The time (s) that the nodes of the test live by."""
    return time.monotonic() if current is None else current.monotonic()


def pass_time(span: float) -> None:
    """Let that many seconds pass, and what is due in them happen."""
    if current is None:
        time.sleep(span)
        return
    end_ns = current.monotonic_ns() + int(span * 1e9)
    while current.monotonic_ns() < end_ns:
        current.settle()
        current.advance(end_ns)
