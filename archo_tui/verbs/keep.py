"""The black box, by hand."""

from __future__ import annotations

from archo_tui.recording.box import AFTER
from archo_tui.recording.ring import SPAN
from archo_tui.robot.outcome import Outcome
from archo_tui.station.station import Station
from archo_tui.verbs.base import Values, Verb


class Keep(Verb):
    id, title, tells = "keep", "Keep the last minute", True
    survives_stop = True  # it records just that
    help = f"Keep the last minute: record the last {SPAN:g} s and the next {AFTER:g} s"

    async def run(self, station: Station, values: Values) -> Outcome:
        return station.recorder.keep()
