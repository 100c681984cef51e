"""Calls that wait for a disk, in threads: like `asyncio.to_thread`, but the end waits for none."""

from __future__ import annotations

import asyncio
import contextvars
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, TypeVar

T = TypeVar("T")


class _DaemonThreads(Executor):
    """An executor with a daemon thread for each call, since a disk may never answer."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        future: Future[T] = Future()

        def run() -> None:
            try:
                value = fn(*args, **kwargs)
            except BaseException as error:
                future.set_exception(error)
            else:
                future.set_result(value)

        future.set_running_or_notify_cancel()
        threading.Thread(target=run, name="disk", daemon=True).start()
        return future


_THREADS = _DaemonThreads()


async def in_daemon(function: Callable[..., T], *arguments: Any) -> T:
    """Return the value of `function(*arguments)`, called in a daemon thread of its own.

    If the caller is cancelled, the thread goes on; the end of the process does not wait for it.
    """
    context = contextvars.copy_context()
    loop = asyncio.get_running_loop()
    return await loop.run_in_executor(_THREADS, lambda: context.run(function, *arguments))
