"""Pastes: text or nothing, whatever is in them, however they come, and never keys."""

from __future__ import annotations

import random

import pytest

from archo_tui.screen.terminal.keyboard import PASTE_LIMIT
from tests.support.typed import LONG, Typed, typed

BEGIN, END = "\x1b[200~", "\x1b[201~"
ESCAPES = ["\x1b", "\x1b[27u", "\x1b[27;1u", "\x1b[27;129u"]
STOPS = ["\x18", "\x1b[120;5u", "\x1b[1095::120;5u", "\x1b[27;5;88~"]


def stalled() -> Typed:
    """A paste of which nothing has come for a while."""
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
    assert len(typed(f"{BEGIN}1{END}" * 5000 + "r").pastes) == 5000
    assert typed(f"{END}r").keys == ["r"]  # an end without a paste


def test_the_text_is_bounded() -> None:
    keyboard = Typed().read(BEGIN)
    for _ in range(20):
        keyboard.read("A" * (PASTE_LIMIT // 16))
    assert keyboard.read(f"{END}r").keys == ["r"]
    assert keyboard.pastes == ["A" * PASTE_LIMIT]


def test_a_paste_that_stalls_is_whole_and_its_way_out_is_said_once() -> None:
    keyboard = Typed().read(BEGIN + "12")
    assert keyboard.wait(1.9).names == []
    assert keyboard.wait(0.3).names == ["PasteStalled"]
    keyboard.read("34").wait(60.0).read(f"5{END}r")
    assert keyboard.names == ["PasteStalled", "Paste", "Key"]
    assert keyboard.pastes == ["12345"]


@pytest.mark.parametrize("gap", [0.0, 0.05, 0.12, 2.5])
@pytest.mark.parametrize("length", [1, 2, 7])
def test_nothing_of_a_paste_that_stalls_is_a_key(length: int, gap: float) -> None:
    text = (
        ("agrsyq7\r\x18gr" if length > 1 else "agrsyq7\rgr") * 3
        + "éчжß"
        + "\x1b[A\x1bOP\x1b[114;;114u" * (length > 1)
        + "r" * 20
    )
    rest, keyboard = text.encode(), stalled()
    for at in range(0, len(rest), length):
        keyboard.read(rest[at : at + length], after=gap)
    assert keyboard.keys == []
    assert keyboard.read(END, after=gap).read("r").keys == ["r"]
    assert keyboard.pastes == [f"12{text}"]


@pytest.mark.parametrize("gap", [0.02, 0.3, 2.5])
def test_the_late_end_may_come_in_two_pieces(gap: float) -> None:
    for at in range(1, len(END)):
        keyboard = stalled().read("34" + END[:at]).read(END[at:] + "r", after=gap)
        assert (keyboard.keys, keyboard.pastes) == (["r"], ["1234"]), at


def test_the_end_may_begin_before_the_paste_stalls() -> None:
    keyboard = Typed().read(f"{BEGIN}12\x1b[20").read("1~r", after=2.5)
    assert keyboard.names == ["PasteStalled", "Paste", "Key"]


@pytest.mark.parametrize("sent", STOPS)
@pytest.mark.parametrize("times", [2, 3, 40])
def test_a_stop_that_is_held_ends_a_paste_too(sent: str, times: int) -> None:
    pressed = Typed().read(BEGIN + "12").wait(0.3).read(sent * times)
    assert pressed.keys[:1] == ["ctrl+x"]


@pytest.mark.parametrize("state", ["new", "stalled", "rest"])
@pytest.mark.parametrize(
    ("sent", "key"), [*((e, "escape") for e in ESCAPES), *((s, "ctrl+x") for s in STOPS)]
)
def test_escape_or_stop_alone_ends_any_paste_and_acts(state: str, sent: str, key: str) -> None:
    keyboard = Typed().read(BEGIN + "12") if state == "new" else stalled()
    if state == "rest":
        keyboard.read("34")
    keyboard.read(sent, after=0.6 if key == "escape" else 0.12)
    assert keyboard.keys == ([] if key == "escape" else ["ctrl+x"])  # which waits for nothing
    keyboard.wait(0.6)
    assert [name for name in keyboard.names if name != "PasteStalled"] == ["PasteCut", "Key"]
    assert keyboard.keys == [key]
    assert keyboard.read("r").keys[1:] == ["r"]
    assert keyboard.pastes == []


def test_of_an_end_mark_byte_by_byte_only_the_escape_is_a_key() -> None:
    keyboard = Typed()
    for char in f"{BEGIN}12":
        keyboard.read(char)
    for char in f"{END}[r":
        keyboard.read(char, after=2.5)
    assert keyboard.keys == ["escape", "left_square_bracket", "r"]


@pytest.mark.parametrize("sent", ESCAPES)
@pytest.mark.parametrize(("before", "behind"), [(0.4, 2.0), (2.0, 0.4), (0.4, 0.4)])
def test_an_escape_near_text_is_text(sent: str, before: float, behind: float) -> None:
    keyboard = Typed().read(BEGIN + "12").read(sent, after=before).read("3", after=behind)
    assert keyboard.keys == []
    assert keyboard.wait(5.0).read(END).pastes == [f"12{sent}3"]


@pytest.mark.parametrize("sent", ["\x1b", "\x1b[", "\x1bO", "\x1b]"])
def test_the_silence_behind_what_is_not_complete_is_looked_at_soon(sent: str) -> None:
    assert Typed().read(sent).keyboard.is_waiting
    assert stalled().read("\x1b").keyboard.is_waiting
    assert not Typed().read("r").keyboard.is_waiting
    assert not stalled().keyboard.is_waiting


@pytest.mark.parametrize("sent", ["\x1b", "\x18"])
def test_amid_text_they_are_text(sent: str) -> None:
    assert typed(f"{BEGIN}1{sent}2", f"3{sent}", f"{sent}4{END}", gap=0.5).pastes == [
        f"1{sent}23{sent}{sent}4"
    ]
    assert typed(f"{BEGIN}1", sent, f"2{END}", gap=0.05).pastes == [f"1{sent}2"]


def test_an_end_mark_behind_the_escape_that_ended_the_paste_is_no_key() -> None:
    keyboard = Typed().read(BEGIN + "12").read("\x1b", after=0.6).read("[201~r", after=0.6)
    assert keyboard.names == ["PasteCut", "Key", "Key"]
    assert keyboard.keys == ["escape", "r"]


@pytest.mark.parametrize("pause", [0.3, 2.5])
def test_a_second_paste_is_taken_though_the_first_one_has_no_end(pause: float) -> None:
    keyboard = Typed().read(BEGIN + "12").read(f"{BEGIN}34{END}", after=pause)
    assert [name for name in keyboard.names if name != "PasteStalled"] == ["PasteCut", "Paste"]
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
    """Any text without escapes and STOPs in any pieces, with any silences, its end lost or not."""
    chance = random.Random(seed)
    keyboard = Typed()
    for _ in range(5):
        text = "".join(chance.choices("agrsyq7\r\n [éч", k=chance.randint(40, 200)))
        sent = (BEGIN + text + chance.choice([END, END, ""])).encode()
        cut = len(BEGIN) + 1
        keyboard.read(sent[:cut], after=0.3)
        while len(sent) > cut:
            begin, cut = cut, cut + chance.randint(1, 30)
            if len(sent) - len(END) < cut and sent.endswith(END.encode()):
                cut = len(sent)  # of an end mark in pieces the first may be an escape alone
            keyboard.read(sent[begin:cut], after=chance.choice([0.0, 0.05, 0.12, 0.5, 2.5]))
    keyboard.read(END).wait(LONG)
    assert keyboard.keys == []
