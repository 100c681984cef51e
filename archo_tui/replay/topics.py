"""The topics of a recording, as the telemetry subscribes to them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from archo_tui.robot.state import in_namespace
from archo_tui.robot_file.model import RobotFile

_QOS = SimpleNamespace(reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.VOLATILE)


class RecordedTopics:
    """A stand-in for the console's node, on which every recorded topic has a publisher.

    It receives nothing by itself: the caller calls `callbacks` with recorded messages.

    Attributes:
        callbacks: The callback of each subscribed topic, by its full name.
    """

    def __init__(self, types: Mapping[str, str], namespace: str) -> None:
        """Create the stand-in.

        Args:
            types: The type of each topic, by full names.
            namespace: The robot's namespace.
        """
        self._types, self._namespace = types, namespace
        self.callbacks: dict[str, Callable[[Any], None]] = {}

    def resolve_topic_name(self, name: str) -> str:
        """Return the full name of a topic; one without a leading `/` is below the namespace."""
        return in_namespace(self._namespace, name)

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        """Return one nameless publisher of a recorded topic, or an empty list for another one."""
        kind = self._types.get(self.resolve_topic_name(topic))
        if kind is None:
            return []
        nobody = {"node_name": "", "node_namespace": "/"}  # A bag does not name its publishers.
        return [SimpleNamespace(topic_type=kind, qos_profile=_QOS, **nobody)]

    def listen_quietly(
        self, _kind: Any, topic: str, callback: Callable[[Any], None], _qos: Any
    ) -> Callable[[Any], None]:
        """Register a callback for a topic, and return it as the subscription.

        It replaces the callback that was registered for the topic before.
        """
        self.callbacks[self.resolve_topic_name(topic)] = callback
        return callback

    def destroy_subscription(self, callback: Callable[[Any], None]) -> None:
        """Remove a callback from `callbacks`; an unknown one is ignored."""
        self.callbacks = {
            name: known for name, known in self.callbacks.items() if known != callback
        }


def guess_namespace(types: Mapping[str, str], robot: RobotFile) -> str:
    """Return the namespace in which a topic of the robot is recorded; `/` if none is.

    The first topic of the robot file that the recording has, in whatever namespace, decides.
    """
    for topic in robot.topics:
        for name in types:
            if name.endswith(f"/{topic.lstrip('/')}"):
                return name[: -len(topic.lstrip("/")) - 1] or "/"
    return "/"
