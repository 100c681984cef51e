"""Pastes: text or nothing, whatever is in them, however they come, and never keys."""

from __future__ import annotations

import random

import pytest

from archo_tui.terminal.paste import PASTE_LIMIT
from tests.support.typed import LONG, Typed, typed

BEGIN, END = "\x1b[200~", "\x1b[201~"
ESCAPES = ["\x1b", "\x1b[27u", "\x1b[27;1u", "\x1b[27;129u"]
STOPS = ["\x18", "\x1b[120;5u", "\x1b[1095::120;5u", "\x1b[27;5;88~"]
KEYS = {"r": "r", "\r": "enter", "\x1b[A": "up", "\x1bOP": "f1", "\x1b[114;;114u": "r"}


def broken() -> Typed:
    """A paste whose end did not come."""
    return Typed().read(BEGIN + "12").wait(2.2)


def test_a_paste_is_one_text_whatever_is_in_it() -> None:
    pressed = typed(f"{BEGIN}1\x18 \x1b é\x00\r\n\x1b[A\x1b]11;x\a{END}r")
    assert pressed.pastes == ["1\x18 \x1b é\x00\r\n\x1b[A\x1b]11;x\a"]
    assert pressed.names == ["Paste", "Key"]


def test_it_may_come_in_pieces_with_short_silences() -> None:
    assert typed(BEGIN, "12", "3", END, "r", gap=1.9).pastes == ["123"]
    assert typed(f"{BEGIN}12", "r", "s", END, gap=0.5).names == ["Paste"]


@pytest.mark.parametrize("marks", [(BEGIN, END), ("\x9b200~", "\x9b201~")])
@pytest.mark.parametrize("gap", [0.02, 0.3])
def test_it_may_be_cut_anywhere(gap: float, marks: tuple[str, str]) -> None:
    sent = (marks[0] + "12 \x18é" + marks[1] + "r").encode()
    for at in range(1, len(sent)):
        pressed = typed(sent[:at], sent[at:], gap=gap)
        assert pressed.pastes == ["12 \x18é"], at
        assert pressed.keys in (["r"], ["escape", "r"])


def test_several_come_one_after_another() -> None:
    assert typed(f"{BEGIN}1{END}{BEGIN}2{END}{BEGIN}{END}r").pastes == ["1", "2", ""]


def test_a_thousand_in_one_read_are_a_thousand() -> None:
    assert len(typed(f"{BEGIN}1{END}" * 5000 + "r").pastes) == 5000


def test_an_end_without_a_paste_is_nothing() -> None:
    assert typed(f"{END}r").keys == ["r"]


