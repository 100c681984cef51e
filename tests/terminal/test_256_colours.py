"""Where a terminal has 256 colours, as over SSH and in tmux, dark surfaces stay dark greys."""

from __future__ import annotations

import re

import pytest

from tests.support.terminal import Terminal

_GREYS = {*range(232, 256)}
_STOP = 124  # red
_TRACK = 16  # of a scroll bar: black with all colours, too


@pytest.mark.real_time
def test_no_surface_turns_blue_or_black() -> None:
    terminal = Terminal(term="xterm-256color")
    terminal.until("max_speed")
    terminal.write("q")
    assert terminal.exit_code() == 0
    terminal.close()
    behind = {int(number) for number in re.findall(rb"48;5;(\d+)m", terminal.output)}
    assert behind & _GREYS
    assert behind <= {*_GREYS, _TRACK, _STOP}
