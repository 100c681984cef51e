"""The texts of alarms, and of what the robot reports of its parts. Pure functions."""

from __future__ import annotations

from archo_tui.base.clock import time_of_day
from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.text.state import age_text, no_data_text, no_message_reason


def timeline(alarm: Alarm) -> str:
    """Return `since 12:04:31, over at 12:05:02, unacknowledged`, and the reason if given."""
    text, state = f"since {time_of_day(alarm.since)}", alarm.state.value
    if alarm.until is not None:
        text += f", over at {time_of_day(alarm.until)}"
        state = state.removeprefix("over, ")
    if alarm.shelved_until is not None:
        state += f" until {time_of_day(alarm.shelved_until)}"
    return f"{text}, {state}: {alarm.reason}" if alarm.reason else f"{text}, {state}"


def no_alarms_text(snapshot: Snapshot) -> str:
    """Return that there are no alarms, or that no data has come from which one could arise."""
    return no_data_text(snapshot) or "No alarms: nothing needs attention."


def state_word(alarm: Alarm) -> str:
    """Return the words of an alarm's state; a shelved alarm's say also if its condition is over."""
    is_over = alarm.state == AlarmState.SHELVED and alarm.is_over
    return f"over, {alarm.state.value}" if is_over else alarm.state.value


GLYPHS = {
    DiagnosticLevel.OK: "●",
    DiagnosticLevel.WARN: "▲",
    DiagnosticLevel.ERROR: "✗",
    DiagnosticLevel.STALE: "?",
}


def diagnostic_line(status: Diagnostic, now: float) -> str:
    """Return `✗ ERROR base: left motor (sn 12): too hot`, with the age of a silent status."""
    head = f"{GLYPHS[status.level]} {status.level.value:<5} {status.part}"
    if status.is_silent_at(now):
        return f"{head}: {status.message} (old, {age_text(now - status.received)})"
    return f"{head}: {status.message}" if status.message else head


def no_diagnostics_text(snapshot: Snapshot) -> str:
    """Return why the robot reports no status of its parts; call it only while that is so."""
    topic = snapshot.file.diagnostics
    named = "the robot file names no diagnostics"
    return no_message_reason(snapshot, topic) if topic else named
