"""The waiting for conditions that no single event announces."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable

from archo_tui.clock import Clock


class Conditions:
    """The conditions that tasks wait for; whoever changes one calls `check_again`, on the loop."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._changed = asyncio.Event()

    def check_again(self) -> None:
        """Wake every waiting task, which checks its condition when the loop runs it next."""
        self._changed.set()

    async def wait(self, condition: Callable[[], object]) -> None:
        """Wait until `condition()` is true: it is called at once, and after each `check_again`."""
        while not condition():
            self._changed.clear()
            await self._changed.wait()

    async def wait_at_most(
        self, condition: Callable[[], object], timeout: float | None = None
    ) -> None:
        """Wait until `condition()` is true or the time in seconds has passed; None for no limit."""
        with contextlib.suppress(TimeoutError):
            await self._clock.wait_for(self.wait(condition), timeout)
