"""The threads of a node that is spun by a MultiThreadedExecutor."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor

_LEAST = 2  # Threads, so that callbacks may overlap also on a machine with one core.


class Workers:
    """The threads of a node's executor, in the place of those of a ThreadPoolExecutor.

    Unlike the threads of a pool, they have their node's name, by which its output is known, end
    when there is no work, and do not keep the process alive if a callback never returns.

    Attributes:
        threads: The threads that have work.
    """

    def __init__(
        self,
        most: int,
        name: str,
        on_error: Callable[[], object],
        on_begin: Callable[[], object],
    ) -> None:
        """Create the pool without threads.

        Args:
            most: The number of threads at most.
            name: The name of each thread.
            on_error: Called in the thread whose work raised.
            on_begin: Called first in each new thread.
        """
        self._most, self._name = most, name
        self._on_error, self._on_begin = on_error, on_begin
        self._lock = threading.Lock()
        self._waiting: deque[tuple[Future[Any], Callable[..., Any], tuple[Any, ...]]] = deque()
        self.threads: list[threading.Thread] = []  # The threads that have work.

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Start a thread for the work if there are fewer than `most`; else run it once one is free.

        Returns:
            A future of what the work returns or raises.
        """
        future: Future[Any] = Future()
        with self._lock:
            self._waiting.append((future, work, args))
            if len(self.threads) < self._most:
                thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self.threads.append(thread)
                thread.start()
        return future

    def _run(self) -> None:
        self._on_begin()
        while True:
            with self._lock:
                if not self._waiting:
                    self.threads.remove(threading.current_thread())
                    return
                future, work, args = self._waiting.popleft()
            try:
                future.set_result(work(*args))
            except BaseException as error:
                future.set_exception(error)
            # The work of rclpy is a task, which keeps what it raised instead of raising it.
            error_of = getattr(work, "exception", future.exception)
            if error_of() is not None:
                self._on_error()

    def shutdown(self, wait: bool = True) -> None:
        """Discard the work that waits, whose futures never end; running work goes on.

        Args:
            wait: Ignored, because a callback may never return.
        """
        with self._lock:
            self._waiting.clear()


def multi_threaded(
    context: Context, threads: int, name: str, on_begin: Callable[[], object]
) -> tuple[Any, Workers]:
    """Return a multi-threaded executor for one node, and its threads.

    Args:
        context: The rclpy context of the node.
        threads: The number of threads, as `Source.threads` returns it; raised to two if it is less.
        name: The name of each thread.
        on_begin: Called first in each new thread.
    """
    executor = MultiThreadedExecutor(max(threads, _LEAST), context=context)
    executor._executor.shutdown()
    # The executor raises what a callback raised at its next turn, so there must be one.
    workers = Workers(
        max(threads, _LEAST), name, lambda: executor.create_task(lambda: None), on_begin
    )
    executor._executor = workers  # type: ignore[assignment]
    return executor, workers
