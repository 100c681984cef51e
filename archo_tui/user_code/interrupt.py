"""Exceptions that are raised in another thread, to end what it runs."""

from __future__ import annotations

import gc
import sys
import threading
from traceback import StackSummary, walk_stack
from types import FrameType


class Interrupted(BaseException):
    """The exception that ends a thread; no `except Exception` of a user catches it."""


def raise_in(thread: threading.Thread, error: type[BaseException] = Interrupted) -> None:
    """Raise an error in a thread as soon as it runs Python code, which a long `sleep` does not.

    By CPython's PyThreadState_SetAsyncExc: https://docs.python.org/3/c-api/threads.html.
    """
    import ctypes  # Imported here, because it is rarely needed.

    number = ctypes.c_ulong(thread.ident or 0)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(number, ctypes.py_object(error))


_looking = threading.Lock()


def frame_of(thread: threading.Thread) -> FrameType | None:
    """Return the innermost frame of a thread as it is now; None if the thread has ended.

    Meanwhile no garbage is collected: CPython 3.11 holds a lock of the interpreter here, and if a
    collection called Python code, another thread could wait for that lock for ever, with the GIL.
    """
    with _looking:
        was_enabled = gc.isenabled()
        gc.disable()
        try:
            return sys._current_frames().get(thread.ident or 0)
        finally:
            if was_enabled:
                gc.enable()


def stack_of(thread: threading.Thread) -> StackSummary:
    """Return the stack of a thread as it is now; an empty one if the thread has ended.

    The text of a line is read only once it is asked for.
    """
    frame = frame_of(thread)
    # Of no frame, walk_stack walks the caller's.
    walk = walk_stack(frame) if frame is not None else iter(())
    stack = StackSummary.extract(walk, lookup_lines=False)
    stack.reverse()
    return stack
