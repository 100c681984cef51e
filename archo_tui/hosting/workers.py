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

    def __init__(self, most: int, name: str, on_error: Callable[[], object]) -> None:
        """`on_error()` is called in the thread whose work raised."""
        self._most, self._name, self._on_error = most, name, on_error
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


def multi_threaded(context: Context, threads: int, name: str) -> tuple[Any, Workers]:
    """An executor for one node, and its threads; `threads` is 0 where the file does not say."""
    executor = MultiThreadedExecutor(max(threads, _LEAST), context=context)
    executor._executor.shutdown()
    # what a callback raised comes out at the next turn, so there must be one
    workers = Workers(max(threads, _LEAST), name, lambda: executor.create_task(lambda: None))
    executor._executor = workers  # type: ignore[assignment]
    return executor, workers
