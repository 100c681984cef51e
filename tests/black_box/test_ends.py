"""A console that ends in the middle of a recording has written it."""

from __future__ import annotations

import signal

import pytest

from archo_tui.base.paths import state_file
from archo_tui.recordings import store
from tests.support.night import corners
from tests.support.terminal import Terminal

pytestmark = [pytest.mark.posix, pytest.mark.real_time]
SLOW = """
import time
from archo_tui.recordings import bag
bag.BagWriter.finish = lambda *_: time.sleep(60)
"""


@pytest.mark.parametrize("way", corners(["keys"], [signal.SIGTERM, signal.SIGHUP]))
def test_a_stop_just_before_the_end_is_recorded(way: str | signal.Signals) -> None:
    terminal = Terminal()
    terminal.until("● online")
    terminal.write("\x18")
    terminal.until("STOPPED")
    if isinstance(way, signal.Signals):
        terminal.kill(way)
    else:
        terminal.write("\x11")
    terminal.exit_code()
    assert [one.why for one in store.list_recordings(state_file("recordings"))] == ["STOP"]


def test_a_disk_that_hangs_holds_the_end_up_for_a_moment_only() -> None:
    terminal = Terminal(code=SLOW)
    terminal.until("● online")
    terminal.write("\x18")
    terminal.until("STOPPED")
    terminal.write("\x11")
    terminal.until("recording not written: the disk is too slow")
    assert terminal.exit_code() == 0
    assert not [p for p in state_file("recordings").iterdir() if not p.name.startswith(".")]
