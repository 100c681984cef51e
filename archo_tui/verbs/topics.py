"""The verbs for what is on the graph: topics, their messages and types, and publishing."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, NoReturn

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.robot.messages.definitions import definition_text, names_in
from archo_tui.robot.messages.text import as_data, as_text
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.frames import faults
from archo_tui.robot.state.graph import TopicInfo
from archo_tui.robot_file.check import not_installed
from archo_tui.robot_file.propose import Sighting, propose, text_of
from archo_tui.ros.names import KINDS, base_name, is_name, package_of, parse_type
from archo_tui.station.station import Station
from archo_tui.text.goal import activity
from archo_tui.text.graph import SILENT, resource_rows, transform_lines
from archo_tui.text.topic import size_text
from archo_tui.verbs.names import fields_of, full_name, topic_names, topics_of, type_of
from archo_tui.verbs.verb import (
    ROBOT_TIMEOUT,
    Argument,
    NotOnGraphError,
    NotPossible,
    Question,
    Values,
    Verb,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from archo_tui.robot.topics.inspect import Inspection

WAIT = 5.0  # Seconds to wait for a message.
LISTEN_TO_FRAMES = 2.0  # Seconds: static transforms come at once.
LISTEN = 5.0  # Seconds in which messages are counted.
FOLLOW = "--follow"
PERIOD = 0.2  # Seconds between two messages that are shown: five a second, as on the screen.
_REFIT = 2.0  # Seconds between two polls of the QoS of the publishers.
_POLL_PERIOD = 0.05  # Seconds between two polls for a message.
RATE, TIMES = "--rate", "--times"
MAX_RATE = 100.0  # Hz
_OWN = ("/rosout", "/parameter_events")  # Of ROS itself.
LISTENING = 5.0  # Seconds: enough for two messages of a battery that is published every 2 s.


class Topics(Verb):
    """The verb `topics`: list topics, services and actions, as the Graph panel does."""

    id, title, tells, lists = "topics", "Topics", True, True
    help = "List topics, services and actions: type, nodes, rate, and who receives nothing"

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
                "expected": station.robot.snapshot.expected_rate(row.resource.name),
                "silent": row.rate == SILENT,
                "mismatches": list(row.resource.mismatches),
            }
            for row in rows
        ]
        lines = [row.as_line for row in rows]
        return Report.of("\n".join(lines) or "nothing on the graph", data)


class _TopicVerb(Verb):
    """The base of the verbs `echo` and `hz`, which subscribe to a topic while they run."""

    tells = True

    async def prepare(self, station: Station, values: Values) -> Values:
        """Complete the topic's name, and load its message class, as `class`."""
        snapshot = station.robot.snapshot
        topics = [*topic_names(station, ())]
        name = full_name(snapshot, values["topic"], topics)
        info = await _topic_info(station, name)
        if not (info.publishers or info.subscriptions):
            raise NotOnGraphError(f"no topic {name} is on the graph{nearest_hint(name, topics)}")
        kinds = sorted({end.type for end in info.publishers or info.subscriptions})
        if len(kinds) > 1:
            raise ArchoError(f"{name} has several types: {', '.join(kinds)}")
        message_class = await in_daemon(load_class, kinds[0])
        if message_class is None:
            raise ArchoError(not_installed(name, kinds[0]))
        return {**values, "topic": name, "class": message_class}

    @asynccontextmanager
    async def inspect(self, station: Station, values: Values) -> AsyncIterator[Inspection]:
        """Subscribe to a topic for the block, and yield the count of its messages; ArchoError."""
        try:
            async with station.robot.inspect(values["topic"], values["class"]) as inspection:
                yield inspection
        except TimeoutError:
            raise ArchoError("the console's own node does not answer") from None


