"""The requests to look into topics: count messages, show one, and propose a robot file."""

from __future__ import annotations

import contextlib
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack
from dataclasses import replace
from typing import Any, NoReturn

from archo_tui.base.clock import Clock
from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError, in_one_line
from archo_tui.robot.messages.text import flat_fields
from archo_tui.robot.messages.types import TypedField, field_types, load_class
from archo_tui.robot.node import QUESTION_TIMEOUT
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.nodes import topic_info
from archo_tui.robot.state.frames import Transforms
from archo_tui.robot.state.graph import TOPIC, Resource, TopicInfo
from archo_tui.robot.topics.frames import TF_MESSAGE
from archo_tui.robot.topics.inspect import (
    PERIOD,
    SHARE,
    Inspection,
    MessageIntake,
    TopicWatch,
    missing_type,
    publisher_fault,
    types_of,
)
from archo_tui.robot.topics.rows import TopicRequest, TopicView
from archo_tui.robot_file.model import field_units
from archo_tui.robot_file.propose import READ, Sighting

_REFIT = 2.0  # Seconds between two looks at the publishers.
_LONG = 0.05  # Seconds of decoding after which only the newest message is decoded the next time.
_NO_ANSWER = "the console's own node does not answer"


def form(_robot: Parts, type_name: str) -> tuple[TypedField, ...] | None:
    """Return the fields of a message, goal or request, with defaults; None if not installed."""
    found = load_class(type_name)
    if found is None:
        return None
    if "/msg/" in type_name:
        return tuple(flat_fields(found()))
    return tuple(flat_fields(found.Goal() if "/action/" in type_name else found.Request()))


@contextlib.asynccontextmanager
async def inspect(
    robot: Parts,
    topic: str,
    message_class: Any,
    on_data: Callable[[float, bytes, bool], None] = lambda *_: None,
) -> AsyncIterator[Inspection]:
    """Count the messages of a topic while the context is entered; its value is the inspection.

    `on_data` gets, on the ROS thread, monotonic time, bytes, and True for a message from
    before. Raises TimeoutError, or ArchoError if rclpy refuses the subscription.
    """
    inspection = Inspection(robot.node, robot.clock, topic, message_class, on_data)

    async def begin() -> None:
        try:
            inspection.subscribe()
        except Exception as error:
            raise ArchoError(f"{topic}: no subscription: {in_one_line(error)}") from None

    try:
        await robot.thread.run(begin, QUESTION_TIMEOUT)
        yield inspection
    finally:
        robot.thread.submit(inspection.unsubscribe)  # Runs after `begin`, however late that is.


@contextlib.asynccontextmanager
async def listen_to_frames(robot: Parts) -> AsyncIterator[Callable[[], Transforms]]:
    """Receive /tf and /tf_static while the context is entered; its value returns what came."""
    await in_daemon(load_class, TF_MESSAGE)  # The ROS thread finds it loaded.
    try:
        robot.thread.submit(robot.frames.begin)
        yield lambda: robot.frames.transforms
    finally:
        robot.thread.submit(robot.frames.end)


def resubscribe_if_needed(robot: Parts, inspection: Inspection) -> None:
    """Have an inspection subscribe again if its QoS no longer fits the publishers. Any thread."""
    robot.thread.submit(inspection.resubscribe_if_needed)


async def follow_topic(
    robot: Parts,
    topic: str,
    request: Callable[[], TopicRequest],
    show: Callable[[TopicView], None],
) -> NoReturn:
    """Show a topic, up to five views a second, until the task is cancelled."""
    while True:
        ends, view = await topic_info(robot, topic), TopicView(topic)
        if isinstance(ends, Outcome):
            view = view._replace(fault=ends.text)
        elif kinds := types_of(ends):
            view = view._replace(type=kinds[0], ends=ends)
            found = await in_daemon(load_class, kinds[0])
            if found is not None:
                view = await _follow_type(robot, view, found, request, show)
            else:
                view = view._replace(fault=missing_type(topic, kinds[0]))
        else:
            view = view._replace(ends=ends, fault="it is not on the graph: waiting for it")
        show(view)
        await robot.clock.sleep(_REFIT)


