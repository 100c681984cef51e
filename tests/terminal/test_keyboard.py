"""Keys, answers of the terminal and the mouse, from bytes to what acts; pastes: test_paste.py."""

from __future__ import annotations

import itertools
import random

import pytest
from textual import events
from textual.message import Message

from archo_tui.screen.terminal.keyboard import STRING_LIMIT, Keyboard
from tests.support.night import corners
from tests.support.typed import LONG, Typed, typed

BEGIN, END = "\x1b[200~", "\x1b[201~"
ST = "\x1b\\"
ANSWERS = [
    *("\x1b]11;rgb:1e1e/1e1e/1e1e\a", f"\x1b]11;rgb:1e1e/1e1e/1e1e{ST}"),
    *(f"\x1b]10;rgb:ffff/ffff/ffff{ST}", "\x1b]4;1;rgb:cdcd/0000/0000\a"),
    *("\x1b]52;c;cm0gLXJmIC8K\a", f"\x1b]l a title gr7{ST}", f"\x1b]L an icon gr7{ST}"),
    *(f"\x1bP>|XTerm(388){ST}", f"\x1bP!|00000000{ST}"),
    *(f"\x1bP1+r544e=787465726d{ST}", f"\x1bP0+r{ST}", f"\x1bP1$r0m{ST}", f"\x1bP0$r{ST}"),
    f"\x1b_Gi=31;OK{ST}",
    *("\x1b[?1;2c", "\x1b[?64;1;2;6;22c", "\x1b[>41;388;0c", "\x1b[>0;276;0c"),
    *("\x1b[?0u", "\x1b[?25u", "\x1b[?997;1n", "\x1b[0n"),
    *("\x1b[8;24;80t", "\x1b[4;600;800t", "\x1b[9;50;160t"),
]
SENT = [*ANSWERS, BEGIN, END]
GAPS = [0.02, 0.08, 0.12, 0.25, 0.4]  # s


# escape


def test_escape_acts_after_a_tenth_of_a_second() -> None:
    keyboard = Typed().read("\x1b")
    assert keyboard.wait(0.09).keys == []
    assert keyboard.wait(0.06).keys == ["escape"]


def test_a_letter_that_comes_later_is_a_letter() -> None:
    keyboard = Typed().read("\x1b").read("n", after=0.12)
    assert keyboard.keys == ["escape", "n"]
    assert keyboard.text == "n"


def test_so_it_is_when_nobody_looked_meanwhile() -> None:
    keyboard = Keyboard()
    messages = keyboard.feed(b"\x1b", 7.0) + keyboard.feed(b"n", 7.2)
    assert [key.key for key in messages if isinstance(key, events.Key)] == ["escape", "n"]


@pytest.mark.parametrize("gap", [0.0, 0.05])
@pytest.mark.parametrize(
    ("char", "key"),
    [
        *(("n", "alt+n"), ("N", "alt+shift+n"), ("/", "alt+slash")),
        *((" ", "alt+space"), ("ж", "alt+ж"), ("Ж", "alt+shift+ж"), ("O", "alt+shift+o")),
    ],
)
def test_a_character_directly_behind_an_escape_is_no_text(char: str, key: str, gap: float) -> None:
    pressed = typed("\x1b", char, gap=gap)
    assert pressed.keys == [key]
    assert pressed.text == ""


@pytest.mark.parametrize("gap", [0.0, 0.05, 0.3])
@pytest.mark.parametrize(
    ("char", "key"),
    [("\x18", "ctrl+x"), ("\x11", "ctrl+q"), ("\r", "enter"), ("\x1a", "ctrl+z")],
)
def test_a_control_character_behind_an_escape_is_a_key_of_its_own(
    char: str, key: str, gap: float
) -> None:
    assert typed("\x1b", char, gap=gap).keys == ["escape", key]


