"""The keyboard: a terminal's bytes as Textual's messages for keys, pastes and the mouse.

Textual's own parser (8.2.8) takes replies of the terminal for keys, and also a sequence or a paste
that arrives in pieces; it swallows the key after an escape, and raises on some sequences. Here it
gets whole sequences only, of the forms that it knows.
"""

from __future__ import annotations

import codecs
import string

from textual import events
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual._xterm_parser import XTermParser
from textual.message import Message

from archo_tui.terminal.keys import alt_key, keys_of
from archo_tui.terminal.paste import Paste, PasteStalled
from archo_tui.terminal.replies import FOR_TEXTUAL, drop_passed_moves, split_reports
from archo_tui.terminal.sequences import ESCAPE, PASTE_BEGIN, PASTE_END, PAUSE, Sequences


def _replace_or_control(error: UnicodeError) -> tuple[str, int]:
    """Return U+FFFD or an 8-bit control for bytes that are not UTF-8, and where they end."""
    assert isinstance(error, UnicodeDecodeError)
    wrong = error.object[error.start : error.end]
    is_control = len(wrong) == 1 and 0x80 <= wrong[0] <= 0x9F
    return (chr(wrong[0]) if is_control else "\N{REPLACEMENT CHARACTER}"), error.end


codecs.register_error("archo-terminal", _replace_or_control)


class Decoder:
    """An incremental decoder that keeps the bytes of an incomplete character for the next call."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("archo-terminal")

    def decode(self, data: bytes, *, after_a_pause: bool) -> str:
        """Return the text that the bytes complete; never raise, and drop what a pause cut off."""
        if after_a_pause and data[:1].isascii():
            self._decoder.reset()  # The rest of the character will not come.
        return self._decoder.decode(data)

    @property
    def is_amid_character(self) -> bool:
        return self._decoder.getstate()[0] != b""


class Keyboard:
    """A parser of a terminal's bytes into messages. Nothing here reads a clock or a file."""

    def __init__(self, stop_key: str = "ctrl+x", debug: bool = False) -> None:
        self._stop_key, self._debug = stop_key, debug  # debug: Textual's flag, for its parser
        self._parser = XTermParser(debug)
        self._decoder = Decoder()
        self._sequences = Sequences()
        self._paste: Paste | None = None
        self._stray_end = ""  # The rest of an end mark whose escape has ended the paste already.
        self._last_time = 0.0  # Monotonic time of the last reading, in s.

    @property
    def is_waiting(self) -> bool:
        """True while a short silence decides something: `on_silence` is to be called more often."""
        return self._sequences.is_waiting or (self._paste is not None and self._paste.is_waiting)

    def feed(self, data: bytes, now: float) -> list[Message]:
        """Return the messages for bytes that were read at a monotonic time.

        Those that the silence before decided come first. Replies of the terminal, and moves of the
        mouse that another move follows, give no message.
        """
        messages = self.on_silence(now)
        text = self._decoder.decode(data, after_a_pause=now - self._last_time >= PAUSE)
        self._last_time = now
        return messages + self._read(self._drop_stray_end(drop_passed_moves(text)), now)

    def on_silence(self, now: float) -> list[Message]:
        """Return the messages that silence decides; call it regularly while nothing arrives."""
        messages: list[Message] = []
        if self._paste is not None:
            if self._paste.has_just_stalled(now):
                messages.append(PasteStalled())
            if over := self._paste.on_silence(now):
                self._paste = None
                messages += over.messages + self._read(over.rest, self._last_time)
                self._stray_end = PASTE_END[1:] if over.rest == ESCAPE else ""
        return messages + self._all_messages(self._sequences.on_silence(now))

    def _drop_stray_end(self, text: str) -> str:
        """Return a text without the rest of an end mark whose escape was taken as a key."""
        if not text or not self._stray_end:
            return text
        while text and text[0] == self._stray_end[:1]:
            text, self._stray_end = text[1:], self._stray_end[1:]
        if text:
            self._stray_end = ""
        return text

    def _read(self, text: str, now: float) -> list[Message]:
        messages: list[Message] = []
        while text:
            if self._paste is not None:
                pasted, text = self._feed_paste(self._paste, text, now)
                messages += pasted
                continue
            sequences, text = self._sequences.feed(text, now)
            messages += self._all_messages(sequences)
            if sequences[-1:] == [PASTE_BEGIN]:
                self._paste = Paste(now, self._stop_key)
        return messages

    def _feed_paste(self, paste: Paste, text: str, now: float) -> tuple[list[Message], str]:
        """Return the messages for a text within a paste, and the text behind the end of the paste.

        Mouse and focus reports are taken out of it. The end clears `_paste`.
        """
        inside, mark, behind = text.partition(PASTE_END)
        reports, inside = split_reports(inside)  # The mouse may move while a paste stalls.
        messages, text = self._all_messages(reports), inside + mark + behind
        over = paste.feed(text, now, self._decoder.is_amid_character) if text else None
        if over is None:
            return messages, ""
        self._paste = None
        return messages + over.messages, over.rest

    def _all_messages(self, sequences: list[str]) -> list[Message]:
        return [message for sequence in sequences for message in self._to_messages(sequence)]

    def _to_messages(self, sequence: str) -> list[Message]:
        """Return the messages for a whole sequence; none if it is neither a key nor for Textual."""
        if sequence == ESCAPE:
            return [events.Key("escape", ESCAPE)]
        if len(sequence) == 1 or FOR_TEXTUAL.fullmatch(sequence):
            return self._parse_by_textual(sequence)
        keys = keys_of(sequence)
        # Textual's table has characters for some keys that type none, such as alt+1.
        if len(sequence) == 2 and not isinstance(ANSI_SEQUENCES_KEYS.get(sequence), tuple):
            keys = [alt_key(sequence[1])]
            if sequence[1] in string.digits:  # In tmux, escape and then a panel's number.
                keys.insert(0, events.Key("escape", ESCAPE))
        return [*(keys or [])]

    def _parse_by_textual(self, sequence: str) -> list[Message]:
        """Return Textual's messages for a sequence; none if its parser raises an exception."""
        try:
            return list(self._parser.feed(sequence))
        except Exception:
            self._parser = XTermParser(self._debug)
            return []
