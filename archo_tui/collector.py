"""Short pauses of Python's garbage collector, which holds up every thread, STOP's too."""

from __future__ import annotations

import gc
import time
from typing import Any

_LONG = 0.02  # s of the processor; STOP has 0.1 s in all
_FULL = 2  # the generation of a full collection

_begun = 0.0  # when the last full collection did, in s of its thread


def limit_pauses() -> None:
    """Leave what a long full collection has kept out of the next ones, from now on.

    In a flood the black box holds half a million messages, and looking through them took 0.2 s.
    They are still freed by reference count; only a cycle that lived then, an open dialog for
    example, is not freed any more.
    """
    gc.callbacks.append(_on_collection)


def end_of_limit() -> None:
    """Undo `limit_pauses`, if it was called."""
    if _on_collection in gc.callbacks:
        gc.callbacks.remove(_on_collection)


def _on_collection(phase: str, info: dict[str, Any]) -> None:
    global _begun
    if info["generation"] < _FULL:
        return
    if phase == "start":
        _begun = time.thread_time()
    elif time.thread_time() - _begun > _LONG:
        gc.freeze()
