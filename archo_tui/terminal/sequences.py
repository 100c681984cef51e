"""Cuts what a terminal sends into whole pieces: characters, escape with what belongs to it.

Strings (OSC, DCS, APC, PM, SOS) are answers of the terminal: they end here. What does not come in
one read is waited for, and what an escape alone means only silence can tell.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from textual._ansi_sequences import ANSI_SEQUENCES_KEYS

from archo_tui.terminal.answers import ANSWER, ANSWERS, FOR_TEXTUAL, MAY_ANSWER, WHOLE_ANSWER
from archo_tui.terminal.keys import keys_of

ESCAPE = "\x1b"
CANCEL = "\x18"  # ends a sequence, and is ctrl+x besides
PASTE_BEGIN, PASTE_END = "\x1b[200~", "\x1b[201~"
PAUSE = 0.1  # s of silence after which an escape is a key
SEQUENCE_WAIT = 0.5  # s that the rest of a sequence is waited for, over a slow link
STRING_TIME = 2.0  # s after which what comes slower than PAUSE is typed, and no answer
STRING_LIMIT = 1 << 20  # characters; no answer is as long

_SUBSTITUTE = "\x1a"  # ends a sequence, too
_LONGEST = 256  # characters of a control sequence
_BEGINS_STRING = "]P_^X"  # behind an escape
_STRING_END = "\x07\x9c"  # BEL, and ST in 8 bits
_MAY_BE_CSI = re.compile(r"\[\[?|\[[<=>?]?[-\d;:]{0,40}[ -/]?")


class Sequences:
    """Takes text as it comes, with the time; a state is the method for the next character."""

    def __init__(self) -> None:
        self._pieces: list[str] = []
        self._state: Callable[[str], None] = self._ground
        self._text = ""  # what was read of something that is not complete
        self._size = 0  # of a string: its text is not kept
        self._begun = 0.0  # when it was, monotonic s
        self._now = self._since = 0.0  # monotonic s; since when the state waits
        self._rest_until = 0.0  # the escape was given as a key; the rest of its sequence may come

    @property
    def waiting(self) -> bool:
        """True while silence would tell something."""
        return self._state != self._ground

    def cut(self, text: str, now: float) -> tuple[list[str], str]:
        """Whole pieces, the begin of a paste as the last one, and what stands behind that.

        What silence told is taken by late() first.
        """
        self._now, at = now, 0
        while at < len(text) and self._pieces[-1:] != [PASTE_BEGIN]:
            self._state(text[at])
            at += 1
        return self._taken(), text[at:]

    def late(self, now: float) -> list[str]:
        """What silence tells: an escape alone is a key; of an answer no more will come."""
        wait = PAUSE if self._state in (self._escape, self._flood) else SEQUENCE_WAIT
        if self.waiting and now - self._since >= wait:
            if self._state in (self._escape, self._string_escape):
                self._pieces.append(ESCAPE)
                self._rest_until = self._since + wait + SEQUENCE_WAIT
            elif self._state == self._ss3:
                self._pieces.append(self._text)
            elif self._state in (self._held_csi, self._held_string):
                self._pieces += self._text
            self._state = self._ground
        return self._taken()

    def _taken(self) -> list[str]:
        pieces, self._pieces = self._pieces, []
        return pieces

    def _wait(self, state: Callable[[str], None], text: str = "") -> None:
        self._state, self._text, self._since = state, text, self._now

    def _give(self, piece: str) -> None:
        self._pieces.append(piece)
        self._state = self._ground

    def _ground(self, char: str) -> None:
        """Nothing stands before it."""
        self._state = self._ground
        may_be_rest, self._rest_until = self._now <= self._rest_until, 0.0
        if char == ESCAPE:
            self._wait(self._escape, ESCAPE)
        elif "\x80" <= char <= "\x9f":  # 8 bits for an escape and a character
            stands_for = chr(ord(char) - 0x40)
            if stands_for in f"[O{_BEGINS_STRING}":
                self._escape(stands_for)
        elif may_be_rest and char == "[":
            self._wait(self._held_csi, char)
        elif may_be_rest and char in _BEGINS_STRING:
            self._wait(self._held_string, char)
        else:
            self._give(char)

    def _escape(self, char: str) -> None:
        """Directly behind an escape."""
        if char == "[":
            self._wait(self._csi, ESCAPE + char)
        elif char == "O":
            self._wait(self._ss3, ESCAPE + char)
        elif char in _BEGINS_STRING:
            self._begin_string()
        elif char == "\\":
            self._state = self._ground  # the end of a string that is over
        elif char != ESCAPE and (char.isprintable() or ESCAPE + char in ANSI_SEQUENCES_KEYS):
            self._give(ESCAPE + char)
        else:
            self._give(ESCAPE)
            self._ground(char)

    def _csi(self, char: str) -> None:
        text = self._text + char
        if not " " <= char <= "~":
            self._abort(char)
        elif text == "\x1b[M":
            self._wait(self._x10, text)
        elif text == "\x1b[[" or (char < "@" and text not in ANSI_SEQUENCES_KEYS):
            self._wait(self._csi, text[:_LONGEST])
        elif len(text) <= _LONGEST:
            self._give(text)
        else:
            self._state = self._ground

    def _x10(self, char: str) -> None:
        """Three characters of a mouse report."""
        text = self._text + char
        if char < " ":
            self._abort(char)
        elif len(text) == len("\x1b[Mbxy"):
            self._give(text)
        else:
            self._wait(self._x10, text)

    def _ss3(self, char: str) -> None:
        if self._text + char in ANSI_SEQUENCES_KEYS:
            self._give(self._text + char)
        else:
            self._pieces.append(self._text)
            self._ground(char)

    def _abort(self, char: str) -> None:
        """What cannot be in a control sequence ends it; it is dropped."""
        self._state = self._ground
        if char != _SUBSTITUTE:
            self._ground(char)

    def _begin_string(self) -> None:
        self._size, self._begun = 0, self._now
        self._wait(self._string)

    def _string(self, char: str) -> None:
        """In an answer that is not kept."""
        if self._now - self._begun > STRING_TIME and self._now - self._since >= PAUSE:
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
        """This ends a string, or begins something else."""
        self._escape(char)

    def _flood(self, char: str) -> None:
        """Whatever it is, all of it is dropped, till it pauses; but somebody may want to stop."""
        self._since = self._now
        if char == CANCEL:
            self._pieces.append(CANCEL)

    # what may be the rest of a sequence whose escape was given as a key

    def _held_csi(self, char: str) -> None:
        text = self._text + char
        if _is_known(ESCAPE + text):
            self._give(ESCAPE + text)
        elif _MAY_BE_CSI.fullmatch(text):
            self._text = text
        else:
            self._were_keys(char)

    def _held_string(self, char: str) -> None:
        text = self._text + char
        if WHOLE_ANSWER.fullmatch(text):
            self._state = self._ground
        elif ANSWERS.match(text) or len(text) > _LONGEST:  # nobody types that
            self._begin_string()
        elif MAY_ANSWER.fullmatch(text):
            self._text = text
        else:
            self._were_keys(char)

    def _were_keys(self, char: str) -> None:
        self._state = self._ground
        for key in self._text + char:
            self._state(key)


def _is_known(sequence: str) -> bool:
    return (
        sequence in (PASTE_BEGIN, PASTE_END)
        or keys_of(sequence) is not None
        or FOR_TEXTUAL.fullmatch(sequence) is not None
        or ANSWER.fullmatch(sequence) is not None
    )
