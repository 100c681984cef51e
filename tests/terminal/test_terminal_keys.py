"""Real bytes in a pseudo terminal: escape, answers, pastes and the mouse, and STOP behind them."""

from __future__ import annotations

import time

import pytest

from tests.support.terminal import Start, Terminal, said, until_said

BEGIN, END = "\x1b[200~", "\x1b[201~"
CUT = "The paste was cut off"
RESET, STOP = "reset encoder: Encoder reset to zero", "STOP: confirmed"


@pytest.fixture
def terminal(start: Start) -> Terminal:
    return start()


def ordered_at_the_end(terminal: Terminal) -> list[str]:
    """What was ordered, when it ends by its key."""
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert "Traceback" not in terminal.text
    return said("command")


def test_escape_acts_at_once_and_the_next_key_is_a_key(terminal: Terminal) -> None:
    times = []
    for _ in range(5):  # a busy machine may be late now and then
        terminal.output = b""
        terminal.write("?")
        terminal.until("Show all keys")
        terminal.output = b""
        began = time.monotonic()
        terminal.write("\x1b")
        terminal.until("max_speed")  # what was behind the help
        times.append(time.monotonic() - began)
    terminal.write("r")
    until_said(RESET)
    assert min(times) < 0.4  # 0.15, and what it takes to draw
    assert ordered_at_the_end(terminal) == [RESET]


@pytest.mark.parametrize("before", ["", "?", "\x10", "12"])  # in the field, help, the palette
def test_escape_and_a_digit_at_once_lead_to_a_panel(before: str, terminal: Terminal) -> None:
    terminal.write(before)
    terminal.read_for(0.3)
    terminal.write("\x1b8")  # as tmux sends both; it might be alt+8
    terminal.until("MoveToShelf")  # Graph, over the whole screen
    terminal.write("\x1b6\x1b\x18")
    until_said(STOP)
    assert ordered_at_the_end(terminal) == [STOP]


def test_the_keys_of_other_layouts_are_asked_for(terminal: Terminal) -> None:
    assert b"\x1b[<u\x1b[>5u" in terminal.output  # in place of Textual's, under which text is keys
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert b"\x1b[<u" in terminal.output


def test_the_rest_of_a_paste_that_stalled_is_text_and_that_is_said(
    terminal: Terminal,
) -> None:
    terminal.leave_field()
    terminal.write("/")
    terminal.until("ype to search")
    terminal.write(f"{BEGIN}whe")
    terminal.until("The paste has not ended: what you type is added to it")
    for char in "el_rsr":
        terminal.write(char)
        terminal.read_for(0.3)
    terminal.write(f"\x18r{END}")
    terminal.write(f"{BEGIN}12")
    terminal.read_for(0.3)
    terminal.write("\x18")
    until_said(STOP, deadline=1.5)  # alone it ends a paste before that stalls
    terminal.until(CUT)
    assert ordered_at_the_end(terminal) == [STOP]


def test_stop_behind_two_thousand_mouse_moves_waits_for_none_of_them(terminal: Terminal) -> None:
    moves = "".join(f"\x1b[<35;{n % 100 + 1};{n % 30 + 1}M" for n in range(2000))
    began = time.monotonic()
    for at in range(0, len(moves), 1000):  # a terminal takes a few thousand bytes at once
        terminal.write(moves[at : at + 1000])
    terminal.write("\x1b[1095::120;5u")  # ctrl+x under a Russian layout
    until_said(STOP)
    assert time.monotonic() - began < 1.5
    assert ordered_at_the_end(terminal) == [STOP]
