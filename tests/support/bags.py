"""Bags and recordings as the black box writes them, of messages that were never received."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from archo_tui.recordings import store
from archo_tui.recordings.bag import BagWriter, LazyMessage, ReceivedMessage
from archo_tui.robot.node import serialize


def received(time: int, topic: str, message: Any) -> ReceivedMessage:
    """A message that came at that time, in ns; one that is made later if it is a LazyMessage."""
    if isinstance(message, LazyMessage):
        return ReceivedMessage(time, topic, type(message.make(True, 0.0)), message)
    return ReceivedMessage(time, topic, type(message), serialize(message))


def write(
    folder: Path,
    messages: Sequence[ReceivedMessage],
    about: dict[str, str] | None = None,
    **attached: str,
) -> BagWriter:
    """A whole bag in an empty folder; their times are Unix times."""
    writer = BagWriter(folder)
    writer.add(messages)
    writer.attach(attached)
    writer.finish(about or {})
    return writer


def add(folder: Path, at: float, what: str, fill: Callable[[Path], object]) -> Path:
    """A recording among others, as that of an event at a Unix time."""
    hidden = store.make_hidden(folder)
    fill(hidden)
    return store.publish(hidden, at, what)
