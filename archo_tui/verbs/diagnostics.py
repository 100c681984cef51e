"""The verb for what the robot reports of its parts."""

from __future__ import annotations

from typing import Any

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.station.alarm_conditions import diagnostics_worst_first
from archo_tui.station.station import Station
from archo_tui.verbs.base import Values, Verb
from archo_tui.words.diagnostics import diagnostic_line, no_diagnostics_text


class ShowDiagnostics(Verb):
    """The verb `diagnostics`: list what the robot reports of its parts, the worst first.

    If nothing was reported, the text says why.
    """

    id, title, tells = "diagnostics", "Diagnostics", True
    help = "List the diagnostics: what the robot reports of its parts, the worst first"

    def is_ready(self, station: Station, values: Values) -> bool:
        snapshot = station.robot.snapshot
        return bool(snapshot.diagnostics) or not snapshot.file.diagnostics

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        lines = [diagnostic_line(status, now) for status in diagnostics_worst_first(snapshot, now)]
        return Outcome(Code.DONE, "\n".join(lines) or no_diagnostics_text(snapshot))

    def data(self, station: Station, values: Values) -> Any:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        return [
            {
                "name": status.name,
                "hardware_id": status.hardware_id,
                "level": status.level.value,
                "message": status.message,
                "age": now - status.received,  # In s.
            }
            for status in diagnostics_worst_first(snapshot, now)
        ]