BEGUN = ["\x1b[1;", "\x1b]52;c;AAAA", "\x1bPabc", "\x1b_G", "\x1b[M!"]
X_OF_ANY_LAYOUT = [
    *("\x1b[120;5u", "\x1b[1095;5u", "\x1b[1095::120;5u", "\x1b[967;5u", "\x1b[967::120;5u"),
    *("\x1b[27;5;88~", "\x1b[27;5;120~", "\x1b[88;5u", "\x1b[120;69u", "\x1b[120;133u"),
    *("\x1b[1063;5u", "\x1b[120:88;5:1u", "\x1b[120::98;5u", "\x1b[1095:1063:120;5:2;u"),
    "\x1b[1513::120;5u",  # Hebrew: the base layout tells where the alphabet is unknown
]
# what is read, as one write, or (joined by `|`) with that many seconds between: which keys it is
KEYS: list[tuple[str, float, str]] = [
    *(("\x1bb\x1bf", 0, "ctrl+left ctrl+right"), ("\x1b\t\x1b\x7f", 0, "shift+tab ctrl+w")),
    *(("\x1b|8", gap, "escape alt+8") for gap in (0.0, 0.05)),
    *(("\x1b\x1b[A\x18", 0, "escape up ctrl+x"), ("\x1b\x1b", 0, "escape escape")),
    ("\x1b\x1b|n", 0.12, "escape escape n"),
    # a key whose escape came before it, and a sequence that is waited for and dropped
    *(("\x1b|[A", 0.3, "escape up"), ("\x1b|[[A", 0.3, "escape f1"), ("\x1bO|P", 0.4, "f1")),
    *(("\x1b[1;|5A", 0.45, "ctrl+up"), ("\x1b[1;|r", 0.55, "r")),
    # a string without an end, and a long answer whose escape came before it
    *(("\x1b]52;c;AAAA|gr7|r", 0.45, ""), ("\x1b]52;c;AAAA|r", 0.55, "r")),
    ("\x1b|]l" + "gr7 " * 100, 0.3, "escape"),
    # a sequence ends at what cannot be in one, at a STOP, and at another one; an endless one
    *(("\x1b[1;\rr", 0, "enter r"), ("\x1b[" + "1" * 100_000 + "ur", 0, "r")),
    ("\x1b[1;" + "0" * 300 + "5Ar", 0, "r"),
    *((f"{begun}\x18r", 0, "ctrl+x r") for begun in BEGUN),
    *((f"{begun}\x1ar", 0, "r") for begun in BEGUN),
    *((f"{begun}\x1b[Ar", 0, "up r") for begun in BEGUN),
    *((f"{begun}|\x1b|r", 0.6, "escape r") for begun in BEGUN),
    ("\x1b[M !!r\x1b[35;10;10Mr", 0, "r r"),  # older reports of the mouse
    # of all terminals
    *((sent, 0, "up") for sent in ("\x1b[A", "\x1bOA", "\x1b[1;1:2A")),
    *((sent, 0, "f1") for sent in ("\x1bOP", "\x1b[11~", "\x1b[[A", "\x1b[P")),
    *(("\x1b[1;5A", 0, "ctrl+up"), ("\x1b[1;2A", 0, "shift+up"), ("\x1b[24~", 0, "f12")),
    *(("\x1b[Z", 0, "shift+tab"), ("\x1b[3~", 0, "delete"), ("\x1b[3$", 0, "shift+delete")),
    *(("\x1b[H", 0, "home"), ("\x1b[7~", 0, "home"), ("\x1b[5^", 0, "ctrl+pageup")),
    *(("\x1bOM", 0, "enter"), ("\x1b[1;129B", 0, "down"), ("\x7f\r\t", 0, "backspace enter tab")),
    ("\x18rR", 0, "ctrl+x r R"),
    # letters of other alphabets are keys by their place, é of AZERTY is the digit of its place
    *(
        (f"\x1b[{ord(a)};5u", 0, f"ctrl+{b}")
        for a, b in zip("йячсмфыςερψ", "qzxcvaswerc", strict=True)
    ),
    ("\x1b[233::50;3u", 0, "alt+2"),
    *((sent, 0, "ctrl+x") for sent in X_OF_ANY_LAYOUT),
    # a key that is let go is none
    *((sent, 0, "") for sent in ("\x1b[120;5:3u", "\x1b[97;1:3;97u", "\x1b[1;1:3A", "\x1b[3;1:3~")),
]


@pytest.mark.parametrize(("sent", "gap", "keys"), KEYS, ids=range(len(KEYS)))
def test_what_is_read_is_these_keys_and_no_text_of_a_sequence(
    sent: str, gap: float, keys: str
) -> None:
    pressed = typed(*sent.split("|"), gap=gap)
    assert pressed.keys == keys.split()
    assert pressed.text == "".join(key for key in pressed.keys if len(key) == 1)


