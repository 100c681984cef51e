"""What was typed carries the count of STOPs (robot/stops.py) through Textual's messages.

A key becomes a message of its field, that one of the panel, and that a call of the app, each in a
queue and a task of its own. What Textual hands on from a message to all that follows from it are
the types that `prevent` names: the count goes along among them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import NamedTuple, Protocol, cast

from textual.message import Message
from textual.message_pump import MessagePump

from archo_tui.robot.stops import Stops


class KnowsStop(Protocol):
    """What knows the key of STOP, and counts."""

    def is_stop(self, message: Message) -> bool:
        """True for the key of STOP. Any thread."""

    @property
    def stops(self) -> Stops:
        """Counts what is read."""


class Typed(NamedTuple):
    """A mark on a message: how many STOPs had been read before its input."""

    stops: int


def mark(message: Message, stops: int) -> None:
    """It was read after so many STOPs."""
    message._prevent.add(cast("type[Message]", Typed(stops)))


def typed_after(message: Message) -> int | None:
    """The count that it is marked with; None for what nobody typed."""
    if not message._prevent:  # of nearly all of them
        return None
    found: set[object] = {*message._prevent}
    return min((one.stops for one in found if isinstance(one, Typed)), default=None)


class Read(NamedTuple):
    """A mark on a message: when its input was read, and how long behind what was typed before."""

    at: float  # s, as messages have their time
    pause: float  # s


def now() -> float:
    """The time (s), as messages have theirs."""
    return Message().time


def mark_read(message: Message, read: Read) -> None:
    """It comes of what was read then."""
    message._prevent.add(cast("type[Message]", read))


def with_its_marks(message: Message, pump: MessagePump) -> AbstractContextManager[None]:
    """What is posted meanwhile has the marks that the message got after it came."""
    return pump.prevent(*message._prevent)


def read_of(message: Message) -> Read | None:
    """The input that it comes of; None for what nobody typed."""
    found: set[object] = {*message._prevent}
    return next((one for one in found if isinstance(one, Read)), None)


def hand_on(
    messages: Iterable[Message],
    app: KnowsStop,
    stop: Callable[[Message], object],
    other: Callable[[Message], object],
) -> None:
    """What was read at once: each with the count of STOPs before it, and STOP first of all."""
    others = []
    for message in messages:
        if app.is_stop(message):
            mark(message, app.stops.read())
            stop(message)
        else:
            mark(message, app.stops.count)
            others.append(message)
    for message in others:
        other(message)
