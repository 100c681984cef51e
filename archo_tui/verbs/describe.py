"""The proposal of a robot file from what is on the graph now."""

from __future__ import annotations

import time
from collections.abc import Sequence

from archo_tui.daemon_threads import in_daemon
from archo_tui.robot_file.propose import Sighting, propose, text_of
from archo_tui.station.station import Station

LISTENING = 5.0  # Seconds: enough for two messages of a battery that is published every 2 s.


async def robot_file_text(station: Station) -> str:
    """Listen for LISTENING seconds, and return the text of a robot file for what is on the graph.

    Nothing of it is tried on the robot. Raises SeveralRobots, or TimeoutError if ROS does not
    answer.
    """
    seen = await station.robot.take_sightings(LISTENING)
    view = station.view
    attach = " --engine ros2 --attach" if station.attached else ""
    # The more names are on the graph, the longer this takes.
    return await in_daemon(
        _file_text, seen, view.namespace, view.engine, station.clock.now(), attach
    )


def _file_text(
    seen: Sequence[Sighting], namespace: str, engine: str, now: float, attach: str
) -> str:
    proposal = propose(seen, namespace)
    day = time.strftime("%Y-%m-%d", time.localtime(now))
    option = "" if proposal.namespace == "/" else f" --namespace {proposal.namespace}"
    head = (
        f"Written by archo-tui from what was on the graph, {engine}, {day}.\n"
        "Check every line: nothing here was tried. docs/own_robot.md explains the words.\n"
        f"archo-tui{attach}{option} --robot THIS_FILE"
    )
    return text_of(proposal, head)
