"""The end of the console, before which a running goal is cancelled or left, as was chosen."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator
from typing import TYPE_CHECKING

from archo_tui.base.clock import Clock
from archo_tui.base.system import CAN_SUSPEND, END_SIGNALS
from archo_tui.robot.state.goal import Goal

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot

CANCEL, LEAVE = "cancel", "leave"
RESTART = 100  # An exit code that asks to start again with the same options.
WAIT = 1.0  # Seconds for the robot's answer, after which the process ends.
_LOOK = 0.02  # Seconds between two checks of a goal that is being cancelled.


async def let_go(robot: Robot, clock: Clock, on_disconnect: str, why: str) -> None:
    """Send no more goals, and cancel the running goal and wait for its end, or leave it running.

    It takes 1 s at most; events tell what was done. A goal of another client is left alone.
    """
    try:
        await clock.wait_for(_let_go(robot, clock, on_disconnect, why), WAIT)
    except TimeoutError:
        robot.note("ERROR", "console", f"no answer in {WAIT:g} s: the goal may be running")


async def _let_go(robot: Robot, clock: Clock, on_disconnect: str, why: str) -> None:
    await robot.stop_sending_goals()  # From here on the snapshot has every goal that was sent.
    goal = _ours(robot)
    if goal is None:
        return
    if on_disconnect == LEAVE:
        robot.note("WARN", "console", f"{why}: the goal to {goal.name} is left running")
        return
    robot.note("WARN", "console", f"{why}: cancelling the goal to {goal.name}")
    outcome = await robot.cancel()
    while outcome.ok and _ours(robot) is not None:
        await clock.sleep(_LOOK)


def _ours(robot: Robot) -> Goal | None:
    """Return the goal that runs, or None if none does or another client sent it."""
    goal = robot.snapshot.running_goal
    return goal if goal is not None and goal.mine else None


class Shutdown:
    """An orderly end of the console, which handles the running goal first."""

    def __init__(
        self,
        robot: Robot,
        clock: Clock,
        on_disconnect: str,
        end: Callable[[int], None],  # On the event loop, with the exit code.
        # Waits for those of commands; cut off after WAIT.
        answers: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        self._robot, self._clock = robot, clock
        self._answers = answers
        self._on_disconnect, self._end = on_disconnect, end
        self._task: asyncio.Task[None] | None = None
        self._code = 0  # With which it ends.

    def begin_on_signals(self) -> None:
        """Call `begin` on a signal from now on, and at once if one came; on the event loop."""
        loop = asyncio.get_running_loop()

        def begin(number: int) -> None:
            with contextlib.suppress(RuntimeError):  # A closed loop means that the end is near.
                loop.call_soon_threadsafe(self.begin, 128 + number)

        _first_signal.listen(begin)

    @property
    def has_begun(self) -> bool:
        """Return True once `begin` was called: the console is about to end."""
        return self._task is not None

    def begin(self, code: int) -> None:
        """Handle the running goal and then end, once; call it on the event loop.

        What ends a console that is about to restart ends it for good.
        """
        if self._task is None:
            self._code = code
            self._task = asyncio.create_task(self._end_in_order(code))
        elif self._code == RESTART:
            self._code = code

    def call_off(self) -> None:
        """Go on with the console: call it in `end`, in place of the end."""
        self._robot.allow_sending_goals()
        self._task = None

    async def _end_in_order(self, code: int) -> None:
        """Cancel or leave the running goal, wait for the answers of commands for 1 s, and end."""
        why = f"ended by {signal.Signals(code - 128).name}" if code > 128 else "ended"
        await let_go(self._robot, self._clock, self._on_disconnect, why)
        if self._answers is not None:
            with contextlib.suppress(TimeoutError):
                await self._clock.wait_for(self._answers(), WAIT)
        self._end(self._code)


class _FirstSignal:
    """The memory of the first signal that asks for the end, also without an event loop.

    asyncio's own handlers come and go with its loop. A signal in between would kill the process and
    leave the terminal in raw mode.
    """

    def __init__(self) -> None:
        self.first = 0
        self._listener: Callable[[int], None] | None = None

    def on_signal(self, number: int, _frame: object) -> None:
        self.first = self.first or number
        if self._listener is not None:
            self._listener(number)

    def listen(self, listener: Callable[[int], None]) -> None:
        self._listener = listener
        if self.first:
            listener(self.first)


_first_signal = _FirstSignal()


def heed_signals() -> None:
    """Remember END_SIGNALS from now on, so that a Shutdown ends the console in order."""
    for number in END_SIGNALS:
        signal.signal(number, _first_signal.on_signal)


def ignore_signals() -> None:
    """Ignore the signals of `heed_signals` from now on: the console ends already."""
    for number in END_SIGNALS:
        if signal.getsignal(number) == _first_signal.on_signal:
            signal.signal(number, signal.SIG_IGN)


@contextlib.contextmanager
def nothing_published_while_suspended(robot: Robot) -> Iterator[None]:
    """End what this process publishes before SIGTSTP (ctrl+z) suspends it.

    A process that stands still reads no STOP. Does nothing in a thread that gets no signals.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if sys.platform == "win32" or not (CAN_SUSPEND and is_main):
        yield
        return

    def suspend(number: int, _frame: object) -> None:
        robot.end_publications_now()
        signal.signal(number, before)
        os.kill(os.getpid(), number)
        signal.signal(number, suspend)

    before = signal.getsignal(signal.SIGTSTP)
    if before == signal.SIG_DFL:  # Else it is ignored, or another part of a test has its own.
        signal.signal(signal.SIGTSTP, suspend)
    try:
        yield
    finally:
        signal.signal(signal.SIGTSTP, before)
