"""What one node has on the graph, and the level of its log, seen and set. ROS thread only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rcl_interfaces.msg import LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # rclpy has no public name for it
from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)
from rclpy.node import Node

from archo_tui.robot import ros2_command, services
from archo_tui.robot.graph import is_hidden, is_of_every_node
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.services import Services
from archo_tui.robot.state import LEVELS, LogLevel, Names, NodeInfo
from archo_tui.robot.stops import Gate

_GET, _SET = "get_logger_levels", "set_logger_levels"
_TOPICS = ("/rosout", "/parameter_events")  # of every node
_NAMES = {number: name for name, number in LEVELS.items()}
_NO_LEVELS = "does not offer the level of its log (in rclpy: enable_logger_service=True)"


class Nodes:
    """Asks the graph, and the nodes themselves."""

    def __init__(self, node: Node, pending: Services) -> None:
        self._node, self._services = node, pending

    async def describe(self, name: str) -> NodeInfo | None:
        """What a node has; None when no node of that name is on the graph."""
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
        silent = f"no answer in {services.DEADLINE:g} s"
        why = "" if level else silent if offers else "not offered by the node"
        return found._replace(level=level, no_level=why)

    def _has_levels(self, name: str) -> bool:
        """True when the node offers to show and set the level of its log."""
        return all(self._node.count_services(f"{name}/{service}") for service in (_GET, _SET))

    async def level(self, name: str) -> Outcome:
        """What of its lines a node logs."""
        level = await self._level(name)
        if level is not None:
            return Outcome(Code.DONE, f"{name.lstrip('/')} logs {level.text}")
        if not self._has_levels(name):
            return Outcome(Code.NOT_OFFERED, f"{name} {_NO_LEVELS}")
        return Outcome(Code.TIMEOUT, f"no answer in {services.DEADLINE:g} s from {name}")

    async def _level(self, name: str) -> LogLevel | None:
        """The level of a node's log; None when the node does not say."""
        if not self._has_levels(name):
            return None
        parts = name.strip("/").split("/")
        # its own logger, those above it, and the root: the first that has a level decides
        loggers = [".".join(parts[:end]) for end in range(len(parts), -1, -1)]
        request = GetLoggerLevels.Request(names=loggers)
        answer = await self._services.call(GetLoggerLevels, f"{name}/{_GET}", request, once=True)
        levels = [] if answer is None else [_NAMES.get(one.level, "UNSET") for one in answer.levels]
        if len(levels) != len(loggers):
            return None
        return LogLevel(levels[0], next((one for one in levels if one != "UNSET"), "UNSET"))

    async def set_level(self, name: str, level: str, gate: Gate) -> Outcome:
        """Set the level of a node's log to one of LEVELS."""
        if not self._has_levels(name):
            return Outcome(Code.NOT_OFFERED, f"{name} {_NO_LEVELS}")
        before = await self._level(name)
        answer = await self._services.call(
            SetLoggerLevels, f"{name}/{_SET}", _request(name, level), gate=gate
        )
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {services.DEADLINE:g} s from {name}")
        if not (answer.results and answer.results[0].successful):
            reason = answer.results[0].reason if answer.results else ""
            return Outcome(Code.REFUSED, reason or "refused, no reason given")
        now = await self._level(name)
        was = f", was {before.text}" if before is not None else ""
        return Outcome(Code.DONE, f"{'not known' if now is None else now.text}{was}")


def set_level_command(name: str, level: str) -> str:
    """The `ros2` command line that sets the level of a node's log."""
    kind = "rcl_interfaces/srv/SetLoggerLevels"
    return ros2_command.service_call(f"{name}/{_SET}", kind, _request(name, level))


def _request(name: str, level: str) -> Any:
    logger = name.strip("/").replace("/", ".")
    wanted = LoggerLevel(name=logger, level=LEVELS[level])
    return SetLoggerLevels.Request(levels=[wanted])


def _named(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    return tuple(sorted((name, ", ".join(kinds)) for name, kinds in found))


def _topics(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    """Those that are neither of every node nor parts of an action."""
    return _named((n, kinds) for n, kinds in found if n not in _TOPICS and not is_hidden(n))


def _services(found: Iterable[tuple[str, Sequence[str]]]) -> Names:
    """As `_topics`."""
    return _named((n, k) for n, k in found if not is_hidden(n) and not is_of_every_node(k))
