"""What can be told of an endpoint: the kinds of events, and what each one says."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from rclpy.qos import QoSPolicyKind


class QoSPublisherEventType(IntEnum):
    """What a publisher can be told of."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(IntEnum):
    """What a subscription can be told of."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


class QoSSubscriptionMatchedInfo(NamedTuple):
    """How many endpoints match now and did in all, and what has changed since the last event."""

    total_count: int = 0
    total_count_change: int = 0
    current_count: int = 0
    current_count_change: int = 0


class QoSRequestedIncompatibleQoSInfo(NamedTuple):
    """How many endpoints did not match, and for which policy the last one."""

    total_count: int = 0
    total_count_change: int = 0
    last_policy_kind: QoSPolicyKind = QoSPolicyKind.INVALID


class QoSMessageLostInfo(NamedTuple):
    """How many messages were lost."""

    total_count: int = 0
    total_count_change: int = 0


class IncompatibleTypeInfo(NamedTuple):
    """How many endpoints of another type there are."""

    total_count: int = 0
    total_count_change: int = 0


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo
QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
