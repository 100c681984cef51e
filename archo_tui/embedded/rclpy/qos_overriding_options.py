"""`rclpy.qos_overriding_options`: policies of an endpoint as read-only parameters of its node."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy import qos
from rclpy.duration import Duration
from rclpy.exceptions import ParameterAlreadyDeclaredException
from rclpy.qos import QoSPolicyKind, QoSProfile

if TYPE_CHECKING:
    from rclpy.node import Node

QosCallbackResult = SetParametersResult
QosCallbackType = Callable[[QoSProfile], SetParametersResult]
_ENUMS = {
    QoSPolicyKind.HISTORY: qos.HistoryPolicy,
    QoSPolicyKind.RELIABILITY: qos.ReliabilityPolicy,
    QoSPolicyKind.DURABILITY: qos.DurabilityPolicy,
    QoSPolicyKind.LIVELINESS: qos.LivelinessPolicy,
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


def apply(
    node: Node, kind: str, topic: str, profile: QoSProfile, options: QoSOverridingOptions
) -> None:
    """Declare `qos_overrides.<topic>.<kind>.<policy>` and take their values into the profile.

    `kind` is `publisher` or `subscription`. Raises InvalidQosOverridesError, RuntimeError for a
    word that is no policy, ValueError for a profile that is unknown.
    """
    suffix = "" if options.entity_id is None else f"_{options.entity_id}"
    about = f"for {kind} `{topic}` with id `{options.entity_id}`"
    for policy in options.policy_kinds:
        if policy == QoSPolicyKind.LIFESPAN and kind == "subscription":
            continue
        name = policy.name.lower()
        full = f"qos_overrides.{topic}.{kind}{suffix}.{name}"
        descriptor = ParameterDescriptor(description=f"{name} {about}", read_only=True)
        try:
            parameter = node.declare_parameter(full, _as_parameter(profile, name), descriptor)
        except ParameterAlreadyDeclaredException:
            parameter = node.get_parameter(full)
        setattr(profile, name, _as_policy(policy, parameter.value))
    if options.callback is not None:
        result = options.callback(profile)
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
