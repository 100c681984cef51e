"""The module `rclpy.topic_endpoint_info`: an endpoint of a topic, as discovery tells it."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

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