class Echo(_TopicVerb):
    """The verb `echo`: show the next message of a topic, or some of its fields.

    With `--follow` it shows each new message, until it is cancelled. If none comes within WAIT
    seconds, the outcome is TIMEOUT, or NOT_OFFERED without a publisher. A message too large for a
    program is text only.
    """

    id, title = "echo", "Echo"
    help = f"Show the next message of a topic, or fields of it; waits {WAIT:g} s for one"
    arguments = (
        Argument("topic", completer=topic_names),
        Argument("field", many=True, optional=True),
        Argument(FOLLOW),
    )
    is_slow = True
    own_options = (("--once", "print one message; without it each, until ctrl+c"),)

    async def run(self, station: Station, values: Values) -> Outcome:
        async with self.inspect(station, values) as inspection:
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
        send: Callable[[dict[str, Any]], None],
        *,
        for_program: bool,
        has_room: Callable[[], bool],
    ) -> NoReturn:
        """Send each new message of a topic, at most one every PERIOD seconds, until cancelled.

        Messages in between, or while the reader has no room, are left out and counted. `said` tells
        why none has come for WAIT seconds, once for each silence. Raises ArchoError.
        """
        clock, fields = station.clock, values.get("field", ())
        async with self.inspect(station, values) as inspection:
            seen, is_noted = 0, False
            silent_since = clock.monotonic()
            refit_at = silent_since + _REFIT
            while True:
                number, data = inspection.newest
                if number != seen and has_room():
                    message = await in_daemon(_shown, inspection, data, fields, for_program)
                    send({**message, "left_out": number - seen - 1})
                    seen, is_noted, silent_since = number, False, clock.monotonic()
                now = clock.monotonic()
                if not is_noted and number == seen and now - silent_since >= WAIT:
                    is_noted = True
                    why = await _silence_outcome(station, inspection.topic, WAIT)
                    if not seen or why.code == Code.NOT_OFFERED:  # Otherwise it is a rare one.
                        send({"said": why.text})
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
    arguments = (Argument("topic", completer=topic_names),)
    started_text, is_slow = f"listening for {LISTEN:g} s", True

    async def run(self, station: Station, values: Values) -> Outcome:
        async with self.inspect(station, values) as inspection:
            await station.clock.sleep(LISTEN)
            if not inspection.count:
                return await _silence_outcome(station, inspection.topic, LISTEN)
            known = station.robot.snapshot.message_rates.get(inspection.topic)
            hertz = None if known is None else known.hertz_at(station.clock.monotonic())
            text, data = _rate_text(inspection, LISTEN, hertz)
            return Report.of(f"{inspection.topic}: {text}", data)


def _rate_text(
    counted: Inspection, seconds: float, known_rate: float | None
) -> tuple[str, dict[str, Any]]:
    """Return how often messages came and their size: a text, and the same as JSON values."""
    count = counted.count - counted.kept
    bytes_per_second = (counted.size - counted.kept_size) / seconds
    rate = known_rate if counted.rate is None else counted.rate
    data: dict[str, Any] = {
        "messages": count,
        "rate": rate,
        "least": counted.least,
        "greatest": counted.greatest,
        "bytes_per_second": bytes_per_second,
    }
    sizes = f"{size_text(bytes_per_second)}/s"
    if not count:
        return f"no message in {seconds:g} s, but the last one that was sent before", data
    hertz = "--" if rate is None else f"{rate:.1f}"
    if counted.least is None or counted.greatest is None:
        return f"{hertz} Hz, 1 message in {seconds:g} s, {sizes}", data
    between = f"{counted.least:.3f} .. {counted.greatest:.3f} s between them"
    return f"{hertz} Hz, {count} messages in {seconds:g} s, {between}, {sizes}", data


def _last_message(inspection: Inspection, paths: Sequence[str]) -> Outcome:
    """Return an outcome with the last message, or fields of it; slow: not for the UI thread."""
    message = inspection.decode(inspection.newest[1])
    text = as_text(message, paths)
    with suppress(ArchoError):  # It is too large for a program, which gets the text only.
        return Report.of(text, as_data(message, paths))
    return Outcome(Code.DONE, text)


def _shown(
    inspection: Inspection, data: bytes, paths: Sequence[str], for_program: bool
) -> dict[str, Any]:
    """Return a message as `message` or `text`; slow: not for the UI thread."""
    message = inspection.decode(data)
    return (
        {"message": as_data(message, paths)} if for_program else {"text": as_text(message, paths)}
    )


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


