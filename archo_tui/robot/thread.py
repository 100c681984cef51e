"""rclpy on one thread of its own beside asyncio.

rclpy is called on that thread only; `run` hops there, and back with the result.
"""

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

from archo_tui.clock import Clock

T = TypeVar("T")


class RosThread:
    """Spins one node until `stop()`; an exception in a callback is reported, and it spins on."""

    def __init__(
        self, node: Node, context: Context, clock: Clock, on_error: Callable[[Exception], None]
    ) -> None:
        self._node, self._clock = node, clock
        self._context = context
        self._on_error = on_error
        self._stopping = False
        self._waiting: deque[Callable[[], Any]] = deque()
        self._lock = threading.Lock()  # of the two above
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name="archo-client", daemon=True)

    def start(self) -> None:
        """Begin to spin."""
        self._thread.start()

    def _spin(self) -> None:
        while not self._stopping and self._context.ok():
            try:
                self.executor.spin_once()
            except ExternalShutdownException:
                return
            except Exception as error:
                self._on_error(error)

    def _begin_to_end(self) -> None:
        """Nothing new from here on; what is queued is started: Python warns of what never is."""
        for timer in self._node.timers:
            timer.cancel()
        self.submit(self._end)

    def _end(self) -> None:
        with self._lock:
            self._stopping = True

    def submit(self, function: Callable[[], Any]) -> None:
        """Run a function on the ROS thread, behind those before it; once that ends, run nothing.

        In Jazzy an executor starts the newest of its tasks first, and takes none once it is shut
        down. So each task runs whatever has waited longest.
        """
        with self._lock:
            if not self._stopping:
                self._waiting.append(function)
                self.executor.create_task(self._next)

    async def _next(self) -> None:
        result = self._waiting.popleft()()
        if inspect.iscoroutine(result):
            await result

    async def run(self, work: Callable[[], Coroutine[Any, Any, T]], deadline: float) -> T:
        """Run a coroutine function of rclpy's kind on the ROS thread; await its value here.

        Raises TimeoutError after `deadline` s whatever the ROS thread does, and what `work` raises.
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
            with contextlib.suppress(RuntimeError):  # the loop is closed: nobody waits
                loop.call_soon_threadsafe(put, value, failed)

        self.submit(there)
        return await self._clock.wait_for(result, deadline)

    def stop(self, timeout: float = 3.0) -> bool:
        """End the thread and destroy the node; False when a callback did not return in time (s)."""
        if self._thread.is_alive():
            self.submit(self._begin_to_end)
            self._thread.join(timeout)
            if self._thread.is_alive():
                return False
        self._end()  # also where the context was shut down
        self.executor.shutdown(0)
        self._node.destroy_node()
        return True
