"""The keyboard: a terminal's bytes as Textual's messages for keys, pastes and the mouse.

Textual's own parser (8.2.8) takes replies of the terminal for keys, and also a sequence or a paste
that arrives in pieces; it swallows the key after an escape, and raises on some sequences. Here
bytes are cut into characters and sequences (ECMA-48) first, and it gets whole ones only, of forms
that it knows. What an escape alone means only silence can tell.
"""

from __future__ import annotations

import codecs
import re
import string
import unicodedata

from textual import events
from textual._xterm_parser import XTermParser
from textual.message import Message

ESCAPE = "\x1b"
CANCEL, SUBSTITUTE = "\x18", "\x1a"  # CAN and SUB end a sequence; CAN is ctrl+x as well.
PASTE_BEGIN, PASTE_END = "\x1b[200~", "\x1b[201~"
PAUSE = 0.1  # Seconds of silence after which an escape is a key.
SEQUENCE_WAIT = 0.5  # Seconds to wait for the rest of a sequence, over a slow link.
MAX_STRING_TIME = 2.0  # Seconds; what comes with pauses after that is typed, not a reply.
STRING_LIMIT = PASTE_LIMIT = 1 << 20  # Characters; no reply is that long.
STALL = 2.0  # Seconds of silence until the operator is told how to end a paste.
ALONE = 0.5  # Seconds of silence before and after an escape that ends a paste.

_MAX_KEY = 32  # Characters of a key's sequence; Textual gives up on longer ones.
_MAX_KEPT = 256  # Characters that are kept of an incomplete sequence.
_REPORT = r"\x1b\[(?:<\d{1,5};-?\d{1,5};-?\d{1,5}[Mm]|[IO])"  # Mouse and focus.
_TOKEN = re.compile(
    r"\x1b\[\[[A-E]"  # Function keys of the Linux console.
    r"|\x1b\[\d\d?\$"  # Of rxvt, with shift.
    r"|\x1b\[M[^\x00-\x1f]{3}"  # X10's mouse.
    r"|\x1b\[(?!\[|M)[0-?]*[ -/]*[@-~]"
    r"|\x1bO[A-DFHMPQRSabcdj-y]"
    r"|\x1b[]P_^X][^\x07\x18\x1a\x1b]*(?:\x07|\x1b\\)"  # A string: a reply.
    r"|\x1b[^\x00-\x08\x0a-\x1f[\]OP_^X]"  # With alt, and shift+tab of the Linux console.
    r"|[^\x1b]"
)
_BEGUN = re.compile(
    r"\x1b(?:\[(?:\[|M[^\x00-\x1f]{0,2}|[0-?]*[ -/]*)|O|[]P_^X][^\x07\x18\x1a\x1b]*(?:\x1b\Z)?)?"
)
_BEGINS_STRING = "]P_^X"  # After an escape: OSC, DCS, APC, PM, SOS.
_BEGINS = f"[{_BEGINS_STRING}"
# The start of a sequence behind an escape that was taken as a key: a person types no such thing.
_MAY_BE_LATE = re.compile(r"\x1b(?:\[|\](?:\Z|[\dlL])|P(?:\Z|[>!\d])|_(?:\Z|G)|[\^X])")
_LONGEST_TYPED = len("\x1b]12")
# What Textual's parser makes messages of, other than keys: mouse, focus, size, modes, cursor.
_FOR_TEXTUAL = re.compile(
    rf"{_REPORT}|\x1b\[\d{{1,5}};\d{{1,5}};\d{{1,5}}M|\x1b\[M..."
    r"|\x1b\[48(?=.{1,28}\Z)(?:;[1-9]\d{0,3}(?::\d{1,5})?){2}(?:;\d{1,6}(?::\d{1,5})?){2}t"
    r"|\x1b\[\?20(?:26|48);\d\$y|\x1b\[\d{1,5};\d{1,5}R"
)
_ALL_REPORTS = re.compile(_REPORT)
_ALT = re.compile(r"\x1b[^]P_^X\\[]")
# A move of the mouse that another one with the same buttons follows.
_PASSED_MOVE = re.compile(
    r"\x1b\[<(3[2-9]|[45]\d|6[0-3]);[-\d]+;[-\d]+M(?=\x1b\[<\1;[-\d]+;[-\d]+M)"
)
_MARK = re.compile(r"\x1b\[20([01])~")
_BEGUN_MARK = re.compile(r"\x1b(?:\[(?:2(?:0[01]?)?)?)?\Z")
# https://sw.kovidgoyal.net/kitty/keyboard-protocol/: key, shifted key, key of the base layout,
# modifiers, event, text.
_KITTY = re.compile(r"\x1b\[(\d+)(?::(\d*)(?::(\d*))?)?(?:;(\d*)(?::([123]))?(?:;[\d:]*)?)?u")
_FUNCTION = re.compile(
    r"\x1b\[(1(?=.*[^~]\Z)|(?:[1-8]|1[1-57-9]|2[013-689]|3[1-4])(?=.*~)|(?=[^~]+\Z))"
    r"(?:;(\d*)(?::([123]))?)?([~ABCDEFHPQRS])"
)
_OTHER_KEY = re.compile(r"\x1b\[27;(\d+);(\d+)~")  # xterm's modifyOtherKeys.
_NO_KEY = re.compile(r"\x1b\[[\d;:]*[u~A-S]")  # Of other numbers; Textual makes characters of them.
_RELEASED = "3"
_SHIFT, _LOCKS = 0b1, 0b11000000  # Modifiers; the locks of capitals and digits.
# The QWERTY keys of other letters: under a Russian layout ctrl+x is ctrl+ч for a terminal that does
# not tell which key was pressed.
_ALPHABETS = (
    ("йцукенгшщзхъфывапролджэячсмитьбюё", "qwertyuiop[]asdfghjkl;'zxcvbnm,.`"),  # Russian
    ("іїєґ", "s]'\\"),  # Ukrainian, besides those.
    ("ςερτυθιοπασδφγηξκλζχψωβνμ", "wertyuiopasdfghjklzxcvbnm"),  # Greek
)
_ON_QWERTY = {
    letter: key for row, keys in _ALPHABETS for letter, key in zip(row, keys, strict=True)
}
_CONTROLS = {  # Of 8 bits: those that begin or end a sequence, and the others, which are dropped.
    code: ESCAPE + chr(code - 0x40) if chr(code - 0x40) in "[O]P_^X\\" else ""
    for code in range(0x80, 0xA0)
}


