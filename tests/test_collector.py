"""Pauses of the garbage collector stay short, however much the black box holds."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest

from archo_tui import collector


@pytest.fixture(autouse=True)
def _limited() -> Iterator[None]:
    frozen = gc.get_freeze_count()
    collector.limit_pauses()
    yield
    collector.end_of_limit()
    if gc.get_freeze_count() != frozen:
        gc.unfreeze()


@pytest.mark.parametrize(("took", "is_left_out"), [(0.5, True), (0.001, False)])
def test_what_a_long_collection_kept_is_left_out_of_the_next(
    monkeypatch: pytest.MonkeyPatch, took: float, is_left_out: bool
) -> None:
    kept, times = [object()], iter((0.0, took))
    monkeypatch.setattr("archo_tui.collector.time.thread_time", lambda: next(times))
    gc.collect(1)  # of the young: it is not looked at
    gc.collect()
    assert all(found is not kept for found in gc.get_objects()) is is_left_out


def test_it_is_freed_by_reference_count_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    class Message:
        freed = False

        def __del__(self) -> None:
            Message.freed = True

    kept, times = [Message()], iter((0.0, 1.0))
    monkeypatch.setattr("archo_tui.collector.time.thread_time", lambda: next(times))
    gc.collect()
    kept.clear()
    assert Message.freed
