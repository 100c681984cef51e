"""Running user code with a time limit, after which it is interrupted."""

from __future__ import annotations

import contextvars
import sys
import threading
from collections.abc import Callable
from traceback import StackSummary, extract_stack
from typing import TypeVar

T = TypeVar("T")

_GRACE = 0.5  # Seconds that interrupted work has to end.


class Interrupted(BaseException):
    """The exception that `interrupt` and `raise_in` raise in a thread, to end it.

    No `except Exception` of a user catches it.
    """


class TookTooLong(Exception):
    """The error for work that took longer than its time limit.

    Attributes:
        stack: The stack of the work when its time was over.
    """

    def __init__(self, text: str, stack: StackSummary) -> None:
        """Create the error with its text and the stack of the work."""
        super().__init__(text)
        self.stack = stack


def run_limited(work: Callable[[], T], seconds: float, name: str) -> T:
    """Run work in a thread of its own, and wait for it.

    Args:
        work: The function to run.
        seconds: The time limit.
        name: The name of the thread, by which its output is known.

    Returns:
        The value that the work returns.

    Raises:
        TookTooLong: The work took longer; it was interrupted, and runs on if that failed.
        BaseException: The exception that the work raises.
    """
    values: list[T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            values.append(work())
        except BaseException as error:
            errors.append(error)

    # The work has the context variables of the thread that waits, and so its global executor.
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
    """Return the stack of a thread as it is now; an empty one if the thread has ended."""
    frame = sys._current_frames().get(thread.ident or 0)
    return extract_stack(frame) if frame is not None else StackSummary()


def interrupt(thread: threading.Thread) -> bool:
    """Raise Interrupted in a thread and wait at most half a second for its end.

    Returns:
        True if the thread has ended or was never started; False if it catches the exception, or
        runs no Python code, as in a long `sleep`.
    """
    if thread.ident is not None and thread.is_alive():
        raise_in(thread)
        thread.join(_GRACE)
    return not thread.is_alive()


def raise_in(thread: threading.Thread, error: type[BaseException] = Interrupted) -> None:
    """Raise an error in a thread, as soon as it runs Python code; return without waiting for that.

    This uses CPython's PyThreadState_SetAsyncExc: https://docs.python.org/3/c-api/threads.html.
    """
    import ctypes  # Imported here, because it is rarely needed.

    number = ctypes.c_ulong(thread.ident or 0)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(number, ctypes.py_object(error))
