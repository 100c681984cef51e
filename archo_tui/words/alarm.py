"""An alarm's times, in words. Pure."""

from __future__ import annotations

from archo_tui.clock import time_of_day
from archo_tui.station.alarms import Alarm


def times(alarm: Alarm) -> str:
    """`since 12:04:31, over at 12:05:02`, and why it was shelved."""
    text = f"since {time_of_day(alarm.since)}"
    if alarm.until is not None:
        text += f", over at {time_of_day(alarm.until)}"
    if alarm.shelved_until is not None:
        text += f", until {time_of_day(alarm.shelved_until)}"
    return f"{text}: {alarm.reason}" if alarm.reason else text
