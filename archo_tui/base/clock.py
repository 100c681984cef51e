"""The clock that everything asks which depends on time, so that a test can replace it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable
from datetime import datetime
from typing import Annotated, TypeVar

T = TypeVar("T")
# Recordings know by these types which numbers are times.
Monotonic = Annotated[float, "monotonic time, in s"]
UnixTime = Annotated[float, "Unix time, in s"]

LAST_STAMP = 2**31 - 1  # The latest Unix time in s of builtin_interfaces/Time, an int32.


class Clock:
    """The clock of this machine; a test puts another one in its place."""

    def monotonic(self) -> float:
        """Return monotonic time in s, for ages and deadlines."""
        return time.monotonic()

    def now(self) -> float:
        """Return Unix time in s, for the time of day."""
        return time.time()

    async def sleep(self, seconds: float) -> None:
        """Sleep for a number of seconds."""
        await asyncio.sleep(seconds)

    async def wait_for(self, awaitable: Awaitable[T], seconds: float | None) -> T:
        """Return the value of `awaitable`, or cancel it and raise TimeoutError; None: no limit."""
        work = asyncio.ensure_future(awaitable)
        over = asyncio.ensure_future(self._never() if seconds is None else self.sleep(seconds))
        try:
            await asyncio.wait({work, over}, return_when=asyncio.FIRST_COMPLETED)
            if not work.done():
                raise TimeoutError
            return work.result()
        finally:
            over.cancel()
            work.cancel()

    async def _never(self) -> None:
        await asyncio.get_running_loop().create_future()


def time_of_day(unix_time: float) -> str:
    """Return a Unix time as HH:MM:SS in local time."""
    return datetime.fromtimestamp(unix_time).strftime("%H:%M:%S")