class ShowTransforms(Verb):
    """The verb `tf`: listen to /tf and /tf_static, and list the frames and what is wrong."""

    id, title, tells = "tf", "Transforms", True
    help = f"Listen to the transforms for {LISTEN_TO_FRAMES:g} s: parents, age, rate, what is wrong"
    started_text, is_slow = f"listening for {LISTEN_TO_FRAMES:g} s", True

    async def run(self, station: Station, values: Values) -> Outcome:
        async with station.robot.listen_to_frames() as transforms:
            await station.clock.sleep(LISTEN_TO_FRAMES)
            found, now = transforms(), station.clock.monotonic()
        frames = [
            {
                "frame": frame.name,
                "parents": frame.parents_at(now),
                "age": frame.age(now),  # In s.
                "rate": None if frame.is_static else frame.rate.hertz_at(now),
                "static": frame.is_static,
                "publishers": list(found.publishers_of(frame)),
            }
            for frame in sorted(found.frames.values())
        ]
        wrong = [*filter(None, [found.fault, *faults(found, now)])]
        return Report.of(
            "\n".join(transform_lines(found, now)), {"frames": frames, "faults": wrong}
        )


class ShowInterface(Verb):
    """The verb `interface`: show the definition of a type, as `ros2 interface show` does.

    A type without its package is looked for on the graph, any other among those installed.
    """

    id, title, tells = "interface", "Interface", True
    help = "Show the definition of a message, service or action type, with its comments"
    arguments = (Argument("type", completer=lambda station, _: _types_on_graph(station)),)

    async def prepare(self, station: Station, values: Values) -> Values:
        name, text = await in_daemon(_find, values["type"], _types_on_graph(station))
        return {"type": name, "definition": text}

    async def run(self, station: Station, values: Values) -> Outcome:
        return Report.of(values["definition"], dict(values))


def _types_on_graph(station: Station) -> list[str]:
    found = station.robot.snapshot.resources
    return sorted({kind for resource in found for kind in resource.types})


def _find(typed: str, known: list[str]) -> tuple[str, str]:
    """Return the full name and the definition of a typed type; ArchoError unless one fits."""
    meant = _possible_names(typed, known)
    found = {name: text for name in meant if (text := definition_text(name)) is not None}
    if len(found) == 1:
        return next(iter(found.items()))
    if found:
        raise ArchoError(f"{typed} has several meanings: {', '.join(found)}")
    if absent := [name for name in meant if name in known]:
        raise ArchoError(f"{absent[0]} is on the graph, and not installed here")
    package, parts = package_of(typed) if "/" in typed else "", typed.count("/")
    installed = names_in(package) if parse_type(f"{package}/msg/A") else []
    if package and not installed and package not in map(package_of, known):
        near = nearest_hint(package, map(package_of, known))
        raise ArchoError(f"no package of interfaces {package} is installed here{near}")
    names = [*known, *installed]
    if parts < 2:  # With as many parts as were typed.
        names = [f"{package_of(n)}/{base_name(n)}" if parts else base_name(n) for n in names]
    near = nearest_hint(typed, names)
    where = "installed here" if package else "on the graph"
    raise NotOnGraphError(f"no type {typed} is {where}{near}")


def _possible_names(typed: str, known: list[str]) -> list[str]:
    """Return the full names `package/kind/Name` that a type may stand for, existing or not."""
    if "/" not in typed:
        return [name for name in known if base_name(name) == typed]
    if typed.count("/") == 1:
        package, name = typed.split("/")
        return [f"{package}/{kind}/{name}" for kind in KINDS]
    return [typed]


