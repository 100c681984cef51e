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
        """Return the counter of STOPs that were read."""


class StopMark(NamedTuple):
    """A mark on a message: how many STOPs had been read before its input.

    The mark of a STOP counts that STOP itself.
    """

    stops: int


def mark_stops(message: Message, stops: int) -> None:
    """Mark a message, and all messages that follow from it, as read after so many STOPs."""
    message._prevent.add(cast("type[Message]", StopMark(stops)))


def stops_before(message: Message) -> int | None:
    """Return the count of STOPs in a message's mark, or None for a message without a mark.

    Nobody typed the cause of such a message. Of several marks the lowest count is returned.
    """
    if not message._prevent:  # True of most messages.
        return None
    found: set[object] = {*message._prevent}
    return min((mark.stops for mark in found if isinstance(mark, StopMark)), default=None)


class InputTime(NamedTuple):
    """A mark on a message: when the input was read that the message results from.

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
    """Mark a message, and all messages that follow from it, as the result of an input."""
    message._prevent.add(cast("type[Message]", read))


def marks_of(message: Message, pump: MessagePump) -> AbstractContextManager[None]:
    """Return a context in which posted messages get the marks of another message.

    Args:
        message: The message with the marks.
        pump: The app, screen or widget that posts messages in the context.
    """
    return pump.prevent(*message._prevent)


def input_of(message: Message) -> InputTime | None:
    """Return the input that a message results from, or None if it has no such mark."""
    found: set[object] = {*message._prevent}
    return next((mark for mark in found if isinstance(mark, InputTime)), None)


def dispatch(
    messages: Iterable[Message],
    app: StopKeyOwner,
    stop: Callable[[Message], object],
    other: Callable[[Message], object],
) -> None:
    """Count the STOPs among messages that were read together, and pass on STOPs before all others.

    Each message is marked with the count of STOPs typed before it, a STOP's own included.

    Args:
        messages: The messages, in the order of typing.
        app: Knows the key of STOP, and has the counter.
        stop: Called with each STOP, before all other messages.
        other: Called with each other message, in their order.
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
