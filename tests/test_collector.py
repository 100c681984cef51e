"""Pauses of the garbage collector stay short, however much the black box holds."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Iterator

import pytest

from archo_tui.base.collector import ShortPauses


class Kept:
    """A message, or a dialog that refers to itself."""

    def __init__(self, *, in_cycle: bool = False) -> None:
        self.itself = self if in_cycle else None


Collect = Callable[[float], None]  # a full collection that takes so many seconds


@pytest.fixture
def collect(monkeypatch: pytest.MonkeyPatch) -> Iterator[Collect]:
    gc.freeze()  # all that the other tests have left: only what is made here counts
    frozen, now = gc.get_freeze_count(), 0.0

    def run(seconds: float) -> None:
        nonlocal now
        times = iter((now, now + seconds))
        now += seconds
        monkeypatch.setattr("archo_tui.base.collector.time.thread_time", lambda: next(times, now))
        gc.collect()

    with ShortPauses():
        yield run
    if gc.get_freeze_count() < frozen:
        gc.freeze()  # as before


def is_looked_through(kept: object) -> bool:
    return any(found is kept for found in gc.get_objects())


@pytest.mark.parametrize(("took", "is_left_out"), [(0.5, True), (0.001, False)])
def test_what_a_long_collection_kept_is_left_out_of_the_next(
    collect: Collect, took: float, is_left_out: bool
) -> None:
    kept = [Kept()]
    gc.collect(1)  # of the young: it is not timed
    collect(took)
    assert is_looked_through(kept) is not is_left_out


def test_it_is_freed_by_reference_count_all_the_same(collect: Collect) -> None:
    kept = [Kept()]
    freed = weakref.ref(kept[0])
    collect(1.0)
    kept.clear()
    assert freed() is None


def test_a_dialog_that_was_open_in_a_flood_is_freed_after_it(collect: Collect) -> None:
    dialog = Kept(in_cycle=True)
    freed = weakref.ref(dialog)
    flood = [Kept() for _ in range(1000)]
    collect(1.0)
    del dialog
    flood.pop()
    collect(0.001)
    assert freed() is not None  # the flood goes on
    flood.clear()
    collect(0.001)
    assert freed() is None
