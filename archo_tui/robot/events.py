"""The log of the session: bounded, in order, repeats counted instead of repeated."""

from __future__ import annotations

import re
from collections import deque
from dataclasses import replace

from archo_tui.robot.state import Event

LIMIT = 1000  # events kept
_MERGE_WITHIN = 8  # newest events among which a repeat is looked for

_NUMBER = re.compile(r"\d+(\.\d+)?")
# C0 and C1 controls, and the marks that turn the direction of text around
_UNSAFE = re.compile("[\x00-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2060-\u2069\ufeff]")
_LONGEST = 500  # characters of a line that are kept


def harmless(text: str) -> str:
    """Text from outside without anything that a terminal could act on, and of bounded length."""
    text = _UNSAFE.sub("\N{REPLACEMENT CHARACTER}", text[: _LONGEST + 1])
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."


class EventLog:
    """Collects events; one that repeats a recent one but for its numbers replaces it."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=LIMIT)

    def add(self, event: Event) -> Event:
        """Append an event, or count it on the one it repeats. The operator's are never merged.

        Returns it as it stands in the log.
        """
        event = replace(event, text=harmless(event.text), source=harmless(event.source))
        if event.level != "YOU":
            for back in range(1, min(_MERGE_WITHIN, len(self._events)) + 1):
                known = self._events[-back]
                if _key(known) == _key(event):
                    self._events[-back] = replace(event, count=known.count + 1)
                    return self._events[-back]
        self._events.append(event)
        return event

    def all(self) -> tuple[Event, ...]:
        """Oldest first."""
        return tuple(self._events)


def _key(event: Event) -> tuple[str, str, str]:
    return event.level, event.source, _NUMBER.sub("#", event.text)
