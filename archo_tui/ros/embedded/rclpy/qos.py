"""Quality of service: profiles, and the check if two of them match.

History depth, reliability and durability are honoured; lifespan ends what is kept for late joiners.
Deadline and liveliness are compared when endpoints meet, as DDS does, and have no other effect.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from enum import Enum, EnumMeta, IntEnum
from typing import Any, get_type_hints

from rclpy.duration import Duration

_NO_TIME = Duration()
_BEST_TIME = Duration(nanoseconds=9223372036854775806)  # rmw's "best available".


class _OldNames(EnumMeta):
    """A metaclass that knows old names of policies: `RMW_QOS_POLICY_HISTORY_KEEP_LAST`."""

    def __getattr__(cls, name: str) -> Any:
        kind = cls.__name__.removesuffix("Policy").upper()
        short = name.removeprefix(f"RMW_QOS_POLICY_{kind}_")
        if short == name or short not in cls.__members__:
            raise AttributeError(name)
        return cls[short]


class QoSPolicyEnum(IntEnum, metaclass=_OldNames):
    """The base of policies."""


class HistoryPolicy(QoSPolicyEnum):
    """The policy for how many samples are kept: KEEP_ALL has no limit, all others keep `depth`."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(QoSPolicyEnum):
    """The policy for samples lost on the way.

    In one process none is lost, but a reliable subscription still needs a reliable publisher.
    """

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(QoSPolicyEnum):
    """The policy for late subscriptions: what was published before is kept for them, or not.

    A subscription gets the kept messages if TRANSIENT_LOCAL is set on both sides.
    """

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class LivelinessPolicy(QoSPolicyEnum):
    """The policy for how a publisher shows that it is alive; here it is only compared."""

    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


class QoSPolicyKind(IntEnum):
    """The policies, as an event of QoS names them."""

    INVALID = 1
    DURABILITY = 2
    DEADLINE = 4
    LIVELINESS = 8
    RELIABILITY = 16
    HISTORY = 32
    LIFESPAN = 64
    DEPTH = 128


_DEFAULT_DEPTH = 10
QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy


class InvalidQoSProfileException(Exception):
    """The error for a QoSProfile of KEEP_LAST that is created without a depth."""


@dataclass
class QoSProfile:
    """The policies of one publisher or subscription; `depth` counts samples.

    A zero duration means that the policy is not used. A value of a wrong type is refused.
    """

    history: HistoryPolicy = None  # type: ignore[assignment]  # KEEP_LAST, if there is a depth.
    depth: int = None  # type: ignore[assignment]
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE
    lifespan: Duration = _NO_TIME
    deadline: Duration = _NO_TIME
    liveliness: LivelinessPolicy = LivelinessPolicy.SYSTEM_DEFAULT
    liveliness_lease_duration: Duration = _NO_TIME
    avoid_ros_namespace_conventions: bool = False

    def __post_init__(self) -> None:
        if self.history is None and self.depth is None:
            raise InvalidQoSProfileException("History and/or depth settings are required.")
        if self.history is None:
            self.history = HistoryPolicy.KEEP_LAST
        if self.depth is None:
            if self.history == HistoryPolicy.KEEP_LAST:
                raise InvalidQoSProfileException("KEEP_LAST without a depth setting.")
            self.depth = _DEFAULT_DEPTH

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in _KINDS:
            raise AttributeError(f"'QoSProfile' object has no attribute {name!r}")
        kind = _KINDS[name]
        is_number = issubclass(kind, int) and kind is not bool
        if value is not None:
            assert isinstance(value, int if is_number else kind), f"{name} is no {kind.__name__}"
            value = kind(value) if is_number else value
        object.__setattr__(self, name, value)

    @property
    def _queue_size(self) -> int | None:
        """Return how many samples a queue of this profile holds, at least 1; None for no bound."""
        return None if self.history == HistoryPolicy.KEEP_ALL else max(self.depth, 1)


_KINDS: dict[str, type] = get_type_hints(QoSProfile)


def _of_all(policy: str) -> QoSProfile:
    """Return a profile of which all policies are called the same."""
    of_samples = HistoryPolicy[policy], 0, ReliabilityPolicy[policy], DurabilityPolicy[policy]
    return QoSProfile(*of_samples, liveliness=LivelinessPolicy[policy])


qos_profile_unknown = _of_all("UNKNOWN")
qos_profile_default = QoSProfile(depth=_DEFAULT_DEPTH)
qos_profile_system_default = _of_all("SYSTEM_DEFAULT")
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default = QoSProfile(depth=_DEFAULT_DEPTH)
qos_profile_parameters = QoSProfile(depth=1000)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_best_available = QoSProfile(
    depth=_DEFAULT_DEPTH,
    reliability=ReliabilityPolicy.BEST_AVAILABLE,
    durability=DurabilityPolicy.BEST_AVAILABLE,
    deadline=_BEST_TIME,
    liveliness=LivelinessPolicy.BEST_AVAILABLE,
    liveliness_lease_duration=_BEST_TIME,
)
qos_profile_action_status_default = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
qos_profile_rosout_default = QoSProfile(
    depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=10)
)


class QoSPresetProfiles(Enum):
    """The preset profiles by name; of equal ones the later is an alias of the first."""

    UNKNOWN = qos_profile_unknown
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    BEST_AVAILABLE = qos_profile_best_available
    ROSOUT_DEFAULT = qos_profile_rosout_default

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Return the profile of that name, in any case: the profile itself, not a copy."""
        profile: QoSProfile = cls[name.upper()].value
        return profile


def as_profile(qos: QoSProfile | int) -> QoSProfile:
    """Return a copy of a profile, or a default profile with a depth."""
    if isinstance(qos, QoSProfile):
        return copy(qos)
    if isinstance(qos, bool) or not isinstance(qos, int):
        raise TypeError(f"Expected QoSProfile or int, but received {type(qos)!r}")
    if qos < 0:
        raise ValueError("history depth must be greater than or equal to zero")
    return QoSProfile(depth=qos)


def incompatible_policy(offered: QoSProfile, requested: QoSProfile) -> QoSPolicyKind | None:
    """Return the last policy for which a subscription asks more than a publisher offers, or None.

    The order is reliability, durability, deadline, liveliness.
    """
    faults = {
        QoSPolicyKind.RELIABILITY: (
            offered.reliability == ReliabilityPolicy.BEST_EFFORT
            and requested.reliability == ReliabilityPolicy.RELIABLE
        ),
        QoSPolicyKind.DURABILITY: (
            offered.durability == DurabilityPolicy.VOLATILE
            and requested.durability == DurabilityPolicy.TRANSIENT_LOCAL
        ),
        QoSPolicyKind.DEADLINE: _is_longer(offered.deadline, requested.deadline),
        QoSPolicyKind.LIVELINESS: (
            offered.liveliness == LivelinessPolicy.AUTOMATIC
            and requested.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
        )
        or _is_longer(offered.liveliness_lease_duration, requested.liveliness_lease_duration),
    }
    return next((kind for kind in reversed(faults) if faults[kind]), None)


def _is_longer(offered: Duration, requested: Duration) -> bool:
    """Return True if a publisher's duration exceeds the one that a subscription asks for.

    Zero means infinite; "best available" fits everything.
    """
    if requested.nanoseconds in (0, _BEST_TIME.nanoseconds) or offered == _BEST_TIME:
        return False
    return offered.nanoseconds == 0 or requested.nanoseconds < offered.nanoseconds
