"""A paste: what comes between two marks is text, whatever it is, and taken whole or not at all.

An end that does not come must not leave the operator without STOP. So a key that comes alone, where
the text of a paste comes in bursts, can end it: escape and ctrl+x at any time, others once the
paste has stalled.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from textual import events
from textual.message import Message

from archo_tui.terminal.keys import keys_of
from archo_tui.terminal.sequences import ESCAPE, PAUSE

PASTE_LIMIT = 1 << 20  # characters that are taken
STALL = 2.0  # s of silence after which a paste is broken

_MARK = re.compile(r"(?:\x1b\[|\x9b)20([01])~")
_BEGUN_MARK = re.compile(r"(?:\x1b|(?:\x1b\[|\x9b)(?:2(?:0[01]?)?)?)\Z")
_LONGEST_KEY = 32  # characters


class PasteCut(Message):
    """The end of a paste did not come."""


class Over(NamedTuple):
    """The paste is over."""

    messages: list[Message]  # what comes of it, and has not been told already
    rest: str  # what was read and is not of the paste


class Paste:
    """One, from its begin mark on."""

    def __init__(self, now: float, stop_key: str) -> None:
        """`stop_key` is Textual's name of the key of STOP."""
        self._ending = ("escape", "ctrl+x", stop_key)
        self._text: list[str] = []
        self._room = PASTE_LIMIT
        self._tail = ""  # what may be the first part of a mark
        self._broken = False
        self._heard = now  # monotonic s
        self._burst, self._silence = "", 0.0  # read without a pause, and the silence before it

    @property
    def waiting(self) -> bool:
        """True while silence would tell that an escape is the key."""
        return self._burst == ESCAPE and self._silence >= PAUSE

    def take(self, text: str, now: float, more: bool) -> Over | None:
        """What was read at once; there is more of it when that cannot be read yet."""
        if now - self._heard >= PAUSE:
            self._burst, self._silence = "", now - self._heard
        self._burst = (self._burst + text)[: _LONGEST_KEY + 1]
        self._heard = now
        text = self._tail + text
        if mark := _MARK.search(text):
            if mark[1] == "0":  # another one; the end of this one is lost
                return Over(self._cut(), text[mark.start() :])
            self._keep(text[: mark.start()])
            pasted = events.Paste("".join(self._text))
            return Over([] if self._broken else [pasted], text[mark.end() :])
        if not more and (key := self._key()):
            return Over(self._cut(), key)
        begun = _BEGUN_MARK.search(text)
        self._tail = begun[0] if begun else ""
        self._keep(text[: len(text) - len(self._tail)])
        return None

    def late(self, now: float) -> Over | None:
        """While nothing comes: an escape that came alone ends the paste."""
        if self.waiting and now - self._heard >= PAUSE:
            return Over(self._cut(), ESCAPE)
        return None

    def breaks(self, now: float) -> bool:
        """True once, when it has stalled: half a number would be a wrong one."""
        stalled = not self._broken and now - self._heard >= STALL
        if stalled:
            self._broken = True
        return stalled

    def _cut(self) -> list[Message]:
        return [] if self._broken else [PasteCut()]

    def _keep(self, text: str) -> None:
        if self._room and not self._broken:
            self._text.append(text[: self._room])
            self._room -= len(self._text[-1])

    def _key(self) -> str:
        """The key, where one came alone that acts; else an empty string."""
        burst = self._burst
        if self._silence < PAUSE or burst in ("", ESCAPE):
            return ""
        one = burst[: burst.find(burst[0], 1)] if burst.count(burst[0]) > 1 else burst
        is_held = (one * len(burst)).startswith(burst)  # one that is may come several times at once
        if is_held and any(key.key in self._ending for key in keys_of(one) or []):
            return one
        # one byte: two may be the text of a paste that comes slowly
        is_byte = len(burst) == 1 and burst.isascii()
        return burst if self._silence >= STALL and (is_byte or keys_of(burst)) else ""
