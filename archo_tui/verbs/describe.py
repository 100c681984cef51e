"""The proposal of a robot file from what is on the graph now."""

from __future__ import annotations

import time

from archo_tui.robot.sightings import take_sightings
from archo_tui.robot_file.proposal import propose
from archo_tui.robot_file.proposal_text import text_of
from archo_tui.station.station import Station

LISTENING = 5.0  # Seconds: enough for two messages of a battery that is published every 2 s.


async def robot_file_text(station: Station) -> str:
    """Listen for a while, and return the text of a robot file for what is on the graph.

    Args:
        station: Its robot runs, and knows the graph.

    Raises:
        SeveralRobots: The namespace holds more than one robot.
        TimeoutError: The ROS thread does not answer.
    """
    seen = await take_sightings(station.robot, LISTENING)
    view = station.view
    proposal = propose(seen, view.namespace)
    day = time.strftime("%Y-%m-%d", time.localtime(station.clock.now()))
    namespace = "" if proposal.namespace == "/" else f" --namespace {proposal.namespace}"
    attach = " --engine ros2 --attach" if station.attached else ""
    head = (
        f"Written by archo-tui from what was on the graph, {view.engine}, {day}.\n"
        "Check every line: nothing here was tried. docs/own_robot.md explains the words.\n"
        f"archo-tui{attach}{namespace} --robot THIS_FILE"
    )
    return text_of(proposal, head)
