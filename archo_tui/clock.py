"""The time, as an object: tests move it."""

from __future__ import annotations

import time
from datetime import datetime


class Clock:
    """The machine's own time."""

    def monotonic(self) -> float:
        """Seconds that only grow; for ages."""
        return time.monotonic()

    def now(self) -> float:
        """Unix time; for the time of day."""
        return time.time()


def time_of_day(unix_time: float) -> str:
    """HH:MM:SS in local time."""
    return datetime.fromtimestamp(unix_time).strftime("%H:%M:%S")
