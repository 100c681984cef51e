"""A recording's topics, as what hears the robot's topics asks for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from archo_tui.robot_file.model import RobotFile

_QOS = SimpleNamespace(reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.VOLATILE)


class Topics:
    """Stands for the console's node: whatever a recording holds is published."""

    def __init__(self, types: Mapping[str, str], namespace: str) -> None:
        """`types` by full names."""
        self._types, self._below = types, f"{namespace.rstrip('/')}/"
        self.callbacks: dict[str, Callable[[Any], None]] = {}  # by full names

    def resolve_topic_name(self, name: str) -> str:
        """The topic's full name."""
        return name if name.startswith("/") else f"{self._below}{name}"

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        """One publisher of what is in the recording."""
        kind = self._types.get(self.resolve_topic_name(topic))
        if kind is None:
            return []
        nobody = {"node_name": "", "node_namespace": "/"}  # a bag does not name its publishers
        return [SimpleNamespace(topic_type=kind, qos_profile=_QOS, **nobody)]

    def listen_quietly(
        self, _kind: Any, topic: str, callback: Callable[[Any], None], _qos: Any
    ) -> Callable[[Any], None]:
        """From now on it is called with each message of the topic."""
        self.callbacks[self.resolve_topic_name(topic)] = callback
        return callback

    def destroy_subscription(self, callback: Callable[[Any], None]) -> None:
        """It is called no more."""
        self.callbacks = {name: one for name, one in self.callbacks.items() if one != callback}


def namespace(types: Mapping[str, str], robot: RobotFile) -> str:
    """Where the robot's topics are in a recording that does not say so."""
    for topic in robot.topics:
        for name in types:
            if name.endswith(f"/{topic.lstrip('/')}"):
                return name[: -len(topic.lstrip("/")) - 1] or "/"
    return "/"
