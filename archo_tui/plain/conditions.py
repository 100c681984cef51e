"""The waiting for conditions that no single event announces."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable

from archo_tui.clock import Clock


class Conditions:
    """The waiting tasks of a loop, whose conditions are checked again after every change.

    All methods are called on the running loop.
    """

    def __init__(self, clock: Clock) -> None:
        """Create the conditions of the running loop, none of them waited for yet.

        Args:
            clock: Measures the timeouts.
        """
        self._clock = clock
        self._changed = asyncio.Event()

    def check_again(self) -> None:
        """Check every condition that is waited for again, because something has changed."""
        self._changed.set()

    async def wait(self, condition: Callable[[], object]) -> None:
        """Wait until the condition holds, for any time."""
        while not condition():
            self._changed.clear()
            await self._changed.wait()

    async def wait_at_most(
        self, condition: Callable[[], object], timeout: float | None = None
    ) -> None:
        """Wait until the condition holds or the time has passed.

        Args:
            condition: The condition; a true value ends the wait.
            timeout: Seconds; None for no limit.
        """
        with contextlib.suppress(TimeoutError):
            await self._clock.wait_for(self.wait(condition), timeout)
