"""Streams of events, of the state, and of a goal, for as long as the client is there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

from archo_tui.robot.requester import Requester
from archo_tui.station.station import Station
from archo_tui.verbs.as_data import event, goal, state

PERIOD = 0.2  # Seconds between two looks: five a second, as on the screen.


async def follow(station: Station, tell: Callable[[dict[str, Any]], None], number: Any) -> NoReturn:
    """Send each event, and the state when it has changed, until the task is cancelled.

    Args:
        station: The station that is followed.
        tell: Sends a message to the client.
        number: The `id` of its request.
    """
    seen = {event.number: event.count for event in station.robot.snapshot.events}
    line = ""
    while True:
        for found in station.robot.snapshot.events:
            if seen.get(found.number) != found.count:
                tell({"id": number, "event": event(found)})
        seen = {found.number: found.count for found in station.robot.snapshot.events}
        told = state(station)
        if told["line"] != line:
            line = told["line"]
            tell({"id": number, "state": told})
        await station.clock.sleep(PERIOD)


async def follow_goal(
    station: Station, requester: Requester, tell: Callable[[dict[str, Any]], None], number: Any
) -> NoReturn:
    """Send the state of the goal that is driven for `requester` whenever it has changed.

    Args:
        station: The station that drives it.
        requester: The client that waits for its goals.
        tell: Sends a message to that client.
        number: The `id` of its request.
    """
    shown = None
    while True:
        found = station.goals.goal_of(requester)
        if found is not None and found != shown:
            shown = found
            tell({"id": number, "goal": goal(found, station.clock.monotonic())})
        await station.clock.sleep(PERIOD)