def _replace_or_control(error: UnicodeError) -> tuple[str, int]:
    """Return U+FFFD or an 8-bit control for bytes that are not UTF-8, and where they end."""
    assert isinstance(error, UnicodeDecodeError)
    wrong = error.object[error.start : error.end]
    is_control = len(wrong) == 1 and 0x80 <= wrong[0] <= 0x9F
    return (chr(wrong[0]) if is_control else "\N{REPLACEMENT CHARACTER}"), error.end


codecs.register_error("archo-terminal", _replace_or_control)


class PasteCut(Message):
    """A message: a paste ended without its end mark, so nothing of it was taken."""


class PasteStalled(Message):
    """A message: a paste has not ended, and nothing of it has arrived for 2 s; once a paste."""


def keys_of(sequence: str) -> list[events.Key]:
    """Return the keys of a character or a whole escape sequence, none if it is not a key."""
    if sequence == ESCAPE:
        return [events.Key("escape", ESCAPE)]
    try:
        parsed = XTermParser().feed(_plain(sequence))
        keys = [key for key in parsed if isinstance(key, events.Key)]
    except (ValueError, OverflowError):  # Of a number that is no character.
        return []
    # Textual has characters for some keys that type none, such as alt+1.
    if _ALT.fullmatch(sequence) and (not keys or keys[0].character):
        alt = events.Key(_alt(key_name(sequence[1])), None)
        # In tmux, escape and then a panel's number.
        return [events.Key("escape", ESCAPE), alt] if sequence[1] in string.digits else [alt]
    return keys


def _plain(sequence: str) -> str:
    """Return a key's sequence as Textual knows it, or its character; "" if it is none.

    A letter with ctrl or alt becomes the one at its place on QWERTY, as far as that is known.
    """
    if len(sequence) > _MAX_KEY:
        return ""
    sequence = _OTHER_KEY.sub("\x1b[\\2;\\1u", sequence)
    match = _KITTY.fullmatch(sequence) or _FUNCTION.fullmatch(sequence)
    if match is None:
        return "" if _NO_KEY.fullmatch(sequence) else sequence
    if match.re is _KITTY:
        code, shifted, base, state, event = match.groups()
        final, letter = "u", chr(int(code))
    else:
        code, state, event, final = match.groups()
        shifted = base = letter = ""
    held = (int(state or 1) - 1) & ~_LOCKS
    if held > 0xFF or event == _RELEASED or unicodedata.category(letter or "x") == "Cs":
        return ""
    if held == _SHIFT and letter.isprintable() and letter:
        return chr(int(shifted)) if shifted else letter
    if held and letter:
        place = chr(int(base)) if base and not letter.isascii() else letter.lower()
        code = str(ord(_ON_QWERTY.get(place, place)))
    return f"\x1b[{code or 1};{held + 1}{final}" if held else f"\x1b[{code}{final}"


def key_name(character: str) -> str:
    """Return Textual's name of the key that types a character, as `x` or `question_mark`."""
    return keys_of(character)[0].key


