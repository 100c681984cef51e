"""The requests about a node: its parameters, its log level, its lifecycle, and what it has."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # It has no public name.
from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)

from archo_tui.base.errors import in_one_line
from archo_tui.robot.graph import endpoints
from archo_tui.robot.graph.graph import SEND, is_hidden, is_of_every_node
from archo_tui.robot.graph.lifecycle import CHANGE_TIMEOUT
from archo_tui.robot.graph.parameter_values import is_secret, masked
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.node import DEADLINE, QUESTION_TIMEOUT
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.commands import late_report, run
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.graph import LEVELS, LogLevel, Names, NodeInfo, TopicInfo
from archo_tui.robot.stop.gate import Gate

T = TypeVar("T")

_TOPICS = ("/rosout", "/parameter_events")  # Every node has them.
_GET, _SET = "get_logger_levels", "set_logger_levels"
_LEVEL_NAMES = {number: name for name, number in LEVELS.items()}
_NO_LEVELS = "does not offer the level of its log (in rclpy: enable_logger_service=True)"
_SILENT = f"no answer in {DEADLINE:g} s"


async def _ask(robot: Parts, work: Callable[[], Coroutine[Any, Any, T]]) -> T | Outcome:
    """Run a question on the ROS thread; return its answer, or why there is none."""
    try:
        return await robot.thread.run(work, QUESTION_TIMEOUT)
    except TimeoutError:
        text = f"no answer in {QUESTION_TIMEOUT:g} s from the console's own node"
        return Outcome(Code.TIMEOUT, text)
    except Exception as error:  # rclpy raises a dozen types, as for names that DDS allows.
        return Outcome(Code.REFUSED, in_one_line(error))


async def set_parameters(robot: Parts, node: str, values: Mapping[str, Any]) -> Outcome:
    """Set parameters of a node, all of them or none, and report it without secrets."""
    shown = masked(values)
    command = "" if any(map(is_secret, values)) else ros2_command.set_parameters(node, values)
    return await run(
        *(robot, "set", {"node": node, "values": shown}),
        *(f"set {node.lstrip('/')} {_texts(shown)}", command),
        lambda gate: robot.parameters.set(node, values, gate),
    )


def _texts(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {text_of(value)}" for name, value in values.items())


def on_parameters_restored(robot: Parts, node: str, values: Mapping[str, Any]) -> None:
    """Report that a hosted node was restarted, and given these parameters. Any thread."""
    shown = masked(values)
    text = f"set {node.lstrip('/')} {_texts(shown)} again: it was restarted"
    record = AuditRecord("set", {"node": node, "values": shown}, Code.DONE)
    robot.thread.submit(lambda: robot.reporter.report_done(text, record))


# What is there.


async def describe(robot: Parts, node: str) -> NodeInfo | Outcome:
    """Ask for what a node publishes, serves and uses, its log level and its transitions."""

    async def there() -> NodeInfo | Outcome:
        namespace, _, base = node.rpartition("/")
        where, us = (base, namespace or "/"), robot.node
        try:
            found = NodeInfo(
                publishes=_topics(us.get_publisher_names_and_types_by_node(*where)),
                subscribes=_topics(us.get_subscriber_names_and_types_by_node(*where)),
                serves=_services(us.get_service_names_and_types_by_node(*where)),
                calls=_services(us.get_client_names_and_types_by_node(*where)),
                actions=_named(get_action_server_names_and_types_by_node(us, *where)),
                sends=_named(get_action_client_names_and_types_by_node(us, *where)),
            )
        except NodeNameNonExistentError:
            return Outcome(Code.REFUSED, "not on the graph")
        level = await _level(robot, node)
        offers = _has_levels(robot, node)
        why = "" if level else _SILENT if offers else "not offered by the node"
        is_managed = bool(robot.lifecycles.word(node))
        transitions = await robot.lifecycles.transitions(node) if is_managed else ()
        return found._replace(level=level, no_level=why, transitions=transitions)

    return await _ask(robot, there)


def _named(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    return tuple(sorted((name, ", ".join(kinds)) for name, kinds in found))


def _topics(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    return _named((n, kinds) for n, kinds in found if n not in _TOPICS and not is_hidden(n))


def _services(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    return _named((n, k) for n, k in found if not is_hidden(n) and not is_of_every_node(k))


async def topic_info(robot: Parts, topic: str) -> TopicInfo | Outcome:
    """Return the publishers and subscriptions of a topic, by its full name, with their QoS."""

    async def there() -> TopicInfo:
        node = robot.node
        publishers = node.get_publishers_info_by_topic(topic)
        subscriptions = node.get_subscriptions_info_by_topic(topic)
        name = node.get_fully_qualified_name()
        return endpoints.topic_info(topic, publishers, subscriptions, name)

    return await _ask(robot, there)


async def types_anywhere(robot: Parts, name: str, *, is_action: bool = False) -> tuple[str, ...]:
    """Return the types with which nodes, also of other namespaces, serve a service or an action."""

    async def there() -> tuple[str, ...]:
        served = robot.graph.served_types(name + SEND if is_action else name)
        return tuple(kind.removesuffix("_SendGoal") for kind in served)

    found = await _ask(robot, there)
    return () if isinstance(found, Outcome) else found


# Its log level.


async def log_level(robot: Parts, node: str) -> Outcome:
    """Ask a node for the level of its log: `lamp logs INFO and above`."""

    async def there() -> Outcome:
        level = await _level(robot, node)
        if level is not None:
            return Outcome(Code.DONE, f"{node.lstrip('/')} logs {level.text}")
        if not _has_levels(robot, node):
            return Outcome(Code.NOT_OFFERED, f"{node} {_NO_LEVELS}")
        return Outcome(Code.TIMEOUT, f"{_SILENT} from {node}")

    return await _ask(robot, there)


async def set_log_level(robot: Parts, node: str, level: str) -> Outcome:
    """Set the level of a node's log, one of LEVELS, and report what it is then, and was before."""
    logger = node.strip("/").replace("/", ".")
    request = SetLoggerLevels.Request(levels=[LoggerLevel(name=logger, level=LEVELS[level])])

    async def work(gate: Gate) -> Outcome:
        if not _has_levels(robot, node):
            return Outcome(Code.NOT_OFFERED, f"{node} {_NO_LEVELS}")
        before = await _level(robot, node)
        service = f"{node}/{_SET}"
        answer = await robot.node.call(SetLoggerLevels, service, request, gate=gate)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"{_SILENT} from {node}")
        if not (answer.results and answer.results[0].successful):
            reason = answer.results[0].reason if answer.results else ""
            return Outcome(Code.REFUSED, reason or "refused, no reason given")
        now = await _level(robot, node)
        was = f", was {before.text}" if before is not None else ""
        return Outcome(Code.DONE, f"{'not known' if now is None else now.text}{was}")

    kind = "rcl_interfaces/srv/SetLoggerLevels"
    return await run(
        *(robot, "log_level", {"node": node, "level": level}),
        f"log level of {node.lstrip('/')} {level}",
        ros2_command.service_call(f"{node}/{_SET}", kind, request),
        work,
    )


