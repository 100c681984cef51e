"""What a terminal sends, as Textual's messages: keys, pastes, the mouse; and never anything else.

Textual's own parser (8.2.8) takes answers of the terminal for keys, and so it does with a sequence
or a paste that comes in pieces; it eats the key behind an escape, and raises on some sequences.
It only gets whole sequences of the forms that it knows, here.
"""

from __future__ import annotations

from textual import events
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual._xterm_parser import XTermParser
from textual.message import Message

from archo_tui.terminal.answers import FOR_TEXTUAL
from archo_tui.terminal.decoding import Decoder
from archo_tui.terminal.keys import alt_key, keys_of
from archo_tui.terminal.mouse import apart, last_moves
from archo_tui.terminal.paste import Paste, PasteStalled
from archo_tui.terminal.sequences import ESCAPE, PASTE_BEGIN, PASTE_END, PAUSE, Sequences


class Keyboard:
    """Takes bytes with the time they were read at; it reads no clock itself."""

    def __init__(self, stop_key: str = "ctrl+x", debug: bool = False) -> None:
        """`stop_key` is Textual's name of the key of STOP."""
        self._stop_key, self._debug = stop_key, debug
        self._parser = XTermParser(debug)
        self._decoder = Decoder()
        self._sequences = Sequences()
        self._paste: Paste | None = None
        self._late_end = ""  # what follows, if the escape that ended a paste began its end mark
        self._heard = 0.0  # monotonic s

    @property
    def waiting(self) -> bool:
        """True while silence would soon tell something, like what an escape means."""
        return self._sequences.waiting or (self._paste is not None and self._paste.waiting)

    def take(self, data: bytes, now: float) -> list[Message]:
        """What was read at once: all that was there."""
        messages = self.late(now)
        text = self._decoder.decode(data, after_a_pause=now - self._heard >= PAUSE)
        self._heard = now
        return messages + self._read(self._without_late_end(last_moves(text)), now)

    def late(self, now: float) -> list[Message]:
        """What silence tells; to be called while nothing comes."""
        messages: list[Message] = []
        if self._paste is not None:
            if self._paste.stalls(now):
                messages.append(PasteStalled())
            if over := self._paste.late(now):
                self._paste = None
                messages += over.messages + self._read(over.rest, self._heard)
                self._late_end = PASTE_END[1:] if over.rest == ESCAPE else ""
        return messages + self._messages(self._sequences.late(now))

    def _without_late_end(self, text: str) -> str:
        """Drop what is left of an end mark that came so slowly that its escape was the key."""
        if not text or not self._late_end:
            return text
        while text and text[0] == self._late_end[:1]:
            text, self._late_end = text[1:], self._late_end[1:]
        if text:
            self._late_end = ""
        return text

    def _read(self, text: str, now: float) -> list[Message]:
        messages: list[Message] = []
        while text:
            if self._paste is not None:
                of_it, text = self._pasted(self._paste, text, now)
                messages += of_it
                continue
            pieces, text = self._sequences.cut(text, now)
            messages += self._messages(pieces)
            if pieces[-1:] == [PASTE_BEGIN]:
                self._paste = Paste(now, self._stop_key)
        return messages

    def _pasted(self, paste: Paste, text: str, now: float) -> tuple[list[Message], str]:
        """What comes of text in a paste, and what stands behind that."""
        inside, mark, behind = text.partition(PASTE_END)
        reports, inside = apart(inside)  # a mouse moves while a paste has stalled
        messages, text = self._messages(reports), inside + mark + behind
        over = paste.take(text, now, self._decoder.is_amid_a_character) if text else None
        if over is None:
            return messages, ""
        self._paste = None
        return messages + over.messages, over.rest

    def _messages(self, pieces: list[str]) -> list[Message]:
        return [message for piece in pieces for message in self._of(piece)]

    def _of(self, piece: str) -> list[Message]:
        """What comes of a whole piece: nothing, when it is neither a key nor for Textual."""
        if piece == ESCAPE:
            return [events.Key("escape", ESCAPE)]
        if len(piece) == 1 or FOR_TEXTUAL.fullmatch(piece):
            return self._parse(piece)
        keys = keys_of(piece)
        # its table has characters for some that are not typed: alt+1
        if len(piece) == 2 and not isinstance(ANSI_SEQUENCES_KEYS.get(piece), tuple):
            keys = [alt_key(piece[1])]
        return [*(keys or [])]

    def _parse(self, piece: str) -> list[Message]:
        """By Textual; whatever it stumbles over, the keys go on."""
        try:
            return list(self._parser.feed(piece))
        except Exception:
            self._parser = XTermParser(self._debug)
            return []
