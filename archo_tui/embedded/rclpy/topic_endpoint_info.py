"""`rclpy.topic_endpoint_info`: one publisher or subscription of a topic, as discovery tells it."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from rclpy.qos import QoSProfile


class TopicEndpointTypeEnum(IntEnum):
    """Which side of a topic."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2


class TopicEndpointInfo(NamedTuple):
    """What DDS tells of an endpoint: its history and depth stay with it."""

    node_name: str
    node_namespace: str
    topic_type: str
    endpoint_type: TopicEndpointTypeEnum
    endpoint_gid: list[int]  # 16 bytes
    qos_profile: QoSProfile
