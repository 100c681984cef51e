"""Who asks for what is being done: the person at the console, or a program beside it."""

from __future__ import annotations

from asyncio import Future
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Goal

ASSISTANT = "assistant"  # how the sources of those begin


class Asker:
    """One who asks; events and journal name it."""

    def __init__(self, level: str, source: str) -> None:
        """`level` and `source` are those of its events: `SHELL`, `pid 4711`."""
        self.level, self.source = level, source
        self.ends: list[Future[Outcome]] = []  # of the goals that it asked for
        self.goal: Goal | None = None  # the last of them that ended
        self.has_left = False  # whatever it still asks for is not done
        self.waits = False  # for the ends of its goals: they are cancelled when it leaves

    @property
    def is_assistant(self) -> bool:
        """True for a program that a model speaks through."""
        return self.source.startswith(ASSISTANT)


YOU = Asker("YOU", "console")
_asking: ContextVar[Asker] = ContextVar("asking", default=YOU)


def asking() -> Asker:
    """Who asks for what is being done."""
    return _asking.get()


@contextmanager
def asked_by(asker: Asker) -> Iterator[None]:
    """Do what this one asks for; the tasks that begin here carry it, too."""
    token = _asking.set(asker)
    try:
        yield
    finally:
        _asking.reset(token)