@pytest.mark.parametrize("char", list("[]P_^X"))
def test_what_may_be_the_rest_of_a_sequence_is_a_key_when_nothing_follows(char: str) -> None:
    keyboard = Typed().read("\x1b").read(char, after=0.3)
    assert keyboard.wait(0.45).keys == ["escape"]
    assert keyboard.wait(0.1).text == char
    assert Typed().read("\x1b").read(char, after=0.65).text == char  # too late to be one


@pytest.mark.parametrize("char", list("[]P_"))
def test_what_cannot_be_the_rest_of_a_sequence_is_two_keys_at_once(char: str) -> None:
    keyboard = Typed().read("\x1b").read(char, after=0.3).read("r", after=0.1)
    assert keyboard.text == f"{char}r"
    assert Typed().read("\x1b").read("g", after=0.2).read(char, after=0.1).text == f"g{char}"


@pytest.mark.parametrize("char", list("[]P_^X"))
def test_stop_behind_it_is_not_held(char: str) -> None:
    keyboard = Typed().read("\x1b").read(char, after=0.3).read("\x18", after=0.1)
    assert keyboard.keys[-1] == "ctrl+x"
    assert keyboard.text == char


@pytest.mark.parametrize("sent", SENT)
def test_in_two_pieces_it_is_no_key_either(sent: str) -> None:
    """Cut anywhere: an escape may be read as the key, and no other."""
    for at, gap in itertools.product(range(1, len(sent)), GAPS):
        rest = f"x{END}r" if sent == BEGIN else "r"
        pressed = typed(sent[:at], sent[at:] + rest, gap=gap)
        assert pressed.keys in (["r"], ["escape", "r"]), (sent[:at], sent[at:], gap)
        assert pressed.pastes == (["x"] if sent == BEGIN else [])


# answers


@pytest.mark.parametrize("answer", ANSWERS)
def test_an_answer_of_the_terminal_is_nothing_that_acts(answer: str) -> None:
    pressed = typed(f"{answer}r{answer}{answer}g")
    assert pressed.names == ["Key", "Key"]
    assert pressed.keys == ["r", "g"]


@pytest.mark.parametrize(
    "answer",
    [
        *(b"\x9d11;rgb:1e1e/1e1e/1e1e\x9c", b"\x90>|XTerm(388)\x9c", b"\x9f4;r\x9c", b"\x9er\x9c"),
        *(b"\x98gr7\x1b\\", b"\x9b?1;2c", b"\x1b]l gr7\x9c"),
        *("\x9d11;rgb\x9c".encode(), "\x1b]l Müller \N{SNOWMAN} Ü\x1b\\".encode()),
        *(b"\x1b^gr7\x1b\\", b"\x1bXgr7\x1b\\"),
    ],
)
def test_so_is_one_with_controls_of_8_bits_or_beyond_ascii(answer: bytes) -> None:
    assert typed(answer + b"r").keys == ["r"]


