"""The stack of another thread, looked at without a collection of garbage meanwhile."""

from __future__ import annotations

import gc
import sys
import threading
from types import FrameType

import pytest

from archo_tui.user_code.interrupt import frame_of


@pytest.mark.parametrize("was_enabled", [True, False])
def test_no_garbage_is_collected_while_the_frames_are_taken(
    was_enabled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[bool] = []
    frames = sys._current_frames

    def current_frames() -> dict[int, FrameType]:
        seen.append(gc.isenabled())
        return frames()

    monkeypatch.setattr(sys, "_current_frames", current_frames)
    before = gc.isenabled()
    (gc.enable if was_enabled else gc.disable)()
    try:
        assert frame_of(threading.current_thread()) is not None
        assert gc.isenabled() is was_enabled
    finally:
        (gc.enable if before else gc.disable)()
    assert seen == [False]
