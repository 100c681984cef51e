"""The kinds of events of an endpoint, and the data of each."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from rclpy.qos import QoSPolicyKind


class QoSPublisherEventType(IntEnum):
    """The kinds of events of a publisher."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(IntEnum):
    """The kinds of events of a subscription."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


class QoSSubscriptionMatchedInfo(NamedTuple):
    """The numbers of endpoints that have matched in all, and that match now.

    A `..._change` counts since the last callback; `current_count_change` is negative if fewer match
    now. QoSPublisherMatchedInfo is this class, too.
    """

    total_count: int = 0
    total_count_change: int = 0
    current_count: int = 0
    current_count_change: int = 0


class QoSRequestedIncompatibleQoSInfo(NamedTuple):
    """The numbers of endpoints with incompatible QoS, and the policy in which the last one differs.

    `total_count_change` counts since the last callback. QoSOfferedIncompatibleQoSInfo is this
    class, too.
    """

    total_count: int = 0
    total_count_change: int = 0
    last_policy_kind: QoSPolicyKind = QoSPolicyKind.INVALID


class QoSMessageLostInfo(NamedTuple):
    """The lost messages: all, and those since the last callback; here no message is ever lost."""

    total_count: int = 0
    total_count_change: int = 0


class IncompatibleTypeInfo(NamedTuple):
    """The endpoints of another type in all and since the last callback; here none is reported."""

    total_count: int = 0
    total_count_change: int = 0


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo
QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
