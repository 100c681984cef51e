"""The texts of what the robot reports of its parts. Pure functions."""

from __future__ import annotations

from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.text.state import age_text

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
    if not topic:
        return "the robot file names no diagnostics"
    if topic in snapshot.faults:
        return snapshot.faults[topic]
    return f"waiting for {topic}" if topic in snapshot.offered else f"no node publishes {topic}"
