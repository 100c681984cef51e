"""Marks on messages that carry the count of STOPs (robot/stops.py) through Textual.

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

from archo_tui.robot.stops import Stops


class StopKeyOwner(Protocol):
    """An app that knows the key of STOP, and counts its presses."""

    def is_stop(self, message: Message) -> bool:
        """Return True for the key of STOP. Any thread."""

    @property
    def stops(self) -> Stops:
        """Return the counter of STOPs that were read."""


class StopMark(NamedTuple):
    """A mark on a message: how many STOPs had been read before its input."""

    stops: int


def mark_stops(message: Message, stops: int) -> None:
    """Mark a message as read after so many STOPs."""
    message._prevent.add(cast("type[Message]", StopMark(stops)))


def stops_before(message: Message) -> int | None:
    """Return the count of STOPs in a message's mark, or None for what nobody typed."""
    if not message._prevent:  # True of most messages.
        return None
    found: set[object] = {*message._prevent}
    return min((mark.stops for mark in found if isinstance(mark, StopMark)), default=None)


class InputTime(NamedTuple):
    """A mark on a message: when its input was read.

    Attributes:
        at: The time of the reading in s, on the clock of `Message.time`.
        pause: The seconds since the input before.
    """

    at: float
    pause: float


def now() -> float:
    """Return the time in s, on the clock of `Message.time`."""
    return Message().time


def mark_input(message: Message, read: InputTime) -> None:
    """Mark a message as the result of an input."""
    message._prevent.add(cast("type[Message]", read))


def marks_of(message: Message, pump: MessagePump) -> AbstractContextManager[None]:
    """Return a context in which posted messages get the marks of this one."""
    return pump.prevent(*message._prevent)


def input_of(message: Message) -> InputTime | None:
    """Return the input that a message results from, or None for what nobody typed."""
    found: set[object] = {*message._prevent}
    return next((mark for mark in found if isinstance(mark, InputTime)), None)


def dispatch(
    messages: Iterable[Message],
    app: StopKeyOwner,
    stop: Callable[[Message], object],
    other: Callable[[Message], object],
) -> None:
    """Mark messages that were read together with the count of STOPs before each, and pass them on.

    Args:
        messages: The messages, in the order of typing.
        app: Counts the STOPs.
        stop: Called with each STOP, before all other messages.
        other: Called with each other message.
    """
    others = []
    for message in messages:
        if app.is_stop(message):
            mark_stops(message, app.stops.register())
            stop(message)
        else:
            mark_stops(message, app.stops.count)
            others.append(message)
    for message in others:
        other(message)
