"""Quality of service: profiles, and the check if two of them match.

History depth, reliability and durability are honoured; lifespan ends what is kept for late joiners.
Deadline and liveliness are compared when endpoints meet, as DDS does, and have no other effect.
"""

from __future__ import annotations

import warnings
from copy import copy
from enum import Enum, EnumMeta, IntEnum
from typing import Any

from rclpy.duration import Duration

_NO_TIME = Duration()
_BEST_TIME = Duration(nanoseconds=9223372036854775806)  # rmw's "best available".


class _OldNames(EnumMeta):
    """A metaclass that gives policies their old names, such as `RMW_QOS_POLICY_HISTORY_KEEP_LAST`.

    Using an old name warns.
    """

    def __getattr__(cls, name: str) -> Any:
        kind = cls.__name__.removesuffix("Policy")
        short = name.removeprefix(f"RMW_QOS_POLICY_{kind.upper()}_")
        if short == name or short not in cls.__members__:
            raise AttributeError(name)
        warnings.warn(
            f"{kind}Policy.{name} is deprecated. Use {kind}Policy.{short} instead.", stacklevel=2
        )
        return cls[short]


class QoSPolicyEnum(IntEnum, metaclass=_OldNames):
    """The base of policies; a short key is a member's name in small letters."""

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the short key of every member."""
        return [member.name.lower() for member in cls]

    @classmethod
    def get_from_short_key(cls, name: str) -> int:
        """Return the number of the member with a short key, in any case."""
        return cls[name.upper()].value


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

    INVALID = 1 << 0
    DURABILITY = 1 << 1
    DEADLINE = 1 << 2
    LIVELINESS = 1 << 3
    RELIABILITY = 1 << 4
    HISTORY = 1 << 5
    LIFESPAN = 1 << 6
    DEPTH = 1 << 7
    LIVELINESS_LEASE_DURATION = 1 << 8
    AVOID_ROS_NAMESPACE_CONVENTIONS = 1 << 9


_DEFAULT_DEPTH = 10
QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy
DeadlineBestAvailable = _BEST_TIME
LivelinessLeaseDurationeBestAvailable = _BEST_TIME  # rclpy's own spelling.

_TYPES: dict[
    str, tuple[type, type | None]
] = {  # Of each policy: the type it takes and the one it becomes.
    "history": (int, HistoryPolicy),
    "depth": (int, None),
    "reliability": (int, ReliabilityPolicy),
    "durability": (int, DurabilityPolicy),
    "lifespan": (Duration, None),
    "deadline": (Duration, None),
    "liveliness": (int, LivelinessPolicy),
    "liveliness_lease_duration": (Duration, None),
    "avoid_ros_namespace_conventions": (bool, None),
}


class InvalidQoSProfileException(Exception):
    """The error for a QoSProfile of KEEP_LAST that is created without a depth."""


class QoSProfile:
    """The policies of one publisher or subscription; `depth` counts samples.

    A zero duration means that the policy is not used.
    """

    history: HistoryPolicy
    depth: int
    reliability: ReliabilityPolicy
    durability: DurabilityPolicy
    lifespan: Duration
    deadline: Duration
    liveliness: LivelinessPolicy
    liveliness_lease_duration: Duration
    avoid_ros_namespace_conventions: bool

    def __init__(
        self,
        history: HistoryPolicy | int | None = None,
        depth: int | None = None,
        reliability: ReliabilityPolicy | int = ReliabilityPolicy.RELIABLE,
        durability: DurabilityPolicy | int = DurabilityPolicy.VOLATILE,
        lifespan: Duration = _NO_TIME,
        deadline: Duration = _NO_TIME,
        liveliness: LivelinessPolicy | int = LivelinessPolicy.SYSTEM_DEFAULT,
        liveliness_lease_duration: Duration = _NO_TIME,
        avoid_ros_namespace_conventions: bool = False,
    ) -> None:
        if history is None and depth is None:
            raise InvalidQoSProfileException("History and/or depth settings are required.")
        history = HistoryPolicy.KEEP_LAST if history is None else history
        if history == HistoryPolicy.KEEP_LAST and depth is None:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        given = locals()
        for name in _TYPES:
            setattr(self, name, given[name])
        if depth is None:
            self.depth = _DEFAULT_DEPTH

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a policy; a depth of 0 with KEEP_LAST gives a warning, a depth of None becomes 10."""
        if name not in _TYPES:
            raise AttributeError(f"'QoSProfile' object has no attribute {name!r}")
        taken, kind = _TYPES[name]
        if value is None and name == "depth":
            value = _DEFAULT_DEPTH
        assert isinstance(value, taken)
        if name == "depth" and value == 0 and self.history == HistoryPolicy.KEEP_LAST:
            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                "This will be interpreted as SYSTEM_DEFAULT",
                stacklevel=2,
            )
        object.__setattr__(self, name, value if kind is None else kind(value))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, QoSProfile) and vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]  # it can be changed

    def __str__(self) -> str:
        shown = {name: value for name, value in vars(self).items()}
        inside = (
            f"{name}={value.value if isinstance(value, IntEnum) else value}"
            for name, value in shown.items()
        )
        return f"QoSProfile({', '.join(inside)})"

    @property
    def _queue_size(self) -> int | None:
        """Return how many samples a queue of this profile holds, at least 1; None for no bound."""
        return None if self.history == HistoryPolicy.KEEP_ALL else max(self.depth, 1)


qos_profile_unknown = QoSProfile(
    history=HistoryPolicy.UNKNOWN,
    depth=0,
    reliability=ReliabilityPolicy.UNKNOWN,
    durability=DurabilityPolicy.UNKNOWN,
    liveliness=LivelinessPolicy.UNKNOWN,
)
qos_profile_default = QoSProfile(depth=_DEFAULT_DEPTH)
qos_profile_system_default = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT,
    depth=0,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
)
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
    def short_keys(cls) -> list[str]:
        """Return every name in small letters, aliases too."""
        return [name.lower() for name in cls.__members__]

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


def qos_policy_name_from_kind(policy_kind: QoSPolicyKind | int) -> str:
    """Return the name of a policy, such as `DEPTH`; raise ValueError for an unknown kind."""
    return QoSPolicyKind(policy_kind).name


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
