"""The verbs for the messages of one topic: the last message, and their rate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.nearest import nearest_hint
from archo_tui.robot.messages.text import as_data, as_text
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.graph import TOPIC, TopicInfo
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.check import not_installed
from archo_tui.station.station import Station
from archo_tui.verbs.base import DISCOVERY_TIME, Argument, Values, Verb
from archo_tui.verbs.graph_names import full_name
from archo_tui.words.inspect import rate_text

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from archo_tui.robot.topics.inspect import Inspection

WAIT = 5.0  # Seconds to wait for a message.
LISTEN = 5.0  # Seconds in which messages are counted.
FOLLOW = "--follow"
PERIOD = 0.2  # Seconds between two messages that are shown: five a second, as on the screen.
_REFIT = 2.0  # Seconds between two polls of the QoS of the publishers.
_POLL_PERIOD = 0.05  # Seconds between two polls for a message.


class FollowedMessage(NamedTuple):
    """A message of a topic that is followed."""

    text: str  # As YAML; "" for a program.
    data: Any  # As JSON has it; None for a person.
    left_out: int  # Messages before it that were not shown.


class _TopicVerb(Verb):
    """The base of the verbs `echo` and `hz`, which subscribe to a topic while they run."""

    tells = True

    def is_ready(self, station: Station, values: Values) -> bool:
        """Return True if the topic was found, or DISCOVERY_TIME seconds after the last start.

        That is the start of the console, or of a node here.
        """
        snapshot = station.robot.snapshot
        found = _topics(snapshot)
        return full_name(snapshot, values["topic"], found) in found or station.age >= DISCOVERY_TIME

    @asynccontextmanager
    async def inspect(self, station: Station, topic: str) -> AsyncIterator[Inspection]:
        """Subscribe to a topic inside the block, whose value counts the messages; or ArchoError."""
        snapshot = station.robot.snapshot
        name = full_name(snapshot, topic, _topics(snapshot))
        info = await _topic_info(station, name)
        if not (info.publishers or info.subscriptions):
            near = nearest_hint(name, _topics(snapshot))
            raise ArchoError(f"no topic {name} is on the graph{near}")
        kinds = sorted({end.type for end in info.publishers or info.subscriptions})
        if len(kinds) > 1:
            raise ArchoError(f"{name} has several types: {', '.join(kinds)}")
        message_class = await in_daemon(load_class, kinds[0])
        if message_class is None:
            raise ArchoError(not_installed(name, kinds[0]))
        try:
            async with station.robot.inspect(name, message_class) as inspection:
                yield inspection
        except TimeoutError:
            raise ArchoError("the console's own node does not answer") from None


class Echo(_TopicVerb):
    """The verb `echo`: show the last message of a topic, or some of its fields.

    With `--follow` it shows each new message, until it is cancelled. If none comes within WAIT
    seconds, the outcome is TIMEOUT, or NOT_OFFERED without a publisher. A message too large for a
    program is text only.
    """

    id, title = "echo", "Echo"
    help = f"Show the last message of a topic, or fields of it; waits {WAIT:g} s for one"
    arguments = (Argument("topic"), Argument("field", many=True, optional=True), Argument(FOLLOW))

    async def run(self, station: Station, values: Values) -> Outcome:
        async with self.inspect(station, values["topic"]) as inspection:
            end = station.clock.monotonic() + WAIT
            while not inspection.count and station.clock.monotonic() < end:
                await station.clock.sleep(_POLL_PERIOD)
            if not inspection.count:
                return await _silence_outcome(station, inspection.topic, WAIT)
            return await in_daemon(_last_message, inspection, values.get("field", ()))

    async def follow(
        self,
        station: Station,
        values: Values,
        show: Callable[[FollowedMessage], None],
        note: Callable[[str], None],
        *,
        for_program: bool,
        has_room: Callable[[], bool],
    ) -> NoReturn:
        """Show each new message of a topic, at most one every PERIOD seconds, until cancelled.

        Messages in between, or while the reader has no room, are left out and counted. `note` gets
        the reason why none has come for WAIT seconds, once for each silence. Raises ArchoError.
        """
        clock, fields = station.clock, values.get("field", ())
        async with self.inspect(station, values["topic"]) as inspection:
            seen, is_noted = 0, False
            silent_since = clock.monotonic()
            refit_at = silent_since + _REFIT
            while True:
                number, data = inspection.newest
                if number != seen and has_room():
                    text, json_data = await in_daemon(
                        _text_or_data, inspection, data, fields, for_program
                    )
                    show(FollowedMessage(text, json_data, number - seen - 1))
                    seen, is_noted, silent_since = number, False, clock.monotonic()
                now = clock.monotonic()
                if not is_noted and number == seen and now - silent_since >= WAIT:
                    is_noted = True
                    why = await _silence_outcome(station, inspection.topic, WAIT)
                    if not seen or why.code == Code.NOT_OFFERED:  # Otherwise it is a rare one.
                        note(why.text)
                if now >= refit_at:
                    station.robot.resubscribe_if_needed(inspection)
                    refit_at = now + _REFIT
                await clock.sleep(PERIOD)


class Hz(_TopicVerb):
    """The verb `hz`: listen to a topic for LISTEN seconds, and tell rate, intervals and bytes/s.

    If no message comes, the outcome is TIMEOUT, or NOT_OFFERED without a publisher.
    """

    id, title = "hz", "Rate"
    help = f"Listen to a topic for {LISTEN:g} s: rate, shortest and longest interval, bytes/s"
    arguments = (Argument("topic"),)
    started_text = f"listening for {LISTEN:g} s"

    async def run(self, station: Station, values: Values) -> Outcome:
        async with self.inspect(station, values["topic"]) as inspection:
            await station.clock.sleep(LISTEN)
            if not inspection.count:
                return await _silence_outcome(station, inspection.topic, LISTEN)
            known = station.robot.snapshot.message_rates.get(inspection.topic)
            hertz = None if known is None else known.hertz_at(station.clock.monotonic())
            text, data = rate_text(inspection, LISTEN, hertz)
            return Report.of(f"{inspection.topic}: {text}", data)


def _last_message(inspection: Inspection, paths: Sequence[str]) -> Outcome:
    """Return an outcome with the last message, or fields of it; slow: not for the UI thread."""
    message = inspection.decode(inspection.newest[1])
    text = as_text(message, paths)
    with suppress(ArchoError):  # It is too large for a program, which gets the text only.
        return Report.of(text, as_data(message, paths))
    return Outcome(Code.DONE, text)


def _text_or_data(
    inspection: Inspection, data: bytes, paths: Sequence[str], for_program: bool
) -> tuple[str, Any]:
    """Return a message as text and None, or as "" and data; slow: not for the UI thread."""
    message = inspection.decode(data)
    if for_program:
        return "", as_data(message, paths)
    return as_text(message, paths), None


def _topics(snapshot: Snapshot) -> list[str]:
    return [resource.name for resource in snapshot.resources if resource.kind == TOPIC]


async def _topic_info(station: Station, topic: str) -> TopicInfo:
    info = await station.robot.topic_info(topic)
    if isinstance(info, Outcome):
        raise ArchoError(info.text)
    return info


async def _silence_outcome(station: Station, topic: str, seconds: float) -> Outcome:
    """Return NOT_OFFERED for a topic without a publisher, else TIMEOUT, with the reason."""
    info = await _topic_info(station, topic)
    nodes = {end.node.lstrip("/") for end in info.publishers if "/_" not in end.node}
    names = ", ".join(sorted(nodes))
    text = f"no message on {topic} in {seconds:g} s"
    if not info.publishers:
        return Outcome(Code.NOT_OFFERED, f"{text}: it has no publisher")
    return Outcome(Code.TIMEOUT, f"{text}: nothing arrived from {names or 'its publisher'}")