class Publish(Verb):
    """The verb `pub`: publish one message, or many at a rate, to a topic.

    What may move the robot asks first, is refused behind a STOP, and ends at one.
    """

    id, title = "pub", "Publish"
    help = "Publish a message to a topic, once or at a rate; without --times until it is ended"
    arguments = (
        Argument("topic", completer=topic_names),
        Argument("field=value", many=True, optional=True),
        Argument(RATE, takes="HZ"),
        Argument(TIMES, takes="N"),
    )
    acts = may_ask = lasts = is_slow = True
    own_options = (
        ("--rate HZ", "publish again and again, so many times a second"),
        ("--times N", "publish N times, once a second without --rate"),
    )

    def values(self, words: Sequence[str]) -> Values:
        """Return `topic`, `field=value`, and `rate` and `times` as `frequency` does."""
        given = dict(super().values(words))
        if not is_name(given["topic"]):
            raise ValueError(f"{given['topic']!r} is not a name of a topic, such as /cmd_vel")
        rate, times = frequency(given.pop(RATE, None), given.pop(TIMES, None))
        return {**given, "rate": rate, "times": times}

    def is_found(self, station: Station, values: Values) -> bool:
        """Return False while the topic is not on the graph and may still come."""
        if not station.attached or station.age >= ROBOT_TIMEOUT:
            return True
        found = [*topic_names(station, ())]
        return full_name(station.robot.snapshot, values["topic"], found) in found

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot = station.robot.snapshot
        found = {topic.name: topic for topic in topics_of(snapshot)}
        name = full_name(snapshot, values["topic"], found)
        words = list(values["field=value"])
        if words and "=" not in words[0] and parse_type(words[0]) is not None:
            kind = words.pop(0)
            if name in found and kind not in found[name].types:
                raise ValueError(f"{name} is {', '.join(found[name].types)}, not {kind}")
        else:
            kind = type_of("topic", name, {each.name: each.types for each in found.values()})
        if any(part.startswith("_") for part in name.split("/")) or name in _OWN:
            raise ValueError(f"{name} is of ROS or the console itself: nothing is published there")
        fields = values.get("fields")  # Of a form.
        if fields is None:
            fields = await fields_of(station, name, kind, words)
        read = {snapshot.full(topic) for topic in snapshot.file.shown_topics}
        nodes = found[name].nodes if name in found else ()
        if name in read and nodes:
            raise NotPossible(
                f"the console reads {name}, and {', '.join(nodes)} publishes it: "
                "nothing else is to be shown as the robot's words; stop that node first"
            )
        moves = snapshot.moves_by(name)
        if moves and (reason := station.restart_blocker):
            raise NotPossible(reason)
        return {**values, "topic": name, "type": kind, "fields": fields, "moves": moves}

    def question(self, station: Station, values: Values) -> Question | None:
        if not values.get("moves"):
            return None
        often = "once" if values["times"] == 1 else f"at {values['rate']:g} Hz"
        goal = station.running_goal
        now = f"The robot is {activity(goal)}. " if goal is not None else ""
        what = f"{values['topic']} ({values['type']}) {often}"
        text = f"{now}This may move the robot. Publish to {what}?"
        return Question("Publish", text, "No", "Publish", goal)

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.publish(
            *(values["topic"], values["type"], values["fields"]),
            *(values["rate"], values["times"]),
            moves=values["moves"],
        )


def frequency(rate: Any, times: Any) -> tuple[float, int | None]:
    """Return the rate in Hz and how often, None for without end; a given None was left out.

    Without both it is once, with `times` alone once a second; with a rate alone it has no end.

    Raises:
        ValueError: One of both is no such number.
    """
    hertz = None if rate is None else _number(RATE, rate, "a number of Hz")
    count = None if times is None else _number(TIMES, times, "a whole number")
    if hertz is not None and not 0 < hertz <= MAX_RATE:
        raise ValueError(f"{RATE}: more than 0, at most {MAX_RATE:g} Hz, not {hertz:g}")
    if count is not None and (count < 1 or not count.is_integer()):
        raise ValueError(f"{TIMES}: a whole number from 1 on, not {count:g}")
    often = int(count) if count is not None else None if hertz is not None else 1
    return hertz or 1.0, often


def _number(option: str, value: Any, what: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{option} needs {what}, not {value!r}") from None


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