def _has_levels(robot: Parts, node: str) -> bool:
    """Return True if a node has the services that get and set its log level."""
    return all(robot.node.count_services(f"{node}/{service}") for service in (_GET, _SET))


async def _level(robot: Parts, node: str) -> LogLevel | None:
    """Return a node's log level; None if the node does not offer it, or does not answer."""
    if not _has_levels(robot, node):
        return None
    parts = node.strip("/").split("/")
    # Its own logger, those above it, and the root: the first with a level decides.
    loggers = [".".join(parts[:end]) for end in range(len(parts), -1, -1)]
    request = GetLoggerLevels.Request(names=loggers)
    answer = await robot.node.call(GetLoggerLevels, f"{node}/{_GET}", request, once=True)
    logger_levels = [] if answer is None else answer.levels
    levels = [_LEVEL_NAMES.get(logger.level, "UNSET") for logger in logger_levels]
    if len(levels) != len(loggers):
        return None
    return LogLevel(levels[0], next((level for level in levels if level != "UNSET"), "UNSET"))


# Its lifecycle.


async def change_lifecycle(robot: Parts, node: str, transition: str) -> Outcome:
    """Have a managed node make a transition, such as `activate`, and wait for its answer."""
    title = f"lifecycle {node.lstrip('/')} {transition}"
    arguments = {"node": node, "transition": transition}
    late = late_report(robot, title, "lifecycle", arguments)
    return await run(
        *(robot, "lifecycle", arguments, title, ros2_command.change_lifecycle(node, transition)),
        lambda gate: robot.lifecycles.change(node, transition, gate, late),
        CHANGE_TIMEOUT,
    )


async def lifecycle_transitions(robot: Parts, node: str) -> tuple[str, ...]:
    """Ask a managed node for the transitions that it can make now, as words: `activate`."""
    found = await _ask(robot, lambda: robot.lifecycles.transitions(node))
    return () if isinstance(found, Outcome) else found
