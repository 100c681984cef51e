"""A paste: what comes between two marks is text, whatever it is, and taken whole or not at all.

It may stall for as long as it likes: what comes behind is its text, and no keys. An end that never
comes must not leave the operator without STOP, so two keys end a paste when they come alone: ctrl+x
at once, and escape when nothing comes before and behind it for a while.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from textual import events
from textual.message import Message

from archo_tui.terminal.keys import keys_of
from archo_tui.terminal.sequences import PAUSE

PASTE_LIMIT = 1 << 20  # characters that are taken
STALL = 2.0  # s of silence after which the operator is told how to end the paste
ALONE = 0.5  # s of silence before and behind an escape that ends the paste

_MARK = re.compile(r"(?:\x1b\[|\x9b)20([01])~")
_BEGUN_MARK = re.compile(r"(?:\x1b|(?:\x1b\[|\x9b)(?:2(?:0[01]?)?)?)\Z")
_LONGEST_KEY = 32  # characters


class PasteCut(Message):
    """The end of a paste did not come."""


class PasteStalled(Message):
    """Nothing has come of a paste for a while, and its end has not either."""


class Over(NamedTuple):
    """The paste is over."""

    messages: list[Message]  # what comes of it
    rest: str  # what was read and is not of the paste


class Paste:
    """One, from its begin mark on."""

    def __init__(self, now: float, stop_key: str) -> None:
        """`stop_key` is Textual's name of the key of STOP."""
        self._stops = ("ctrl+x", stop_key)
        self._text: list[str] = []
        self._room = PASTE_LIMIT
        self._tail = ""  # what may be the first part of a mark
        self._has_stalled = False
        self._heard = now  # monotonic s
        self._burst, self._silence = "", 0.0  # read without a pause, and the silence before it

    @property
    def waiting(self) -> bool:
        """True while silence would tell that an escape is the key."""
        return self._silence >= ALONE and self._key() == "escape"

    def take(self, text: str, now: float, more: bool) -> Over | None:
        """What was read at once; there is more of it when that cannot be read yet."""
        if now - self._heard >= PAUSE:
            self._burst, self._silence = "", now - self._heard
        self._burst = (self._burst + text)[: _LONGEST_KEY + 1]
        self._heard = now
        text = self._tail + text
        if mark := _MARK.search(text):
            if mark[1] == "0":  # another one; the end of this one is lost
                return Over([PasteCut()], text[mark.start() :])
            self._keep(text[: mark.start()])
            return Over([events.Paste("".join(self._text))], text[mark.end() :])
        if not more and self._silence >= PAUSE and self._key() in self._stops:
            return Over([PasteCut()], self._once)
        begun = _BEGUN_MARK.search(text)
        self._tail = begun[0] if begun else ""
        self._keep(text[: len(text) - len(self._tail)])
        return None

    def late(self, now: float) -> Over | None:
        """While nothing comes: an escape that came alone ends the paste."""
        if self.waiting and now - self._heard >= ALONE:
            return Over([PasteCut()], self._once)
        return None

    def stalls(self, now: float) -> bool:
        """True once, when nothing has come for a while."""
        has_stalled = not self._has_stalled and now - self._heard >= STALL
        self._has_stalled = self._has_stalled or has_stalled
        return has_stalled

    def _keep(self, text: str) -> None:
        if self._room:
            self._text.append(text[: self._room])
            self._room -= len(self._text[-1])

    @property
    def _once(self) -> str:
        """The burst, without the repetitions of a key that is held."""
        burst = self._burst
        return burst[: burst.find(burst[0], 1)] if burst.count(burst[0]) > 1 else burst

    def _key(self) -> str:
        """Textual's name of the key that is all of the burst; else an empty string."""
        burst = self._burst
        if not burst or not (self._once * len(burst)).startswith(burst):
            return ""
        keys = keys_of(self._once)
        return keys[0].key if keys else ""
