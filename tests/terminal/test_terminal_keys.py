"""Real bytes in a pseudo terminal: escape, answers, pastes and the mouse, and STOP behind them."""

from __future__ import annotations

import time

import pytest

from tests.support.night import corners
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


def test_answers_of_the_terminal_give_no_command(terminal: Terminal) -> None:
    answers = [
        *("\x1b]11;rgb:1e1e/1e1e/1e1e\a", "\x1b]52;c;cm0gLXJmIC8K\x1b\\", "\x1b]l sargr\x1b\\"),
        *("\x1bP>|XTerm(388)\x1b\\", "\x1bP1+r544e=787465726d\x1b\\", "\x1b_Gi=31;OK\x1b\\"),
        *("\x1b[?1;2c", "\x1b[>41;388;0c", "\x1b[?0u", "\x1b[?997;1n", "\x1b[8;24;80t"),
    ]
    terminal.write("".join(answers))
    for answer in answers[:6]:  # the escape alone, within a sequence, within its end
        for at in (1, 6, len(answer) - 1):
            terminal.write(answer[:at])
            terminal.read_for(0.2)
            terminal.write(answer[at:])
    terminal.write("\x1b[1095::120;;99999999999u\x1b[1114112;5u")  # nor do these end the input
    terminal.write("\x1b[1095::120;5u")  # ctrl+x under a Russian layout
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
    terminal.write("\x18")
    until_said(STOP)
    assert ordered_at_the_end(terminal) == [STOP]


@pytest.mark.parametrize("stop", corners(["\x18"], ["\x1b[120;5u"]))
def test_stop_alone_ends_a_paste_at_once(stop: str, terminal: Terminal) -> None:
    terminal.write(f"{BEGIN}12")
    terminal.read_for(0.3)
    terminal.write(stop)
    until_said(STOP, deadline=1.5)  # before it stalls
    terminal.until(CUT)
    assert ordered_at_the_end(terminal) == [STOP]


def test_stop_behind_two_thousand_mouse_moves_waits_for_none_of_them(terminal: Terminal) -> None:
    moves = "".join(f"\x1b[<35;{n % 100 + 1};{n % 30 + 1}M" for n in range(2000))
    began = time.monotonic()
    for at in range(0, len(moves), 1000):  # a terminal takes a few thousand bytes at once
        terminal.write(moves[at : at + 1000])
    terminal.write("\x18")
    until_said(STOP)
    assert time.monotonic() - began < 1.5
    assert ordered_at_the_end(terminal) == [STOP]
