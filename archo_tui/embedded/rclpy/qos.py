"""Quality of service: what the engine honours is history depth, reliability and durability."""

from __future__ import annotations

import warnings
from copy import copy
from dataclasses import dataclass
from enum import Enum, IntEnum


class HistoryPolicy(IntEnum):
    """How many samples are kept."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(IntEnum):
    """Whether samples may be lost. Inside one process none is, but the policies must match."""

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(IntEnum):
    """Whether a late subscriber gets what was published before it came."""

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


_DEFAULT_DEPTH = 10
QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy


class InvalidQoSProfileException(Exception):
    """A profile without what it needs to be one."""


@dataclass(init=False)
class QoSProfile:
    """The policies of one publisher or subscription; `depth` counts samples."""

    history: HistoryPolicy
    depth: int
    reliability: ReliabilityPolicy
    durability: DurabilityPolicy

    def __init__(
        self,
        history: HistoryPolicy | int | None = None,
        depth: int | None = None,
        reliability: ReliabilityPolicy | int = ReliabilityPolicy.RELIABLE,
        durability: DurabilityPolicy | int = DurabilityPolicy.VOLATILE,
    ) -> None:
        """Raises InvalidQoSProfileException without a depth; AssertionError for other types."""
        if history is None and depth is None:
            raise InvalidQoSProfileException("History and/or depth settings are required.")
        history = history or HistoryPolicy.KEEP_LAST
        assert all(isinstance(policy, int) for policy in (history, reliability, durability))
        self.history = HistoryPolicy(history)
        self.reliability = ReliabilityPolicy(reliability)
        self.durability = DurabilityPolicy(durability)
        if self.history == HistoryPolicy.KEEP_LAST and depth is None:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        assert depth is None or isinstance(depth, int)
        self.depth = _DEFAULT_DEPTH if depth is None else depth
        if self.history == HistoryPolicy.KEEP_LAST and self.depth == 0:
            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                "This will be interpreted as SYSTEM_DEFAULT",
                stacklevel=2,
            )

    @property
    def queue_size(self) -> int | None:
        """Samples a queue of this profile holds; None for no bound."""
        return None if self.history == HistoryPolicy.KEEP_ALL else max(self.depth, 1)


qos_profile_system_default = QoSProfile(depth=_DEFAULT_DEPTH)
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default = QoSProfile(depth=_DEFAULT_DEPTH)
qos_profile_parameters = QoSProfile(depth=1000)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_action_status_default = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
qos_profile_rosout_default = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class QoSPresetProfiles(Enum):
    """The profiles above, by name."""

    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default


def as_profile(qos: QoSProfile | int) -> QoSProfile:
    """A profile of its own from a profile or a depth. Raises TypeError and ValueError as rclpy."""
    if isinstance(qos, QoSProfile):
        return copy(qos)
    if isinstance(qos, bool) or not isinstance(qos, int):
        raise TypeError(f"Expected QoSProfile or int, but received {type(qos)!r}")
    if qos < 0:
        raise ValueError("depth must be greater than or equal to zero")
    return QoSProfile(depth=qos)


def incompatible_policy(offered: QoSProfile, requested: QoSProfile) -> str | None:
    """The policy for which a subscription asks more than the publisher offers, or None."""
    if (
        requested.durability == DurabilityPolicy.TRANSIENT_LOCAL
        and offered.durability == DurabilityPolicy.VOLATILE
    ):
        return "DURABILITY"
    if (
        requested.reliability == ReliabilityPolicy.RELIABLE
        and offered.reliability == ReliabilityPolicy.BEST_EFFORT
    ):
        return "RELIABILITY"
    return None