async def _follow_type(
    robot: Parts,
    begun: TopicView,
    message_class: Any,
    request: Callable[[], TopicRequest],
    show: Callable[[TopicView], None],
) -> TopicView:
    """Show messages of a type until only others are published; return the view to show then."""
    topic, kind, ends, clock = begun.topic, begun.type, begun.ends or TopicInfo(), robot.clock
    snapshot, intake = robot.snapshot, MessageIntake()
    units = field_units(snapshot.file, snapshot.full, topic, kind)
    try:
        async with inspect(robot, topic, message_class, intake.add) as inspection:
            watch = TopicWatch(topic, kind, units, intake, inspection.decode)
            refit_at, spent = clock.monotonic() + _REFIT, 0.0
            while True:
                view, spent = await in_daemon(_update, watch, clock, request(), spent)
                known = robot.snapshot.message_rates.get(topic)
                if view.rate is None and known is not None:
                    view = view._replace(rate=known.hertz_at(clock.monotonic()))
                fault = view.fault or publisher_fault(ends, kind)
                show(view._replace(ends=ends, fault=fault))
                await clock.sleep(max(PERIOD, spent / SHARE))
                if clock.monotonic() < refit_at:
                    continue
                refit_at = clock.monotonic() + _REFIT
                resubscribe_if_needed(robot, inspection)
                asked = await topic_info(robot, topic)
                ends = ends if isinstance(asked, Outcome) else asked
                if types_of(ends) and kind not in types_of(ends):
                    return TopicView(topic, ends=ends, fault="its type has changed")
    except TimeoutError:
        return TopicView(topic, kind, ends=ends, fault=_NO_ANSWER)
    except ArchoError as error:
        return TopicView(topic, kind, ends=ends, fault=str(error))


def _update(
    watch: TopicWatch, clock: Clock, request: TopicRequest, spent: float
) -> tuple[TopicView, float]:
    """Return the new view, and the processor time in seconds that it took, as `spent` the last."""
    begun = time.thread_time()
    view = watch.update(clock.monotonic(), request, only_newest=spent > _LONG)
    return view, time.thread_time() - begun


async def take_sightings(robot: Parts, seconds: float) -> tuple[Sighting, ...]:
    """Return what is on the graph, after listening for `seconds` to what a robot file can use."""
    topics = [found for found in robot.snapshot.resources if found.kind == TOPIC]
    named = {
        found.name: kind for found in topics for kind in found.types if kind in READ and found.nodes
    }
    classes = {name: await in_daemon(load_class, kind) for name, kind in named.items()}
    installed = {name: found for name, found in classes.items() if found is not None}
    async with AsyncExitStack() as stack:
        inspections = {
            name: await stack.enter_async_context(inspect(robot, name, found))
            for name, found in installed.items()
        }
        await robot.clock.sleep(seconds)
    snapshot = robot.snapshot
    lifecycles = {node.name: node.lifecycle for node in snapshot.nodes if node.lifecycle}
    return await in_daemon(_sightings, snapshot.resources, inspections, lifecycles)


def _sightings(
    resources: Sequence[Resource],
    inspections: Mapping[str, Inspection],
    lifecycles: Mapping[str, str],
) -> tuple[Sighting, ...]:
    return tuple(
        replace(_sighting(found, inspections.get(found.name)), lifecycles=lifecycles)
        for found in resources
    )


def _sighting(found: Resource, inspection: Inspection | None) -> Sighting:
    kind: Any = found.kind
    seen = Sighting(kind, found.name, found.types, found.nodes)
    if kind != TOPIC:
        goal, feedback, result = _types_of(found.types[0])
        return replace(seen, goal=goal, feedback=feedback, result=result)
    if inspection is None:
        return replace(seen, was_listened_to=False)
    if not inspection.count:
        return seen
    try:
        message = inspection.decode(inspection.newest[1])
    except ArchoError:  # Its publisher has another definition of the type.
        return seen
    values = {field.path: field.default for field in flat_fields(message)}
    return replace(seen, rate=inspection.rate, values=values)


_Types = Mapping[str, str]  # By dotted path.


def _types_of(type_name: str) -> tuple[_Types | None, _Types, _Types]:
    """Return the types in a goal or request (None if not installed), a feedback and a result."""
    interface = load_class(type_name)
    if interface is None:
        return None, {}, {}
    if hasattr(interface, "Request"):
        return field_types(interface.Request()), {}, {}
    goal, feedback, result = interface.Goal(), interface.Feedback(), interface.Result()
    return field_types(goal), field_types(feedback), field_types(result)