def _alt(name: str) -> str:
    return f"alt+shift+{name.lower()}" if name.isupper() else f"alt+{name}"


class _Paste:
    """A paste from its begin mark on: text between two marks, taken whole or not at all.

    It may stall for as long as it likes: what follows belongs to it and is no key. An end mark that
    never arrives must not leave the operator without STOP, so two keys end a paste if they come
    alone: STOP at once, and escape if nothing comes before and after it for a while.
    """

    def __init__(self, now: float) -> None:
        self.text = ""
        self.has_stalled = False
        self.last = now  # Monotonic time of the last reading, in s.
        self._tail = ""  # The first part of what may be a mark.
        # What was read without a pause, and the seconds of silence before it.
        self._burst, self._silence = "", 0.0

    def add(self, text: str, now: float) -> re.Match[str] | None:
        """Add text that was read; return the mark that ends the paste, if it came."""
        if now - self.last >= PAUSE:
            self._burst, self._silence = "", now - self.last
        self._burst = (self._burst + text)[: _MAX_KEY + 1]
        self.last = now
        text = self._tail + text
        mark = _MARK.search(text)
        begun = mark or _BEGUN_MARK.search(text)
        end = begun.start() if begun else len(text)
        self.text, self._tail = (self.text + text[:end])[:PASTE_LIMIT], text[end:]
        return mark

    def key_after(self, silence: float) -> str:
        """Return the sequence of the one key that came after so many seconds of silence, or ""."""
        token = _TOKEN.match(self._burst)
        first = token[0] if token else self._burst[:1]
        is_alone = (first * len(self._burst)).startswith(self._burst)  # Once, or held.
        return first if is_alone and self._silence >= silence else ""


