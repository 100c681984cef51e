"""The verb for what the robot reports of its parts."""

from __future__ import annotations

from archo_tui.errors import ArchoError
from archo_tui.robot.outcome import WATCHING, Code, Outcome, Report
from archo_tui.robot.state.readings import GONE, Diagnostic
from archo_tui.station.conditions import diagnostics_worst_first
from archo_tui.station.station import Station
from archo_tui.verbs.base import Argument, Values, Verb
from archo_tui.words.diagnostics import diagnostic_line, no_diagnostics_text


class ShowDiagnostics(Verb):
    """The verb `diagnostics`: list what the robot reports of its parts, the worst first."""

    id, title, tells = "diagnostics", "Diagnostics", True
    help = "List the diagnostics: what the robot reports of its parts, the worst first"

    def is_ready(self, station: Station, values: Values) -> bool:
        snapshot = station.robot.snapshot
        return bool(snapshot.diagnostics) or not snapshot.file.diagnostics

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        found = diagnostics_worst_first(snapshot, now)
        lines = [diagnostic_line(status, now) for status in found]
        data = [
            {
                "name": status.name,
                "hardware_id": status.hardware_id,
                "level": status.level.value,
                "message": status.message,
                "age": now - status.received,  # In s.
            }
            for status in found
        ]
        return Report.of("\n".join(lines) or no_diagnostics_text(snapshot), data)


class ForgetPart(Verb):
    """The verb `forget`: drop a part that has been silent for GONE seconds."""

    id, title, tells = "forget", "Forget a part", True
    acts = True
    help = f"Forget a part of the diagnostics that has reported nothing for {GONE:g} s"
    arguments = (Argument("part", rest=True),)

    def disabled_reason(self, station: Station) -> str:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        if any(status.is_gone_at(now) for status in snapshot.diagnostics):
            return ""
        return f"no part has been silent for {GONE:g} s"

    async def run(self, station: Station, values: Values) -> Outcome:
        return forget(station, _find(station, values["part"]))


def forget(station: Station, part: Diagnostic) -> Outcome:
    """Forget a part, unless it reported in the last GONE seconds or the console only watches."""
    if station.robot.watching:
        return Outcome(Code.WATCHING, WATCHING)
    if not part.is_gone_at(station.clock.monotonic()):
        text = f"{part.part}: only a part that has been silent for {GONE:g} s can be forgotten"
        return Outcome(Code.REFUSED, text)
    station.robot.forget_diagnostic(part)
    return Outcome(Code.DONE, f"{part.part} was forgotten")


def _find(station: Station, name: str) -> Diagnostic:
    """Return the only part with a name, with or without its hardware id; raise ArchoError."""
    parts = station.robot.snapshot.diagnostics
    fitting = [status for status in parts if status.part == name]
    fitting = fitting or [status for status in parts if status.name == name]
    if len(fitting) == 1:
        return fitting[0]
    names = ", ".join(status.part for status in fitting or parts)
    if fitting:
        raise ArchoError(f"several parts are called {name!r}: {names}")
    raise ArchoError(f"no part is called {name!r}; there is: {names}")
