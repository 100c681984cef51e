"""Runs user code with a time limit, and interrupts what exceeds it."""

from __future__ import annotations

import contextvars
import sys
import threading
from collections.abc import Callable
from traceback import StackSummary, extract_stack
from typing import TypeVar

T = TypeVar("T")

_GRACE = 0.5  # s that what was interrupted has to end


class Interrupted(BaseException):
    """Raised in a thread whose work took too long. No `except Exception` stops it."""


class TookTooLong(Exception):
    """Work was given up; `stack` is where it was by then."""

    def __init__(self, said: str, stack: StackSummary) -> None:
        super().__init__(said)
        self.stack = stack


def run_limited(work: Callable[[], T], seconds: float, name: str) -> T:
    """The value of `work()`, done in a thread of that name. Raises what it raises.

    Raises TookTooLong after `seconds`.
    """
    values: list[T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            values.append(work())
        except BaseException as error:
            errors.append(error)

    # the work belongs to the thread that waits for it: it has that one's global executor
    context = contextvars.copy_context()
    thread = threading.Thread(target=context.run, args=(run,), name=name, daemon=True)
    thread.start()
    thread.join(seconds)
    if thread.is_alive():
        stack = stack_of(thread)
        interrupt(thread)
        raise TookTooLong(f"did not return within {seconds:g} s", stack)
    if errors:
        raise errors[0]
    return values[0]


def stack_of(thread: threading.Thread) -> StackSummary:
    """Where a thread is now; empty when it has ended."""
    frame = sys._current_frames().get(thread.ident or 0)
    return extract_stack(frame) if frame is not None else StackSummary()


def interrupt(thread: threading.Thread) -> bool:
    """Have a thread end that runs Python code; False when it does not, as in a long `sleep`."""
    if thread.ident is not None and thread.is_alive():
        raise_in(thread)
        thread.join(_GRACE)
    return not thread.is_alive()


def raise_in(thread: threading.Thread) -> None:
    """Raise Interrupted in a thread, as soon as it runs Python code.

    It is CPython's own means for it: an exception that is raised in another thread
    (https://docs.python.org/3/c-api/threads.html, PyThreadState_SetAsyncExc).
    """
    import ctypes  # for this alone, which is rarely needed

    number = ctypes.c_ulong(thread.ident or 0)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(number, ctypes.py_object(Interrupted))
