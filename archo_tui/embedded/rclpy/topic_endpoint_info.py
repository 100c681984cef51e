"""The module `rclpy.topic_endpoint_info`: an endpoint of a topic, as discovery tells it."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

from rclpy.qos import QoSProfile, as_profile, qos_profile_unknown


class TopicEndpointTypeEnum(IntEnum):
    """The two sides of a topic, and INVALID for none."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2


@dataclass
class TopicEndpointInfo:
    """The description of an endpoint as DDS gives it: history and depth of the QoS are unknown."""

    node_name: str = ""
    node_namespace: str = ""
    topic_type: str = ""
    endpoint_type: TopicEndpointTypeEnum = TopicEndpointTypeEnum.INVALID
    endpoint_gid: list[int] = field(default_factory=list)  # 16 bytes.
    qos_profile: QoSProfile = field(default_factory=lambda: as_profile(qos_profile_unknown))

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute; a dict makes a QoSProfile, as in rclpy."""
        if name not in _TYPES:
            raise AttributeError(f"'TopicEndpointInfo' object has no attribute {name!r}")
        if name == "endpoint_gid":
            value = list(value)
        if name == "qos_profile" and isinstance(value, dict):
            value = QoSProfile(**value)
        fits = isinstance(value, _TYPES[name])
        assert fits
        if name == "endpoint_type":
            value = TopicEndpointTypeEnum(value)
        object.__setattr__(self, name, value)

    def __str__(self) -> str:
        qos, gid = self.qos_profile, ".".join(f"{byte:02x}" for byte in self.endpoint_gid)
        depth = f" ({qos.depth})" if qos.history.name == "KEEP_LAST" else ""
        return "\n".join(
            (
                f"Node name: {self.node_name}",
                f"Node namespace: {self.node_namespace}",
                f"Topic type: {self.topic_type}",
                "Topic type hash: INVALID",
                f"Endpoint type: {self.endpoint_type.name}",
                f"GID: {gid}",
                "QoS profile:",
                f"  Reliability: {qos.reliability.name}",
                f"  History (Depth): {qos.history.name}{depth}",
                f"  Durability: {qos.durability.name}",
                f"  Lifespan: {qos.lifespan}",
                f"  Deadline: {qos.deadline}",
                f"  Liveliness: {qos.liveliness.name}",
                f"  Liveliness lease duration: {qos.liveliness_lease_duration}",
            )
        )


_TYPES: dict[str, type] = {
    "node_name": str,
    "node_namespace": str,
    "topic_type": str,
    "endpoint_type": int,
    "endpoint_gid": list,
    "qos_profile": QoSProfile,
}
