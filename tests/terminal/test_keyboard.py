"""Keys, answers of the terminal, the mouse and pastes, from bytes to what acts."""

from __future__ import annotations

import itertools
import random

import pytest
from textual import events
from textual.message import Message

from archo_tui.screen.terminal.keyboard import PASTE_LIMIT, STRING_LIMIT, Keyboard
from tests.support.night import corners

SOON, IDLE = 0.03, 0.1  # s, as the driver waits
LONG = 10.0  # s, after which nothing is open any more


class Typed:
    """What comes of what is typed."""

    def __init__(self) -> None:
        self.keyboard = Keyboard()
        self.now = 1000.0
        self.messages: list[Message] = []

    def wait(self, seconds: float) -> Typed:
        """Nothing comes for so long."""
        end = self.now + seconds
        while (step := SOON if self.keyboard.is_waiting else IDLE) < end - self.now:
            self.now += step
            self.messages += self.keyboard.on_silence(self.now)
        self.now = end
        return self

    def read(self, data: bytes | str, after: float = 0.0) -> Typed:
        """That is read at once, so many seconds after what came before."""
        self.wait(after)
        data = data.encode() if isinstance(data, str) else data
        self.messages += self.keyboard.feed(data, self.now)
        return self

    @property
    def keys(self) -> list[str]:
        """Which act, by now."""
        return [message.key for message in self.messages if isinstance(message, events.Key)]

    @property
    def text(self) -> str:
        """What a field would show of the keys."""
        keys = (message for message in self.messages if isinstance(message, events.Key))
        return "".join(key.character or "" for key in keys if key.is_printable)

    @property
    def pastes(self) -> list[str]:
        return [m.text for m in self.messages if isinstance(m, events.Paste)]

    @property
    def names(self) -> list[str]:
        """The classes of all that came."""
        return [type(message).__name__ for message in self.messages]


def typed(*reads: bytes | str, gap: float = 0.0) -> Typed:
    """What is read one after another, and silence."""
    keyboard = Typed()
    for number, data in enumerate(reads):
        keyboard.read(data, gap if number else 0.0)
    return keyboard.wait(LONG)


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


# keys among answers and pastes


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


# pastes: text or nothing, whatever is in them, however they come, and never keys

ESCAPES = ["\x1b", "\x1b[27u", "\x1b[27;1u", "\x1b[27;129u"]


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
