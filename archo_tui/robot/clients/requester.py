"""The requester of the present work: the person at the console, or another program."""

from __future__ import annotations

from asyncio import Future
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.goal import Goal

ASSISTANT = "assistant"  # The beginning of an assistant's source.


class Requester:
    """A person or a program that requests something, as events and journal name it."""

    def __init__(self, level: str, source: str) -> None:
        self.level, self.source = level, source  # Of its events: `SHELL` and `pid 4711`.
        # Futures for the outcomes of the goals that it requested.
        self.ends: list[Future[Outcome]] = []
        self.goal: Goal | None = None  # The last of these goals that ended; None if none has.
        # True once it has gone: nothing more is sent for it, and what waits for an approval is
        # dropped.
        self.has_left = False
        # True if it waits for the end of its goals, which are cancelled if it leaves.
        self.waits = False

    @property
    def is_assistant(self) -> bool:
        """True for a program through which a language model sends requests."""
        return self.source.startswith(ASSISTANT)


YOU = Requester("YOU", "console")
_current: ContextVar[Requester] = ContextVar("current_requester", default=YOU)


def current_requester() -> Requester:
    """Return the requester of the present work; the person at the console by default."""
    return _current.get()


@contextmanager
def on_behalf_of(requester: Requester) -> Iterator[None]:
    """Make a requester the current one inside the `with` block, and in tasks that begin there."""
    token = _current.set(requester)
    try:
        yield
    finally:
        _current.reset(token)