def test_the_text_is_bounded() -> None:
    keyboard = Typed().read(BEGIN)
    for _ in range(20):
        keyboard.read("A" * (PASTE_LIMIT // 16))
    assert keyboard.read(f"{END}r").keys == ["r"]
    assert keyboard.pastes == ["A" * PASTE_LIMIT]


def test_of_a_paste_that_stalls_nothing_is_taken_and_that_is_said_once() -> None:
    keyboard = Typed().read(BEGIN + "12")
    assert keyboard.wait(1.9).names == []
    assert keyboard.wait(0.3).names == ["PasteCut"]
    assert keyboard.read("34").read(END).read("r").names == ["PasteCut", "Key"]


@pytest.mark.parametrize("sent", KEYS)
def test_a_key_alone_ends_a_broken_paste_and_acts(sent: str) -> None:
    keyboard = broken().read(sent)
    assert keyboard.keys == [KEYS[sent]]
    assert keyboard.read("gr").keys == [KEYS[sent], "g", "r"]


def test_a_key_in_two_pieces_is_alone_too() -> None:
    assert broken().read("\x1b").read("[A", after=0.05).keys == ["up"]


def test_the_rest_of_a_broken_paste_is_no_keys() -> None:
    keyboard = broken().read("34").read("r", after=0.05)
    assert keyboard.keys == []
    assert keyboard.read("r", after=1.9).keys == []  # too soon to be a key
    assert keyboard.read("r", after=2.1).keys == ["r"]


@pytest.mark.parametrize("gap", [0.0, 0.05, 0.3, 2.5])
@pytest.mark.parametrize("length", [2, 3, 5, 7])
def test_in_pieces_of_two_bytes_and_more_it_is_none_either(length: int, gap: float) -> None:
    rest = ("agrsyq7\r\x18gr" * 3 + "éчжß" + "r" * 20).encode()
    keyboard = broken()
    for at in range(0, len(rest) - length, length):
        keyboard.read(rest[at : at + length], after=gap)
    assert keyboard.keys == []
    assert keyboard.read(END, after=gap).read("r").keys == ["r"]
    assert keyboard.pastes == []


@pytest.mark.parametrize("gap", [0.02, 0.3, 2.5])
def test_the_late_end_may_come_in_two_pieces(gap: float) -> None:
    for at in range(1, len(END)):
        keyboard = broken().read("34" + END[:at]).read(END[at:] + "r", after=gap)
        assert keyboard.keys == ["r"], at


def test_the_end_may_begin_before_the_paste_is_broken() -> None:
    keyboard = Typed().read(f"{BEGIN}12\x1b[20").read("1~r", after=2.5)
    assert keyboard.names == ["PasteCut", "Key"]


@pytest.mark.parametrize("sent", STOPS)
@pytest.mark.parametrize("times", [2, 3, 40])
def test_a_stop_that_is_held_ends_a_paste_too(sent: str, times: int) -> None:
    pressed = Typed().read(BEGIN + "12").wait(0.3).read(sent * times)
    assert pressed.keys[:1] == ["ctrl+x"]


@pytest.mark.parametrize("sent", [*ESCAPES, *STOPS])
@pytest.mark.parametrize("state", ["new", "broken", "rest"])
def test_escape_or_stop_alone_ends_any_paste_and_acts(state: str, sent: str) -> None:
    keyboard = Typed().read(BEGIN + "12") if state == "new" else broken()
    if state == "rest":
        keyboard.read("34")
    keyboard.read(sent, after=0.12).wait(0.14)
    assert keyboard.names == ["PasteCut", "Key"]
    assert keyboard.keys == ["escape" if sent in ESCAPES else "ctrl+x"]
    assert keyboard.read("r").keys[1:] == ["r"]
    assert keyboard.pastes == []


@pytest.mark.parametrize("sent", ["\x1b", "\x1b[", "\x1bO", "\x1b]"])
def test_the_silence_behind_what_is_not_complete_is_looked_at_soon(sent: str) -> None:
    assert Typed().read(sent).keyboard.waiting
    assert broken().read("\x1b").keyboard.waiting
    assert not Typed().read("r").keyboard.waiting
    assert not broken().keyboard.waiting


@pytest.mark.parametrize("sent", ["\x1b", "\x18"])
def test_amid_text_they_are_text(sent: str) -> None:
    assert typed(f"{BEGIN}1{sent}2", f"3{sent}", f"{sent}4{END}", gap=0.5).pastes == [
        f"1{sent}23{sent}{sent}4"
    ]
    assert typed(f"{BEGIN}1", sent, f"2{END}", gap=0.05).pastes == [f"1{sent}2"]


def test_an_escape_that_begins_the_end_mark_is_none() -> None:
    keyboard = Typed().read(BEGIN + "12").read("\x1b", after=0.3).read("[201~r", after=0.05)
    assert keyboard.pastes == ["12"]
    assert keyboard.keys == ["r"]


def test_an_end_mark_behind_the_escape_that_ended_the_paste_is_no_key() -> None:
    keyboard = Typed().read(BEGIN + "12").read("\x1b", after=0.3).read("[201~r", after=0.3)
    assert keyboard.names == ["PasteCut", "Key", "Key"]
    assert keyboard.keys == ["escape", "r"]


@pytest.mark.parametrize("pause", [0.3, 2.5])
def test_a_second_paste_is_taken_though_the_first_one_has_no_end(pause: float) -> None:
    keyboard = Typed().read(BEGIN + "12").read(f"{BEGIN}34{END}", after=pause)
    assert keyboard.names == ["PasteCut", "Paste"]
    assert keyboard.pastes == ["34"]


def test_a_mouse_that_moves_hides_no_stop_and_is_no_text() -> None:
    keyboard = Typed().read(BEGIN + "12").wait(0.5)
    for column in range(1, 30):
        keyboard.read(f"\x1b[<35;{column};1M", after=0.04)
    assert keyboard.read("\x18", after=0.04).keys == ["ctrl+x"]
    assert set(keyboard.names) == {"MouseMove", "PasteCut", "Key"}
    keyboard = Typed().read(BEGIN + "12").read(f"\x1b[I3{END}\x1b[<0;1;1M")
    assert keyboard.names == ["AppFocus", "Paste", "MouseDown"]
    assert keyboard.pastes == ["123"]


@pytest.mark.parametrize("seed", range(20))
def test_no_paste_is_ever_keys(seed: int) -> None:
    """Any text in any pieces of two bytes and more, with any silences, its end lost or not."""
    chance = random.Random(seed)
    keyboard = Typed()
    for _ in range(5):
        text = "".join(chance.choices("agrsyq7\r\n \x18[éч", k=chance.randint(40, 200)))
        sent = (BEGIN + text + chance.choice([END, END, ""])).encode()
        cut = len(BEGIN) + 1
        keyboard.read(sent[:cut], after=0.3)
        while len(sent) > cut:
            begin, cut = cut, cut + chance.randint(2, 30)
            piece = sent[begin : cut if len(sent) - cut > 1 else len(sent)]
            keyboard.read(piece, after=chance.choice([0.0, 0.05, 0.12, 0.5, 2.5]))
            cut = begin + len(piece)
    keyboard.read(END).wait(LONG)
    assert keyboard.keys == []
