"""Streams of events, of the state, of a goal and of a topic, for as long as the client waits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

from archo_tui.robot.clients.requester import Requester
from archo_tui.station.station import Station
from archo_tui.verbs.as_json import event, goal, state
from archo_tui.verbs.topics import Echo, FollowedMessage
from archo_tui.verbs.verb import Values

Send = Callable[[dict[str, Any]], None]
PERIOD = 0.2  # Seconds between two polls: five a second, as on the screen.


async def follow_events(station: Station, send: Send, number: Any) -> NoReturn:
    """Send each event from now on, and the state when its line changes, until cancelled.

    An event that repeats is sent again.
    """
    seen = {event.number: event.count for event in station.robot.snapshot.events}
    line = ""
    while True:
        events = station.robot.snapshot.events
        for new in events:
            if seen.get(new.number) != new.count:
                send({"id": number, "event": event(new)})
        seen = {event.number: event.count for event in events}
        current = state(station)
        if current["line"] != line:
            line = current["line"]
            send({"id": number, "state": current})
        await station.clock.sleep(PERIOD)


async def follow_goal(station: Station, requester: Requester, send: Send, number: Any) -> NoReturn:
    """Send the state of a goal of `requester` when it changes, but not its end, until cancelled."""
    last = None
    while True:
        current = station.goals.goal_of(requester)
        if current is not None and current != last:
            last = current
            send({"id": number, "goal": goal(current, station.clock.monotonic())})
        await station.clock.sleep(PERIOD)


async def follow_topic(
    station: Station,
    verb: Echo,
    values: Values,
    send: Send,
    number: Any,
    *,
    as_text: bool,
    has_room: Callable[[], bool],
) -> NoReturn:
    """Send each message of a topic until cancelled.

    Messages are left out beyond five a second, and while the client has no room for them.
    """

    def show(shown: FollowedMessage) -> None:
        message = {"text": shown.text} if as_text else {"message": shown.data}
        send({"id": number, **message, "left_out": shown.left_out})

    await verb.follow(
        station,
        values,
        show,
        lambda why: send({"id": number, "said": why}),
        for_program=not as_text,
        has_room=has_room,
    )
