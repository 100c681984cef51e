"""The verb for a recording by hand."""

from __future__ import annotations

import asyncio

from archo_tui.recordings.recorder import BEGUN, SECONDS_AFTER
from archo_tui.recordings.ring import SPAN
from archo_tui.robot.outcome import Outcome, Report
from archo_tui.station.station import Station
from archo_tui.verbs.base import Values, Verb


class Keep(Verb):
    """The verb `keep`: record the last minute and the next seconds, and wait for the disk."""

    id, title, tells = "keep", "Keep the last minute", True
    survives_stop = True  # A STOP is what it may record.
    help = f"Keep the last minute: record the last {SPAN:g} s and the next {SECONDS_AFTER:g} s"
    started_text = BEGUN

    async def run(self, station: Station, values: Values) -> Outcome:
        written: asyncio.Future[Outcome] = asyncio.get_running_loop().create_future()

        def on_disk(outcome: Outcome) -> None:
            if not written.done():  # Unless the caller has given up.
                written.set_result(outcome)

        begun = station.recorder.keep(on_disk)
        outcome = await written if begun.ok else begun
        data = {"recording": station.recorder.kept}
        return Report.of(outcome.text, data) if outcome.ok else outcome
