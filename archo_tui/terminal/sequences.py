"""A cutter of a terminal's output into characters and escape sequences (ECMA-48).

Control strings (OSC, DCS, APC, PM, SOS) are replies of the terminal: they are dropped here. A
sequence that does not arrive in one read is waited for; what an escape alone means only silence can
tell.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from textual._ansi_sequences import ANSI_SEQUENCES_KEYS

from archo_tui.terminal.keys import keys_of
from archo_tui.terminal.replies import FOR_TEXTUAL, MAY_BE_REPLY, REPLY, REPLY_START, WHOLE_STRING

ESCAPE = "\x1b"
CANCEL = "\x18"  # Ends a sequence (CAN), and is ctrl+x as well.
PASTE_BEGIN, PASTE_END = "\x1b[200~", "\x1b[201~"
PAUSE = 0.1  # Seconds of silence after which an escape is a key.
SEQUENCE_WAIT = 0.5  # Seconds to wait for the rest of a sequence, over a slow link.
MAX_STRING_TIME = 2.0  # Seconds; what comes with pauses after that is typed, not a reply.
STRING_LIMIT = 1 << 20  # Characters; no reply is that long.

_SUBSTITUTE = "\x1a"  # Ends a sequence (SUB).
_MAX_SEQUENCE = 256  # Characters of a control sequence.
_BEGINS_STRING = "]P_^X"  # After an escape: OSC, DCS, APC, PM, SOS.
_STRING_END = "\x07\x9c"  # BEL, and the 8-bit ST.
_MAY_BE_CSI = re.compile(r"\[\[?|\[[<=>?]?[-\d;:]{0,40}[ -/]?")


class Sequences:
    """A state machine whose state is the method that takes the next character."""

    def __init__(self) -> None:
        self._pieces: list[str] = []
        self._state: Callable[[str], None] = self._ground
        self._text = ""  # The characters of an incomplete sequence.
        self._size = 0  # Characters of a control string, whose text is not kept.
        self._begun = 0.0  # Monotonic time at which that string began, in s.
        self._now = self._since = 0.0  # Monotonic time, and since when the state waits.
        self._rest_until = 0.0  # Until then the rest of a sequence may follow its escape.

    @property
    def is_waiting(self) -> bool:
        """True within a sequence, while more characters or silence decide what it is."""
        return self._state != self._ground

    def feed(self, text: str, now: float) -> tuple[list[str], str]:
        """Cut a text into characters and whole escape sequences, and drop control strings.

        What is incomplete is kept for the next call. The second text returned is what follows the
        begin mark of a paste, else "". Call `on_silence` before, with the same time.
        """
        self._now, at = now, 0
        while at < len(text) and self._pieces[-1:] != [PASTE_BEGIN]:
            self._state(text[at])
            at += 1
        return self._take_pieces(), text[at:]

    def on_silence(self, now: float) -> list[str]:
        """Return the pieces that silence decides, such as an escape alone, which is a key.

        An incomplete sequence is dropped, or handed on as single keys if its escape was taken as a
        key before.
        """
        wait = PAUSE if self._state in (self._escape, self._flood) else SEQUENCE_WAIT
        if self.is_waiting and now - self._since >= wait:
            if self._state in (self._escape, self._string_escape):
                self._pieces.append(ESCAPE)
                self._rest_until = self._since + wait + SEQUENCE_WAIT
            elif self._state == self._ss3:
                self._pieces.append(self._text)
            elif self._state in (self._late_csi, self._late_string):
                self._pieces += self._text
            self._state = self._ground
        return self._take_pieces()

    def _take_pieces(self) -> list[str]:
        pieces, self._pieces = self._pieces, []
        return pieces

    def _wait(self, state: Callable[[str], None], text: str = "") -> None:
        self._state, self._text, self._since = state, text, self._now

    def _emit(self, piece: str) -> None:
        self._pieces.append(piece)
        self._state = self._ground

    def _ground(self, char: str) -> None:
        """Take a character outside of any sequence."""
        self._state = self._ground
        may_be_rest, self._rest_until = self._now <= self._rest_until, 0.0
        if char == ESCAPE:
            self._wait(self._escape, ESCAPE)
        elif "\x80" <= char <= "\x9f":  # The 8-bit form of an escape and a character.
            stands_for = chr(ord(char) - 0x40)
            if stands_for in f"[O{_BEGINS_STRING}":
                self._escape(stands_for)
        elif may_be_rest and char == "[":
            self._wait(self._late_csi, char)
        elif may_be_rest and char in _BEGINS_STRING:
            self._wait(self._late_string, char)
        else:
            self._emit(char)

    def _escape(self, char: str) -> None:
        if char == "[":
            self._wait(self._csi, ESCAPE + char)
        elif char == "O":
            self._wait(self._ss3, ESCAPE + char)
        elif char in _BEGINS_STRING:
            self._begin_string()
        elif char == "\\":
            self._state = self._ground  # The end of a string that is over already.
        elif char != ESCAPE and (char.isprintable() or ESCAPE + char in ANSI_SEQUENCES_KEYS):
            self._emit(ESCAPE + char)
        else:
            self._emit(ESCAPE)
            self._ground(char)

    def _csi(self, char: str) -> None:
        """Take a character of a control sequence, which began with an escape and `[`."""
        text = self._text + char
        if not " " <= char <= "~":
            self._abort(char)
        elif text == "\x1b[M":
            self._wait(self._x10, text)
        elif text == "\x1b[[" or (char < "@" and text not in ANSI_SEQUENCES_KEYS):
            self._wait(self._csi, text[:_MAX_SEQUENCE])
        elif len(text) <= _MAX_SEQUENCE:
            self._emit(text)
        else:
            self._state = self._ground

    def _x10(self, char: str) -> None:
        text = self._text + char
        if char < " ":
            self._abort(char)
        elif len(text) == len("\x1b[Mbxy"):
            self._emit(text)
        else:
            self._wait(self._x10, text)

    def _ss3(self, char: str) -> None:
        """Take the character after an escape and `O`: both make one key, or are two keys."""
        if self._text + char in ANSI_SEQUENCES_KEYS:
            self._emit(self._text + char)
        else:
            self._pieces.append(self._text)
            self._ground(char)

    def _abort(self, char: str) -> None:
        """Drop a control sequence, and take the character that breaks it off, unless it is SUB."""
        self._state = self._ground
        if char != _SUBSTITUTE:
            self._ground(char)

    def _begin_string(self) -> None:
        self._size, self._begun = 0, self._now
        self._wait(self._string)

    def _string(self, char: str) -> None:
        """Take a character of a control string, whose text is not kept.

        A string longer than STRING_LIMIT is dropped until it pauses. After MAX_STRING_TIME, a
        character that comes after a pause is typed, and ends the string.
        """
        if self._now - self._begun > MAX_STRING_TIME and self._now - self._since >= PAUSE:
            self._ground(char)
            return
        self._size += 1
        self._since = self._now
        if char == ESCAPE:
            self._wait(self._string_escape)
        elif char in _STRING_END:
            self._state = self._ground
        elif char in (CANCEL, _SUBSTITUTE):
            self._abort(char)
        elif self._size > STRING_LIMIT:
            self._state = self._flood

    def _string_escape(self, char: str) -> None:
        """Take the character after an escape in a control string: its end, or another sequence."""
        self._escape(char)

    def _flood(self, char: str) -> None:
        """Drop a character of an endless string, but let ctrl+x through, which may mean STOP."""
        self._since = self._now
        if char == CANCEL:
            self._pieces.append(CANCEL)

    # The rest of a sequence whose escape was taken as a key may still arrive.

    def _late_csi(self, char: str) -> None:
        """Take a character after a `[` that may belong to an escape which was taken as a key."""
        text = self._text + char
        if _is_sequence(ESCAPE + text):
            self._emit(ESCAPE + text)
        elif _MAY_BE_CSI.fullmatch(text):
            self._text = text
        else:
            self._replay_as_keys(char)

    def _late_string(self, char: str) -> None:
        """Take a character of what may be a reply, whose escape was taken as a key."""
        text = self._text + char
        if WHOLE_STRING.fullmatch(text):
            self._state = self._ground
        elif REPLY_START.match(text) or len(text) > _MAX_SEQUENCE:  # No person types that.
            self._begin_string()
        elif MAY_BE_REPLY.fullmatch(text):
            self._text = text
        else:
            self._replay_as_keys(char)

    def _replay_as_keys(self, char: str) -> None:
        self._state = self._ground
        for key in self._text + char:
            self._state(key)


def _is_sequence(sequence: str) -> bool:
    return (
        sequence in (PASTE_BEGIN, PASTE_END)
        or keys_of(sequence) is not None
        or FOR_TEXTUAL.fullmatch(sequence) is not None
        or REPLY.fullmatch(sequence) is not None
    )
