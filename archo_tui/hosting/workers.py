"""The threads of a node that is spun by a MultiThreadedExecutor."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor

_LEAST = 2  # threads: on a machine with one core, too, callbacks of a node may overlap


class Workers:
    """Runs work in so many threads at most, in the place of a ThreadPoolExecutor.

    Unlike those of a pool, these have their node's name, by which its output is known, end when
    there is no work, and do not keep the process from ending when a callback never returns.
    """

    def __init__(
        self,
        most: int,
        name: str,
        on_error: Callable[[], object],
        on_begin: Callable[[], object],
    ) -> None:
        """Start no thread yet.

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
        self.threads: list[threading.Thread] = []  # those that have work

    def submit(self, work: Callable[..., Any], *args: Any) -> Future[Any]:
        """Have it done as soon as a thread is free."""
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
            # rclpy's own work is a task, which keeps what it raised
            error_of = getattr(work, "exception", future.exception)
            if error_of() is not None:
                self._on_error()

    def shutdown(self, wait: bool = True) -> None:
        """Begin nothing more. Never waits, whatever is said: a callback may not return."""
        with self._lock:
            self._waiting.clear()


def multi_threaded(
    context: Context, threads: int, name: str, on_begin: Callable[[], object]
) -> tuple[Any, Workers]:
    """Return an executor for one node, and its threads.

    Args:
        context: The rclpy context of the node.
        threads: The number of threads; 0 where the file does not say.
        name: The name of each thread.
        on_begin: Called first in each new thread.
    """
    executor = MultiThreadedExecutor(max(threads, _LEAST), context=context)
    executor._executor.shutdown()
    # what a callback raised comes out at the next turn, so there must be one
    workers = Workers(
        max(threads, _LEAST), name, lambda: executor.create_task(lambda: None), on_begin
    )
    executor._executor = workers  # type: ignore[assignment]
    return executor, workers
