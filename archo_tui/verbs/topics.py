"""The verb for what is on the graph: topics, services and actions."""

from __future__ import annotations

from archo_tui.robot.outcome import Outcome, Report
from archo_tui.station.station import Station
from archo_tui.verbs.base import Values, Verb
from archo_tui.words.graph import SILENT, resource_rows


class Topics(Verb):
    """The verb `topics`: list topics, services and actions, as the Graph panel does."""

    id, title, tells = "topics", "Topics", True
    help = "List topics, services and actions: type, nodes, rate, and who receives nothing"

    def is_ready(self, station: Station, values: Values) -> bool:
        return bool(station.robot.snapshot.resources)

    async def run(self, station: Station, values: Values) -> Outcome:
        station.refresh()
        rows, rates = resource_rows(station.view), station.robot.snapshot.message_rates
        data = [
            {
                "kind": row.resource.kind,
                "name": row.resource.name,
                "types": list(row.resource.types),
                "nodes": list(row.resource.nodes),
                "rate": None if row.rate in ("", SILENT) else rates[row.resource.name].hertz,
                "silent": row.rate == SILENT,
                "mismatches": list(row.resource.mismatches),
            }
            for row in rows
        ]
        lines = [row.as_line for row in rows]
        return Report.of("\n".join(lines) or "nothing on the graph", data)
