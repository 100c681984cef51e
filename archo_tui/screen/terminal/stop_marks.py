"""Marks on messages that carry the count of STOPs (robot/stop/gate.py) through Textual.

A key becomes a message of its field, that a message of the panel, and that a call of the app, each
in a queue and a task of its own. Textual passes on the types that `prevent` names from a message to
all that follow from it; the marks are put among them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import NamedTuple, Protocol, cast

from textual.message import Message
from textual.message_pump import MessagePump

from archo_tui.robot.stop.gate import Stops


class StopKeyOwner(Protocol):
    """An app that knows the key of STOP, and counts its presses."""

    def is_stop(self, message: Message) -> bool:
        """Return True if a message is the key of STOP. Any thread."""

    @property
    def stops(self) -> Stops:
        """The counter of STOPs that were read."""


class StopMark(NamedTuple):
    """A mark on a message: how many STOPs had been read before its input, its own included."""

    stops: int
    # Monotonic time, in s: the last one before its input when the terminal had nothing to read;
    # None if it comes from another driver than the terminal's.
    typed_after: float | None


def mark_stops(message: Message, stops: int, typed_after: float | None = None) -> None:
    """Mark a message, and all messages that follow from it, as read after so many STOPs."""
    message._prevent.add(cast("type[Message]", StopMark(stops, typed_after)))


def _marks(message: Message) -> list[StopMark]:
    found: set[object] = {*message._prevent}
    return [mark for mark in found if isinstance(mark, StopMark)]


def stops_before(message: Message) -> int | None:
    """Return the lowest count of STOPs in a message's marks; None if nobody typed its cause."""
    return min((mark.stops for mark in _marks(message)), default=None)


def typed_after(message: Message) -> float | None:
    """Return the earliest time in s at which a message can have been typed; None if not known.

    A busy machine reads late: only by this time it is known how long ago a key came before it.
    """
    return next((mark.typed_after for mark in _marks(message)), None)


def marks_of(message: Message, pump: MessagePump) -> AbstractContextManager[None]:
    """Return a context in which messages that `pump` posts get the marks of another message."""
    return pump.prevent(*message._prevent)


def dispatch(
    messages: Iterable[Message],
    app: StopKeyOwner,
    stop: Callable[[Message], object],
    other: Callable[[Message], object],
    empty_at: float | None = None,  # Monotonic time in s when there was nothing to read yet.
) -> None:
    """Mark messages that were read together with count and time, and pass STOPs on first."""
    others = []
    for message in messages:
        if app.is_stop(message):
            mark_stops(message, app.stops.register(), empty_at)
            stop(message)
        else:
            mark_stops(message, app.stops.count, empty_at)
            others.append(message)
    for message in others:
        other(message)
