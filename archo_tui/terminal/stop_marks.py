"""The marks of an input: the time at which it was read, and the count of STOPs before it.

They are attributes of the message of a key, paste or click. Whatever follows from an input happens
in its turn, and so the app knows its marks by then.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, Protocol

from textual.message import Message

from archo_tui.robot.stop.gate import Stops


class StopKeyOwner(Protocol):
    """An app that knows the key of STOP, and counts its presses."""

    def is_stop(self, message: Message) -> bool:
        """Return True if a message is the key of STOP. Any thread."""

    @property
    def stops(self) -> Stops:
        """The counter of STOPs that were read."""


class InputTime(NamedTuple):
    """The time at which an input was read."""

    at: float  # s, on the clock of `Message.time`
    pause: float  # s since the input before


def now() -> float:
    """Return the time in s, on the clock of `Message.time`."""
    return Message().time


def dispatch(
    messages: Iterable[Any],  # Textual's messages have no attribute `stops`.
    app: StopKeyOwner,
    stop: Callable[[Message], object],
    other: Callable[[Message], object],
) -> None:
    """Mark messages that were read together with the count of STOPs, and pass STOPs on first."""
    others = []
    for message in messages:
        is_stop = app.is_stop(message)
        message.stops = app.stops.register() if is_stop else app.stops.count
        if is_stop:
            stop(message)
        else:
            others.append(message)
    for message in others:
        other(message)
