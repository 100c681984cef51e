"""Marks on messages that carry the count of STOPs (robot/stop/gate.py) through Textual.

A key becomes a message of its field, that a message of the panel, and that a call of the app, each
in a queue and a task of its own. Textual passes on the types that `prevent` names from a message to
all that follow from it; the marks are put among them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import NamedTuple, Protocol, TypeVar, cast

from textual.message import Message
from textual.message_pump import MessagePump

from archo_tui.robot.stop.gate import Stops

Mark = TypeVar("Mark")


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


def mark_stops(message: Message, stops: int) -> None:
    """Mark a message, and all messages that follow from it, as read after so many STOPs."""
    message._prevent.add(cast("type[Message]", StopMark(stops)))


def stops_before(message: Message) -> int | None:
    """Return the lowest count of STOPs in a message's marks; None if nobody typed its cause."""
    if not message._prevent:  # True of most messages.
        return None
    found: set[object] = {*message._prevent}
    return min((mark.stops for mark in found if isinstance(mark, StopMark)), default=None)


class TypedAfter(NamedTuple):
    """A mark on a message: the last time before its input when the terminal had nothing to read."""

    at: float  # Monotonic time, in s.


def typed_after(message: Message) -> float | None:
    """Return the earliest time in s at which a message can have been typed; None if not marked.

    A busy machine reads late: only by this time it is known how long ago a key came before it.
    """
    mark = _mark_of(message, TypedAfter)
    return None if mark is None else mark.at


class InputTime(NamedTuple):
    """A mark on a message: the earliest time of the input that the message results from."""

    at: float  # s, on the clock of `Message.time`
    pause: float  # s since the input before was read


def now() -> float:
    """Return the time in s, on the clock of `Message.time`."""
    return Message().time


def mark_input(message: Message, read: InputTime) -> None:
    """Mark a message, and all messages that follow from it, as the result of an input."""
    message._prevent.add(cast("type[Message]", read))


def marks_of(message: Message, pump: MessagePump) -> AbstractContextManager[None]:
    """Return a context in which messages that `pump` posts get the marks of another message."""
    return pump.prevent(*message._prevent)


def input_of(message: Message) -> InputTime | None:
    """Return the input that a message results from, or None if it has no such mark."""
    return _mark_of(message, InputTime)


def _mark_of(message: Message, kind: type[Mark]) -> Mark | None:
    found: set[object] = {*message._prevent}
    return next((mark for mark in found if isinstance(mark, kind)), None)


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
        if empty_at is not None:
            message._prevent.add(cast("type[Message]", TypedAfter(empty_at)))
        if app.is_stop(message):
            mark_stops(message, app.stops.register())
            stop(message)
        else:
            mark_stops(message, app.stops.count)
            others.append(message)
    for message in others:
        other(message)