def test_a_string_that_does_not_end_is_not_kept_and_a_pause_ends_it() -> None:
    keyboard = Typed().read("\x1b]52;c;")
    for _ in range(STRING_LIMIT // 0x10000 + 1):
        keyboard.read("A" * 0x10000)
    keyboard.read("\x1b\\gr7\r")
    assert keyboard.keys == []
    assert keyboard.read("r", after=0.12).keys == ["r"]


FLOODS = ["A" * 0x10000, "\x1b]52;c;" * 0x2000, f"{ST}\x1b]52;c;AAAA" * 0x1000]
STOPS = ["\x18", "\x1b[120;5u", "\x1b[1095::120;5u", "\x1b[27;5;120~"]


@pytest.mark.parametrize(
    ("flood", "stop"),
    corners(
        [*((FLOODS[0], stop) for stop in STOPS), *((flood, STOPS[0]) for flood in FLOODS[1:])],
        [*itertools.product(FLOODS[1:], STOPS[1:])],
    ),
)
def test_stop_in_a_flood_is_stop(flood: str, stop: str) -> None:
    keyboard = Typed().read("\x1b]52;c;")
    for _ in range(2 * STRING_LIMIT // len(flood)):
        keyboard.read(flood)
    assert keyboard.read(stop).keys == ["ctrl+x"]
    for character in stop:
        keyboard.read(character)
    assert keyboard.read("r", after=0.12).keys == ["ctrl+x", "ctrl+x", "r"]


def test_a_paste_in_a_flood_keeps_no_stop() -> None:
    keyboard = Typed().read("\x1b]52;c;" + "A" * (STRING_LIMIT + 1))
    assert keyboard.read(f"{BEGIN}gr7\r\x18").keys == ["ctrl+x"]
    assert keyboard.read("r", after=0.12).keys == ["ctrl+x", "r"]


@pytest.mark.parametrize(
    ("sent", "name"),
    [
        *(("\x1b[I", "AppFocus"), ("\x1b[O", "AppBlur")),
        *(("\x1b[<0;5;5M", "MouseDown"), ("\x1b[<0;5;5m", "MouseUp")),
        *(("\x1b[<64;5;5M", "MouseScrollUp"), ("\x1b[<35;5;5M", "MouseMove")),
        *(("\x1b[48;50;160;1000;1600t", "Resize"), ("\x1b[3;5R", "CursorPosition")),
        *(
            ("\x1b[?2026;2$y", "TerminalSupportsSynchronizedOutput"),
            ("\x1b[?2048;2$y", "InBandWindowResize"),
        ),
    ],
)
def test_what_textual_reads_it_gets(sent: str, name: str) -> None:
    for at in range(1, len(sent)):
        assert typed(sent[:at], sent[at:], gap=0.05).names == [name]
    assert typed("\x1b", sent[1:], gap=0.3).names == ["Key", name]


@pytest.mark.parametrize(
    "sent",
    [
        *("\x1b[1095::120;5:4u", "\x1b[55296;5u", "\x1b[1114112;5u", "\x1b[;u", "\x1b[u"),
        *("\x1b[120;999u", "\x1b[27;5;~", "\x1b[99~", "\x1b[9;9Z", "\x1b[" + ";" * 50 + "u"),
        *("\x1b[48;0;0;0;0t", "\x1b[48;99999;99999;1;1t", "\x1b[<999999;1;1M"),
        "\x1b[48;999:99999;999:99999;9999:99999;9999:99999t",  # too long for Textual
    ],
)
def test_nonsense_is_nothing(sent: str) -> None:
    assert typed(sent + "r").names == ["Key"]
    assert typed(sent + "r").keys == ["r"]


def test_what_textual_stumbles_over_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    keyboard = Typed()

    def fail(text: str) -> list[Message]:
        raise ValueError(text)

    monkeypatch.setattr(keyboard.keyboard._parser, "feed", fail)
    assert keyboard.read("ab").keys == ["b"]


# text


def test_letters_beyond_ascii_end_a_control_sequence_and_are_text() -> None:
    assert typed("\x1b[1;ör").text == "ör"


def test_letters_of_several_bytes_come_in_pieces() -> None:
    assert typed(*[bytes([byte]) for byte in "жß€\N{SNOWMAN}".encode()], gap=0.05).text == "жß€☃"


def test_what_is_no_utf_8_is_unreadable_and_stop_behind_it_acts() -> None:
    assert typed(b"\xe4r\xff\x18").keys[-1] == "ctrl+x"
    assert typed(b"\xe4", b"\x18", gap=0.2).keys == ["ctrl+x"]


# kitty's protocol


@pytest.mark.parametrize(
    ("sent", "key", "text"),
    [
        ("\x1b[97u", "a", "a"),
        ("\x1b[1095::120u", "ч", "ч"),
        ("\x1b[97:65;2u", "A", "A"),
        ("\x1b[47:63;2u", "question_mark", "?"),
        ("\x1b[32;2u", "space", " "),
        ("\x1b[57400u", "1", "1"),
        ("\x1b[114;129u", "r", "r"),  # num lock
        ("\x1b[27;2;65~", "A", "A"),
    ],
)
def test_what_is_typed_stays_text(sent: str, key: str, text: str) -> None:
    pressed = typed(sent)
    assert (pressed.keys, pressed.text) == ([key], text)


@pytest.mark.parametrize(
    ("sent", "key", "character"),
    [
        ("\x1b[13u", "enter", "\r"),
        ("\x1b[13;65u", "enter", "\r"),
        ("\x1b[9;2u", "shift+tab", None),
        ("\x1b[27u", "escape", None),
        ("\x1b[127;3u", "alt+backspace", None),
        ("\x1b[27;2;13~", "shift+enter", None),
        ("\x1b[120;6u", "ctrl+shift+x", None),
        ("\x1b[110;3u", "alt+n", None),
        ("\x1b[110;9u", "super+n", None),
        ("\x1b[57441;2u", "left_shift", None),
        ("\x1b[3;5:1~", "ctrl+delete", None),
        ("\x1b[1;1:2A", "up", None),
    ],
)
def test_keys_that_are_no_text(sent: str, key: str, character: str | None) -> None:
    (message,) = typed(sent).messages
    assert isinstance(message, events.Key)
    assert (message.key, message.character) == (key, character)


# the mouse


def moves(count: int, button: int = 35) -> str:
    return "".join(f"\x1b[<{button};{number % 100 + 1};5M" for number in range(count))


def test_of_many_moves_the_last_one_is_handed_on() -> None:
    pressed = typed(moves(2000) + "\x18")
    assert pressed.names == ["MouseMove", "Key"]
    assert isinstance(pressed.messages[0], events.MouseMove)
    assert pressed.messages[0].x == 99


def test_clicks_and_drags_keep_their_order() -> None:
    sent = f"{moves(9)}\x1b[<0;3;3M{moves(9, 32)}\x1b[<0;7;3m{moves(9)}\x1b[<0;7;3M\x1b[<0;7;3m"
    move = "MouseMove"
    assert typed(sent).names == [move, "MouseDown", move, "MouseUp", move, "MouseDown", "MouseUp"]


def test_each_step_of_the_wheel_counts() -> None:
    assert typed(moves(5, 65)).names == ["MouseScrollDown"] * 5
    assert typed(moves(5, 97)).names == ["MouseScrollDown"] * 5


# all of it


@pytest.mark.parametrize("seed", range(8))
def test_whatever_comes_in_whatever_pieces_only_what_was_typed_acts(seed: int) -> None:
    """Keys among answers and pastes, cut anywhere: each acts once, and nothing else does."""
    chance = random.Random(seed)
    sent, pressed, pasted = "", [], []
    for _ in range(200):
        kind = chance.choice(["key", "stop", "paste", "answer"])
        if kind == "key":
            pressed.append(chance.choice("agrsyq7"))
            sent += pressed[-1]
        elif kind == "stop":
            pressed.append("ctrl+x")
            sent += chance.choice(["\x18", "\x1b[1095::120;5u", "\x1b[27;5;88~"])
        elif kind == "paste":
            pasted.append("".join(chance.choices("agrsy7\r \x18[]", k=chance.randint(0, 60))))
            sent += BEGIN + pasted[-1] + END
        else:
            sent += chance.choice(ANSWERS)
    keyboard = Typed()
    while sent:
        length = chance.randint(40, 120)  # so that nothing is cut twice
        keyboard.read(sent[:length], after=chance.choice([0.0, *GAPS]))
        sent = sent[length:]
    keyboard.wait(LONG)
    assert [key for key in keyboard.keys if key != "escape"] == pressed
    assert keyboard.pastes == pasted


@pytest.mark.parametrize("seed", range(6))
def test_whatever_came_before_stop_alone_is_stop(seed: int) -> None:
    chance = random.Random(seed)
    noise = [*SENT, *"\x1b\x1b\x1b[]P_^XOM20;~u<\\\x07\x18\x1aé\x9b\x9d", "\x1b[", "\x1bO"]
    keyboard = Typed()
    for _ in range(100):
        data = "".join(chance.choices(noise, k=chance.randint(1, 6))).encode()
        data = data[: chance.randint(1, len(data))] + chance.choice(
            [b"", b"\xc3", b"\x9b", b"\xff"]
        )
        keyboard.read(data, after=chance.choice([0.0, 0.05, 0.3, 1.0, 2.5]))
        keyboard.read("\x18", after=0.12)
        assert keyboard.keys[-1:] == ["ctrl+x"], data
        keyboard.messages.clear()
