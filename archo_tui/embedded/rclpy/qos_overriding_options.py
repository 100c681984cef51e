"""`rclpy.qos_overriding_options`: policies of an endpoint as read-only parameters of its node."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.duration import Duration
from rclpy.exceptions import ParameterAlreadyDeclaredException
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.subscription import Subscription

if TYPE_CHECKING:
    from rclpy.node import Node

QosCallbackResult = SetParametersResult
QosCallbackType = Callable[[QoSProfile], SetParametersResult]
_ENUMS = {
    QoSPolicyKind.HISTORY: HistoryPolicy,
    QoSPolicyKind.RELIABILITY: ReliabilityPolicy,
    QoSPolicyKind.DURABILITY: DurabilityPolicy,
    QoSPolicyKind.LIVELINESS: LivelinessPolicy,
}


class InvalidQosOverridesError(Exception):
    """The callback does not accept the profile with its overrides."""


class QoSOverridingOptions:
    """Which policies become parameters, and who checks the profile that results."""

    def __init__(
        self,
        policy_kinds: Iterable[QoSPolicyKind],
        *,
        callback: QosCallbackType | None = None,
        entity_id: str | None = None,
    ) -> None:
        """`entity_id` tells two endpoints of one topic apart."""
        self.policy_kinds = policy_kinds
        self.callback = callback
        self.entity_id = entity_id

    @classmethod
    def with_default_policies(
        cls, *, callback: QosCallbackType | None = None, entity_id: str | None = None
    ) -> QoSOverridingOptions:
        """History, depth and reliability."""
        kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
        return cls(kinds, callback=callback, entity_id=entity_id)


def _declare_qos_parameters(
    entity_type: type[Publisher[Any] | Subscription[Any]],
    node: Node,
    topic_name: str,
    qos: QoSProfile,
    options: QoSOverridingOptions,
) -> None:
    """Declare `qos_overrides.<topic>.<publisher or subscription>.<policy>`, take in their values.

    Raises InvalidQosOverridesError, RuntimeError for an unknown policy, ValueError for a
    profile that is unknown, TypeError for an unknown kind of endpoint.
    """
    if not issubclass(entity_type, (Publisher, Subscription)):
        raise TypeError("Argument `entity_type` should be a subclass of Publisher or Subscription")
    kind = "publisher" if issubclass(entity_type, Publisher) else "subscription"
    suffix = "" if options.entity_id is None else f"_{options.entity_id}"
    about = f"for {kind} `{topic_name}` with id `{options.entity_id}`"
    for policy in options.policy_kinds:
        if policy == QoSPolicyKind.LIFESPAN and kind == "subscription":
            continue
        name = policy.name.lower()
        full = f"qos_overrides.{topic_name}.{kind}{suffix}.{name}"
        descriptor = ParameterDescriptor(description=f"{name} {about}", read_only=True)
        try:
            parameter = node.declare_parameter(full, _as_parameter(qos, name), descriptor)
        except ParameterAlreadyDeclaredException:
            parameter = node.get_parameter(full)
        setattr(qos, name, _as_policy(policy, parameter.value))
    if options.callback is not None:
        result = options.callback(qos)
        if not result.successful:
            said = f"Provided QoS overrides {about}, are not valid: {result.reason}"
            raise InvalidQosOverridesError(said)


def _as_parameter(profile: QoSProfile, name: str) -> Any:
    value = getattr(profile, name)
    if isinstance(value, Duration):
        return value.nanoseconds
    if not isinstance(value, IntEnum):
        return value
    if value.name == "UNKNOWN":
        raise ValueError("User provided QoS profile is invalid")
    return value.name.lower()


def _as_policy(policy: QoSPolicyKind, value: Any) -> Any:
    if policy in _ENUMS:
        try:
            return _ENUMS[policy][value.upper()]
        except KeyError:
            name = policy.name.lower()
            raise RuntimeError(f"Unexpected QoS override for policy `{name}`: `{value}`") from None
    times = (
        QoSPolicyKind.LIFESPAN,
        QoSPolicyKind.DEADLINE,
        QoSPolicyKind.LIVELINESS_LEASE_DURATION,
    )
    return Duration(nanoseconds=value) if policy in times else value
