"""A paste: text between two marks, taken whole or not at all.

A paste may stall for as long as it likes: what follows belongs to it and is no key. An end mark
that never arrives must not leave the operator without STOP, so two keys end a paste if they come
alone: ctrl+x at once, and escape if nothing comes before and after it for a while.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from textual import events
from textual.message import Message

from archo_tui.terminal.keys import keys_of
from archo_tui.terminal.sequences import PAUSE

PASTE_LIMIT = 1 << 20  # Characters; the rest of a paste is dropped.
STALL = 2.0  # Seconds of silence until the operator is told how to end the paste.
ALONE = 0.5  # Seconds of silence before and after an escape that ends the paste.

_MARK = re.compile(r"(?:\x1b\[|\x9b)20([01])~")
_BEGUN_MARK = re.compile(r"(?:\x1b|(?:\x1b\[|\x9b)(?:2(?:0[01]?)?)?)\Z")
_MAX_KEY = 32  # Characters of a key's sequence.


class PasteCut(Message):
    """A message: a paste ended without its end mark, so nothing of it was taken."""


class PasteStalled(Message):
    """A message: a paste has not ended, and nothing of it has arrived for 2 s; once a paste."""


class PasteEnd(NamedTuple):
    """The end of a paste."""

    messages: list[Message]  # The paste itself, or PasteCut.
    rest: str  # What was read after the paste, or the key that has ended it.


class Paste:
    """A paste from its begin mark on, which keeps its first PASTE_LIMIT characters."""

    def __init__(self, now: float, stop_key: str) -> None:
        self._stops = ("ctrl+x", stop_key)
        self._text: list[str] = []
        self._left = PASTE_LIMIT
        self._tail = ""  # The first part of what may be a mark.
        self._has_stalled = False
        self._last_time = now  # Monotonic time of the last reading, in s.
        # What was read without a pause, and the seconds of silence before it.
        self._burst, self._silence = "", 0.0

    @property
    def is_waiting(self) -> bool:
        """True while silence decides if an escape is the key that ends the paste."""
        return self._silence >= ALONE and self._burst_key_name() == "escape"

    def feed(self, text: str, now: float, is_amid_character: bool) -> PasteEnd | None:
        """Add text that was read, and return the end of the paste, or None if it goes on.

        Without its end mark, a new begin mark ends the paste, or ctrl+x or the key of STOP alone
        after a silence: it is cut off then. No key does if the reading ended within a character.
        """
        if now - self._last_time >= PAUSE:
            self._burst, self._silence = "", now - self._last_time
        self._burst = (self._burst + text)[: _MAX_KEY + 1]
        self._last_time = now
        text = self._tail + text
        if mark := _MARK.search(text):
            if mark[1] == "0":  # Another paste begins: the end of this one is lost.
                return PasteEnd([PasteCut()], text[mark.start() :])
            self._append_text(text[: mark.start()])
            return PasteEnd([events.Paste("".join(self._text))], text[mark.end() :])
        if (
            not is_amid_character
            and self._silence >= PAUSE
            and self._burst_key_name() in self._stops
        ):
            return PasteEnd([PasteCut()], self._burst_key)
        begun = _BEGUN_MARK.search(text)
        self._tail = begun[0] if begun else ""
        self._append_text(text[: len(text) - len(self._tail)])
        return None

    def on_silence(self, now: float) -> PasteEnd | None:
        """Return the end of the paste if an escape came alone, with silence around it."""
        if self.is_waiting and now - self._last_time >= ALONE:
            return PasteEnd([PasteCut()], self._burst_key)
        return None

    def has_just_stalled(self, now: float) -> bool:
        """Return True when nothing has arrived for STALL seconds; only once a paste."""
        has_stalled = not self._has_stalled and now - self._last_time >= STALL
        self._has_stalled = self._has_stalled or has_stalled
        return has_stalled

    def _append_text(self, text: str) -> None:
        if self._left:
            self._text.append(text[: self._left])
            self._left -= len(self._text[-1])

    @property
    def _burst_key(self) -> str:
        """The first key of what was read without a pause.

        A key that is held repeats its sequence, so the key ends where its first character comes
        again.
        """
        burst = self._burst
        return burst[: burst.find(burst[0], 1)] if burst.count(burst[0]) > 1 else burst

    def _burst_key_name(self) -> str:
        """Return Textual's name of the key if it is all that was read without a pause, else ""."""
        burst = self._burst
        if not burst or not (self._burst_key * len(burst)).startswith(burst):
            return ""
        keys = keys_of(self._burst_key)
        return keys[0].key if keys else ""