class Keyboard:
    """A parser of a terminal's bytes into messages. Nothing here reads a clock or a file."""

    def __init__(self, stop_key: str = "ctrl+x") -> None:
        self._stops = "ctrl+x", stop_key
        self._parser = XTermParser()
        self._decoder = codecs.getincrementaldecoder("utf-8")("archo-terminal")
        self._last = 0.0  # Monotonic time of the last reading, in s.
        self._paste: _Paste | None = None
        self._stray_end = ""  # The rest of an end mark whose escape has ended the paste already.
        self._rest = ""  # A sequence that has begun.
        self._is_late = False  # Its escape was taken as a key.
        self._late_until = 0.0  # Until then the rest of a sequence may follow its escape.
        self._string_began, self._string_size = 0.0, 0  # Of a control string that has begun.
        self._is_flooded = False  # That one is endless: until it pauses, only STOP is taken.

    @property
    def is_waiting(self) -> bool:
        """True while a short silence decides something: `on_silence` is to be called more often."""
        if self._paste is not None:
            return _name(self._paste.key_after(ALONE)) == "escape"
        return self._rest != "" or self._is_flooded

    def feed(self, data: bytes, now: float) -> list[Message]:
        """Return the messages for bytes that were read at a monotonic time.

        Those that the silence before decided come first. Replies of the terminal, and moves of the
        mouse that another move follows, give no message.
        """
        messages = self.on_silence(now)
        pause, self._last = now - self._last, now
        if pause >= PAUSE and data[:1].isascii():
            self._decoder.reset()  # The rest of the character will not come.
        text = _PASSED_MOVE.sub("", self._decoder.decode(data).translate(_CONTROLS))
        if not text:
            return messages
        if self._is_flooded:
            return messages + [key for key in self._read(text) if self._is_stop(key)]
        while text[:1] and text[0] == self._stray_end[:1]:
            text, self._stray_end = text[1:], self._stray_end[1:]
        if text:
            self._stray_end = ""
        is_old = self._string_size and now - self._string_began > MAX_STRING_TIME
        if is_old and pause >= PAUSE:
            self._rest = ""
        if not self._rest and now <= self._late_until and text[:1] in tuple(_BEGINS):
            self._rest, self._is_late = ESCAPE, True
        self._late_until = 0.0
        return messages + self._read(text)

    def on_silence(self, now: float) -> list[Message]:
        """Return the messages that silence decides; call it regularly while nothing arrives."""
        if self._paste is not None:
            return self._on_silent_paste(self._paste, now)
        silence, rest = now - self._last, self._rest
        if self._is_flooded and silence >= PAUSE:
            self._is_flooded = False
            if self._string_size:
                self._rest, self._string_size = "", 0
                return []
        if not rest or silence < (PAUSE if rest == ESCAPE else SEQUENCE_WAIT):
            return []
        is_typed = self._is_late and len(rest) <= _LONGEST_TYPED
        self._rest, self._is_late, self._string_size = "", False, 0
        if is_typed:
            return self._read(rest[1:])
        if rest.endswith(ESCAPE):
            self._late_until = self._last + PAUSE + SEQUENCE_WAIT
        return _broken_off(rest)

    def _on_silent_paste(self, paste: _Paste, now: float) -> list[Message]:
        messages: list[Message] = []
        silence = now - paste.last
        if silence >= STALL and not paste.has_stalled:
            paste.has_stalled = True
            messages.append(PasteStalled())
        if self.is_waiting and silence >= ALONE:
            key = paste.key_after(ALONE)
            self._paste, self._stray_end = None, PASTE_END[1:] if key == ESCAPE else ""
            messages += [PasteCut(), *keys_of(key)]
        return messages

    def _read(self, text: str) -> list[Message]:
        """Return the messages for text; the sequence at its end that is not complete is kept."""
        messages: list[Message] = []
        rest, at = self._rest + text, 0
        while at < len(rest):
            if self._paste is not None:
                pasted, rest = self._read_paste(self._paste, rest[at:])
                messages, at = messages + pasted, 0
                continue
            token = _TOKEN.match(rest, at)
            found = token or _BEGUN.match(rest, at)
            assert found is not None  # It begins with an escape, or is a character.
            is_open = token is None and found.end() == len(rest)
            if self._is_late and not (
                _MAY_BE_LATE.match(rest, at) and (is_open or (token and _is_no_text(token[0])))
            ):
                at, self._is_late = at + 1, False  # What follows the escape was typed.
                continue
            if is_open:
                break
            at, self._is_late, self._string_size = found.end(), False, 0
            messages += self._to_messages(found[0]) if token else _broken_off(found[0])
            if token is None and len(found[0]) > 1 and rest[at] == SUBSTITUTE:
                at += 1
        self._keep(rest[at:], min(len(text), len(rest) - at))
        return messages

    def _keep(self, rest: str, size: int) -> None:
        """Keep the beginning of a sequence, of which `size` characters came, until more comes."""
        self._rest = rest[:_MAX_KEPT]
        if len(rest) > _MAX_KEPT and rest.endswith(ESCAPE):  # It may be a part of the end.
            self._rest += ESCAPE
        if len(rest) < 2 or rest[1] not in _BEGINS_STRING:
            self._string_size = 0
            return
        if not self._string_size:
            self._string_began = self._last
        self._string_size += size
        self._is_flooded |= self._string_size > STRING_LIMIT

    def _read_paste(self, paste: _Paste, text: str) -> tuple[list[Message], str]:
        """Return the messages for a text within a paste, and the text behind the end of the paste.

        Mouse and focus reports are taken out of it: the mouse may move while a paste stalls.
        """
        inside, mark, behind = text.partition(PASTE_END)
        reports = (report[0] for report in _ALL_REPORTS.finditer(inside))
        messages = [message for report in reports for message in self._to_messages(report)]
        text = _ALL_REPORTS.sub("", inside) + mark + behind
        found = paste.add(text, self._last) if text else None
        if found:
            self._paste, is_end = None, found[1] == "1"  # Or another one begins.
            messages.append(events.Paste(paste.text) if is_end else PasteCut())
            return messages, found.string[found.end() if is_end else found.start() :]
        key, is_amid_character = paste.key_after(PAUSE), self._decoder.getstate()[0] != b""
        if text and not is_amid_character and _name(key) in self._stops:
            self._paste = None
            return [*messages, PasteCut()], key
        return messages, ""

    def _is_stop(self, message: Message) -> bool:
        return isinstance(message, events.Key) and message.key in self._stops

    def _to_messages(self, token: str) -> list[Message]:
        """Return the messages for a character or a whole sequence; none for a reply."""
        if token == PASTE_BEGIN:
            self._paste = None if self._is_flooded else _Paste(self._last)
            return []
        if token[1:2] in (*_BEGINS_STRING, "\\"):
            return []
        if len(token) > 1 and not _FOR_TEXTUAL.fullmatch(token):
            return [*keys_of(token)]
        try:
            return list(self._parser.feed(token))
        except Exception:  # Textual's parser stumbles over some.
            self._parser = XTermParser()
            return []


def _name(sequence: str) -> str:
    """Return Textual's name of a key; "" if a sequence is not one."""
    return next((key.key for key in keys_of(sequence)), "")


def _broken_off(begun: str) -> list[Message]:
    """Return the keys of a sequence that does not go on: an escape, alt+shift+o, or none."""
    if begun == "\x1bO":
        return [*keys_of(begun)]
    return [*keys_of(ESCAPE)] if begun.endswith(ESCAPE) else []


def _is_no_text(sequence: str) -> bool:
    """Return True for a sequence of which a person does not type the rest behind an escape."""
    is_known = sequence[1] in _BEGINS_STRING or _FOR_TEXTUAL.fullmatch(sequence)
    return bool(is_known or re.search(r"\d", sequence) or keys_of(sequence))
