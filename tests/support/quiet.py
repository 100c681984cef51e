"""When nothing is left to do before time moves on: threads that spin, and the asyncio loop."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from textual.app import App
from textual.screen import Screen

from tests.support import clock
from tests.support.waiting import DEADLINE, Waited

T = TypeVar("T")


_given: WeakKeyDictionary[Any, set[Any]] = WeakKeyDictionary()  # by loop


def _given_to_threads(loop: Any) -> set[Any]:
    """What a loop has given to threads, and they have not ended."""
    if loop not in _given:
        running = _given[loop] = set()
        run_in_executor = loop.run_in_executor

        def tracked(executor: Any, function: Any, *args: Any) -> Any:
            future = run_in_executor(executor, function, *args)
            running.add(future)
            future.add_done_callback(running.discard)
            return future

        loop.run_in_executor = tracked
    return _given[loop]


class Quiet:
    """Watches the running loop, what the loop has given to threads, and an app's screen."""

    def __init__(self, app: App[Any] | None = None) -> None:
        self._app = app
        self._loop: Any = asyncio.get_running_loop()
        self._threads = _given_to_threads(self._loop)

    async def settle(self) -> None:
        """Return when nobody has anything to do before time moves on, and all is drawn."""
        end = time.monotonic() + 3 * DEADLINE
        while True:
            assert time.monotonic() < end, "never drawn"
            await self._settle()
            if self._app is None or not self._app.is_running or not self._app.screen_stack:
                return
            screen = self._app.screen
            if not _is_to_be_drawn(screen):
                return
            screen._on_timer_update()  # what Textual's own timer would do within 1/60 s
            if _is_to_be_drawn(screen):  # the first picture waits for something else
                await asyncio.sleep(clock.look())

    async def _settle(self) -> None:
        end = time.monotonic() + 3 * DEADLINE
        while True:
            assert time.monotonic() < end, "never at rest"
            virtual = clock.current
            moves = virtual.moves if virtual is not None else 0
            while virtual is not None and not virtual.at_rest():
                assert time.monotonic() < end, "a thread never rests"
                await asyncio.sleep(clock.look())
            await asyncio.sleep(0)
            while self._loop._ready:
                await asyncio.sleep(0)
            if self._threads:
                await asyncio.sleep(clock.look())
                continue
            rests = virtual is None or (virtual.moves == moves and virtual.at_rest())
            if rests and not self._loop._ready:
                return

    async def until(
        self, holds: Callable[[], object], what: Callable[[], str], deadline: float = DEADLINE
    ) -> None:
        """Wait until it holds; a virtual clock moves on, from one thing that is due to the next."""
        waited = Waited(deadline)
        while True:
            await self.settle()
            if holds():
                return
            assert not waited.too_long(), f"waited {waited} for {what()}"
            if clock.current is None or not clock.current.advance():
                await asyncio.sleep(0.01)


def _is_to_be_drawn(screen: Screen[Any]) -> bool:
    return bool(
        screen._layout_required
        or screen._scroll_required
        or screen._repaint_required
        or screen._dirty_widgets
        or screen._callbacks
    )


async def until(holds: Callable[[], object]) -> None:
    """Wait until it holds."""
    await Quiet().until(holds, lambda: repr(holds))


async def while_passes(span: float) -> None:
    """Let a time pass in which nothing else is waited for.

    Args:
        span: Seconds on the clock that the robot has.
    """
    later = clock.seconds() + span
    await until(lambda: clock.seconds() >= later)


async def outside(holds: Callable[[], object], what: str) -> None:
    """Wait for the disk or another thread of the machine: no virtual time passes meanwhile."""
    end = time.monotonic() + 3 * DEADLINE
    while not holds():
        assert time.monotonic() < end, f"waited for {what}"
        await asyncio.sleep(clock.look())


async def ended(work: Awaitable[T]) -> T:
    """Wait for the end of something that may take its time."""
    task = asyncio.ensure_future(work)
    await until(task.done)
    return task.result()
