"""What was typed carries the count of STOPs (robot/stops.py) through Textual's messages.

A key becomes a message of its field, that one of the panel, and that a call of the app, each in a
queue and a task of its own. What Textual hands on from a message to all that follows from it are
the types that `prevent` names: the count goes along among them.
"""

from __future__ import annotations

from typing import NamedTuple, cast

from textual.message import Message


class Typed(NamedTuple):
    """So many STOPs had been read when it was."""

    stops: int


def mark(message: Message, stops: int) -> None:
    """It was read after so many STOPs."""
    message._prevent.add(cast("type[Message]", Typed(stops)))


def typed_after(message: Message) -> int | None:
    """The STOPs that had been read before what it comes from; None: nobody typed it."""
    found: set[object] = {*message._prevent}
    return min((one.stops for one in found if isinstance(one, Typed)), default=None)
