"""The verb that looks for a robot in other ROS 2 domains."""

from __future__ import annotations

from archo_tui.domain_scan import DOMAINS, ScanError, find_nodes
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.safe_text import harmless
from archo_tui.station.station import Station
from archo_tui.verbs.base import Values, Verb
from archo_tui.words.domains import domains_text


class Look(Verb):
    """The verb `look`: list the nodes in other ROS 2 domains, by a process of its own."""

    id, title, tells = "look", "Look", True
    help = f"Look for nodes in the ROS 2 domains {DOMAINS[0]} to {DOMAINS[-1]}"
    started_text = f"looking for nodes in the domains {DOMAINS[0]} to {DOMAINS[-1]} ..."

    def disabled_reason(self, station: Station) -> str:
        return "" if station.attached else "only a console with --attach has other domains"

    async def run(self, station: Station, values: Values) -> Outcome:
        try:
            found = await find_nodes()
        except ScanError as error:
            return Outcome(Code.TIMEOUT, str(error))
        text = domains_text(found, DOMAINS[0], DOMAINS[-1])
        return Outcome(Code.DONE, "\n".join(map(harmless, text.splitlines())))
