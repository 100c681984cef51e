"""The description of a node from the graph, and its log level. ROS thread only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rcl_interfaces.msg import LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # It has no public name.
from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)
from rclpy.node import Node

from archo_tui.robot import calls
from archo_tui.robot.calls import Services
from archo_tui.robot.graph.endpoints import topic_info
from archo_tui.robot.graph.graph import is_hidden, is_of_every_node
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import LEVELS, LogLevel, Names, NodeInfo, TopicInfo
from archo_tui.robot.stop.gate import Gate

_GET, _SET = "get_logger_levels", "set_logger_levels"
_TOPICS = ("/rosout", "/parameter_events")  # Every node has them.
_NAMES = {number: name for name, number in LEVELS.items()}
_NO_LEVELS = "does not offer the level of its log (in rclpy: enable_logger_service=True)"


class Nodes:
    """The questions about one node, to the graph and to the node itself, and its log level."""

    def __init__(self, node: Node, pending: Services) -> None:
        self._node, self._services = node, pending

    async def describe(self, name: str) -> NodeInfo | None:
        """Return what a node has, without what every node has and without hidden names.

        The node itself is asked for its log level. The transitions of a managed node are left
        empty.
        """
        namespace, _, base = name.rpartition("/")
        where, node = (base, namespace or "/"), self._node
        try:
            found = NodeInfo(
                publishes=_topics(node.get_publisher_names_and_types_by_node(*where)),
                subscribes=_topics(node.get_subscriber_names_and_types_by_node(*where)),
                serves=_services(node.get_service_names_and_types_by_node(*where)),
                calls=_services(node.get_client_names_and_types_by_node(*where)),
                actions=_named(get_action_server_names_and_types_by_node(node, *where)),
                sends=_named(get_action_client_names_and_types_by_node(node, *where)),
            )
        except NodeNameNonExistentError:
            return None
        level = await self._level(name)
        offers = self._has_levels(name)
        silent = f"no answer in {calls.DEADLINE:g} s"
        why = "" if level else silent if offers else "not offered by the node"
        return found._replace(level=level, no_level=why)

    def topic_info(self, topic: str) -> TopicInfo:
        """Return the publishers and subscriptions of a topic, and which of them do not fit.

        Raises:
            ValueError: The name is not valid.
        """
        node = self._node
        publishers = node.get_publishers_info_by_topic(topic)
        subscriptions = node.get_subscriptions_info_by_topic(topic)
        return topic_info(topic, publishers, subscriptions, node.get_fully_qualified_name())

    def _has_levels(self, name: str) -> bool:
        """Return True if the node has the services that get and set its log level."""
        return all(self._node.count_services(f"{name}/{service}") for service in (_GET, _SET))

    async def level(self, name: str) -> Outcome:
        """Ask a node for its log level: `lamp logs INFO and above`."""
        level = await self._level(name)
        if level is not None:
            return Outcome(Code.DONE, f"{name.lstrip('/')} logs {level.text}")
        if not self._has_levels(name):
            return Outcome(Code.NOT_OFFERED, f"{name} {_NO_LEVELS}")
        return Outcome(Code.TIMEOUT, f"no answer in {calls.DEADLINE:g} s from {name}")

    async def _level(self, name: str) -> LogLevel | None:
        """Return a node's log level; None if the node does not offer it, or does not answer."""
        if not self._has_levels(name):
            return None
        parts = name.strip("/").split("/")
        # Its own logger, those above it, and the root: the first with a level decides.
        loggers = [".".join(parts[:end]) for end in range(len(parts), -1, -1)]
        request = GetLoggerLevels.Request(names=loggers)
        answer = await self._services.call(GetLoggerLevels, f"{name}/{_GET}", request, once=True)
        logger_levels = [] if answer is None else answer.levels
        levels = [_NAMES.get(logger.level, "UNSET") for logger in logger_levels]
        if len(levels) != len(loggers):
            return None
        return LogLevel(levels[0], next((level for level in levels if level != "UNSET"), "UNSET"))

    async def set_level(self, name: str, level: str, gate: Gate) -> Outcome:
        """Set the log level of a node, and ask the node for it before and afterwards.

        Raises:
            KeyError: The level is none of LEVELS.
            Void: A STOP was read after the request was typed.
        """
        if not self._has_levels(name):
            return Outcome(Code.NOT_OFFERED, f"{name} {_NO_LEVELS}")
        before = await self._level(name)
        answer = await self._services.call(
            SetLoggerLevels, f"{name}/{_SET}", _request(name, level), gate=gate
        )
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {calls.DEADLINE:g} s from {name}")
        if not (answer.results and answer.results[0].successful):
            reason = answer.results[0].reason if answer.results else ""
            return Outcome(Code.REFUSED, reason or "refused, no reason given")
        now = await self._level(name)
        was = f", was {before.text}" if before is not None else ""
        return Outcome(Code.DONE, f"{'not known' if now is None else now.text}{was}")


def set_level_command(name: str, level: str) -> str:
    """Return the `ros2` command line that sets a node's log level; KeyError for none of LEVELS."""
    kind = "rcl_interfaces/srv/SetLoggerLevels"
    return ros2_command.service_call(f"{name}/{_SET}", kind, _request(name, level))


def _request(name: str, level: str) -> Any:
    logger = name.strip("/").replace("/", ".")
    wanted = LoggerLevel(name=logger, level=LEVELS[level])
    return SetLoggerLevels.Request(levels=[wanted])


def _named(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    return tuple(sorted((name, ", ".join(kinds)) for name, kinds in found))


def _topics(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    """Return topics without those that every node has, and without hidden ones, as of actions."""
    return _named((n, kinds) for n, kinds in found if n not in _TOPICS and not is_hidden(n))


def _services(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    """Return services without those that every node has, and without hidden ones, as of actions."""
    return _named((n, k) for n, k in found if not is_hidden(n) and not is_of_every_node(k))
