"""Short pauses of Python's garbage collector, which holds up every thread, STOP's included."""

from __future__ import annotations

import gc
import time

_LONG = 0.02  # Seconds of processor time; STOP has 0.1 s in all.
_FULL = 2  # The generation of a full collection.


class ShortPauses:
    """A context in which each full collection stays short, however many objects are kept.

    In a flood the black box holds half a million objects, and looking through them takes 0.2 s.
    What a long full collection has kept is left out of the following ones (`gc.freeze`); when half
    of it has been freed, the flood is over, and the rest is looked through again.
    """

    def __init__(self) -> None:
        self._begun = 0.0  # Processor time of the thread at the begin of a full collection, in s.
        self._frozen = 0  # Objects frozen after the last long collection, or 0.
        self._base = 0  # Those of them that were frozen before the flood.

    def __enter__(self) -> None:
        """Begin to watch the collections of the process."""
        gc.callbacks.append(self._on_collection)

    def __exit__(self, *_: object) -> None:
        """End the watch, and let collections look through all again, also what was left out."""
        gc.callbacks.remove(self._on_collection)
        if self._frozen:
            gc.unfreeze()

    def _on_collection(self, phase: str, info: dict[str, int]) -> None:
        if info["generation"] < _FULL:
            return
        if phase == "start":
            if self._frozen and gc.get_freeze_count() < (self._base + self._frozen) / 2:
                gc.unfreeze()
                self._frozen = self._base = 0
            self._begun = time.thread_time()
        elif time.thread_time() - self._begun > _LONG:
            if not self._frozen:
                self._base = gc.get_freeze_count()
            gc.freeze()
            self._frozen = gc.get_freeze_count()
