"""The thread on which rclpy runs, and is called, beside the frontend's asyncio loop."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import threading
from collections import deque
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from archo_tui.base.clock import Clock

T = TypeVar("T")


class RosThread:
    """A thread that spins one node until `stop`, also after errors in callbacks."""

    def __init__(
        self, node: Node, context: Context, clock: Clock, on_error: Callable[[Exception], None]
    ) -> None:
        self._node, self._clock = node, clock
        self._context = context
        self._on_error = on_error
        self._stopping = self._has_started = False
        self._waiting: deque[Callable[[], Any]] = deque()
        self._lock = threading.Lock()  # Guards the two above.
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name="archo-client", daemon=True)

    def start(self) -> None:
        """Start the thread, which spins the node. Call it once."""
        with self._lock:
            self._has_started = True
            for _ in self._waiting:
                self.executor.create_task(self._next)
        self._thread.start()

    def _spin(self) -> None:
        # What was submitted before the end still begins.
        while (self._waiting or not self._stopping) and self._context.ok():
            try:
                self.executor.spin_once()
            except ExternalShutdownException:
                return
            except Exception as error:
                self._on_error(error)

    def _begin_to_end(self) -> None:
        """Stop the timers, and end once the queued functions have begun."""
        for timer in self._node.timers:
            timer.cancel()
        self.submit(self._end)

    def _end(self) -> None:
        with self._lock:
            self._stopping = True

    def submit(self, function: Callable[[], Any]) -> None:
        """Run a function on the ROS thread, in the order of the calls; return at once.

        A coroutine that the function returns is awaited there. Errors go to `on_error`. A function
        that is submitted before `start` waits for it, one after `stop` is dropped.
        """
        # An executor of ROS 2 Jazzy begins its newest task first, and none once it is shut down.
        # So each task runs the function that has waited longest.
        with self._lock:
            self._add(function)

    def submit_in_handler(self, function: Callable[[], Any], patience: float) -> bool:
        """Do what `submit` does, in a signal handler; return False if it took `patience` in s.

        The thread that the signal has interrupted may be in `submit`, and never lets go of it.
        """
        if not self._lock.acquire(timeout=patience):
            return False
        try:
            self._add(function)
        finally:
            self._lock.release()
        return True

    def _add(self, function: Callable[[], Any]) -> None:
        if not self._stopping:
            self._waiting.append(function)
            if self._has_started:  # Python warns of a coroutine that never begins.
                self.executor.create_task(self._next)

    async def _next(self) -> None:
        result = self._waiting.popleft()()
        if inspect.iscoroutine(result):
            await result

    async def run(self, work: Callable[[], Coroutine[Any, Any, T]], deadline: float) -> T:
        """Run a coroutine function of rclpy's kind on the ROS thread, and return its value.

        Raises TimeoutError at the deadline. The work still goes on then, as if the caller
        is cancelled.
        """
        loop = asyncio.get_running_loop()
        result: asyncio.Future[T] = loop.create_future()

        def put(value: Any, error: Exception | None) -> None:
            if result.done():
                return
            if error is None:
                result.set_result(value)
            else:
                result.set_exception(error)

        async def there() -> None:
            value, failed = None, None
            try:
                value = await work()
            except Exception as error:
                failed = error
            with contextlib.suppress(RuntimeError):  # The loop is closed: nobody waits.
                loop.call_soon_threadsafe(put, value, failed)

        self.submit(there)
        return await self._clock.wait_for(result, deadline)

    def stop(self, timeout: float = 3.0) -> bool:
        """End the thread and destroy the node; block until it is done. Not on the ROS thread."""
        if self._thread.is_alive():
            self.submit(self._begin_to_end)
            self._thread.join(timeout)
            if self._thread.is_alive():
                return False
        self._end()  # The thread may have ended with its context.
        self.executor.shutdown(0)
        self._node.destroy_node()
        return True
