"""The view of the graph from which a robot file is proposed: types, fields, rates, messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AsyncExitStack
from dataclasses import replace
from typing import Any

from archo_tui.clock import Clock
from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.robot.client import Robot
from archo_tui.robot.messages.text import flat_fields
from archo_tui.robot.messages.types import field_types, load_class
from archo_tui.robot.state import TOPIC, Resource
from archo_tui.robot.topics.inspect import Inspection
from archo_tui.robot_file.known_types import READ
from archo_tui.robot_file.sighting import Sighting


async def take_sightings(robot: Robot, clock: Clock, seconds: float) -> tuple[Sighting, ...]:
    """Return what is on the graph, after listening to the topics that a robot file can use.

    For `seconds` the console subscribes to each published topic of such a type, if it is installed.

    Raises:
        TimeoutError: The ROS thread does not answer.
    """
    topics = [found for found in robot.snapshot.resources if found.kind == TOPIC]
    named = {
        found.name: kind for found in topics for kind in found.types if kind in READ and found.nodes
    }
    classes = {name: await in_daemon(load_class, kind) for name, kind in named.items()}
    installed = {name: found for name, found in classes.items() if found is not None}
    async with AsyncExitStack() as stack:
        inspections = {
            name: await stack.enter_async_context(robot.inspect(name, found))
            for name, found in installed.items()
        }
        await clock.sleep(seconds)
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
    if kind != TOPIC:
        goal, feedback, result = _field_types(found.types[0])
        return Sighting(
            *(kind, found.name, found.types, found.nodes),
            goal=goal,
            feedback=feedback,
            result=result,
        )
    seen = Sighting(kind, found.name, found.types, found.nodes)
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


def _field_types(type_name: str) -> tuple[_Types | None, _Types, _Types]:
    """Return the types of the fields of a goal or request, a feedback and a result, by path.

    The first is None if the type is not installed; of a service the others are empty.
    """
    interface = load_class(type_name)
    if interface is None:
        return None, {}, {}
    if hasattr(interface, "Request"):
        return field_types(interface.Request()), {}, {}
    goal, feedback, result = interface.Goal(), interface.Feedback(), interface.Result()
    return field_types(goal), field_types(feedback), field_types(result)
