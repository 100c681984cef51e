"""Quality of service: profiles, and whether two of them match.

History depth, reliability and durability are honoured; lifespan ends what is kept for late joiners.
Deadline and liveliness are compared when endpoints meet, as DDS does; _event_handlers.py tells of
those that are missed.
"""

from __future__ import annotations

import warnings
from copy import copy
from enum import Enum, EnumMeta, IntEnum
from typing import Any

from rclpy._rclpy_pybind11 import rmw_qos_profile_t
from rclpy.duration import Duration

_NO_TIME = Duration()
_BEST_TIME = Duration(nanoseconds=9223372036854775806)  # rmw's "best available"


class _OldNames(EnumMeta):
    """Knows `RMW_QOS_POLICY_HISTORY_KEEP_LAST` and its like, which older programs use."""

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
    """Base of the policies; a short key is a member's name in small letters."""

    @classmethod
    def short_keys(cls) -> list[str]:
        """Every short key."""
        return [member.name.lower() for member in cls]

    @classmethod
    def get_from_short_key(cls, name: str) -> int:
        """The member of that short key. Raises KeyError."""
        return cls[name.upper()].value


class HistoryPolicy(QoSPolicyEnum):
    """How many samples are kept."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(QoSPolicyEnum):
    """Whether samples may be lost. Inside one process none is, but the policies must match."""

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(QoSPolicyEnum):
    """Whether a late subscriber gets what was published before it came."""

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class LivelinessPolicy(QoSPolicyEnum):
    """How a publisher shows that it is alive."""

    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


class QoSPolicyKind(IntEnum):
    """The policies, as a qos event names them."""

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


class QoSCompatibility(Enum):
    """What `qos_check_compatible` finds."""

    OK = 0
    WARNING = 1
    ERROR = 2


_DEFAULT_DEPTH = 10
QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy
DeadlineBestAvailable = _BEST_TIME
LivelinessLeaseDurationeBestAvailable = _BEST_TIME  # rclpy's own spelling

_TYPES: dict[str, tuple[type, type | None]] = {  # of each policy: what it takes and becomes
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
    """A profile without what it needs to be one."""


class QoSProfile:
    """The policies of one publisher or subscription; `depth` counts samples."""

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
        """Raises InvalidQoSProfileException without a depth; AssertionError for other types."""
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
        """Raises AssertionError for a value of another type, AttributeError for another name."""
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

    def get_c_qos_profile(self) -> rmw_qos_profile_t:
        """Its values as rclpy's C layer has them."""
        values = {name: getattr(self, name) for name in ("depth", *_TYPES)}
        return rmw_qos_profile_t(
            {name: int(v) if isinstance(v, IntEnum) else v for name, v in values.items()}
        )

    @property
    def _queue_size(self) -> int | None:
        """Samples a queue of this profile holds; None for no bound."""
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
    """The profiles above, by name; of those alike the later one is another name of the first."""

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
        """Every name in small letters."""
        return [name.lower() for name in cls.__members__]

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """The profile of that name. Raises KeyError."""
        profile: QoSProfile = cls[name.upper()].value
        return profile


def as_profile(qos: QoSProfile | int) -> QoSProfile:
    """A profile of its own from a profile or a depth. Raises TypeError and ValueError as rclpy."""
    if isinstance(qos, QoSProfile):
        return copy(qos)
    if isinstance(qos, bool) or not isinstance(qos, int):
        raise TypeError(f"Expected QoSProfile or int, but received {type(qos)!r}")
    if qos < 0:
        raise ValueError("history depth must be greater than or equal to zero")
    return QoSProfile(depth=qos)


def qos_policy_name_from_kind(policy_kind: QoSPolicyKind | int) -> str:
    """The name of a policy. Raises ValueError for no policy."""
    return QoSPolicyKind(policy_kind).name


def incompatible_policy(offered: QoSProfile, requested: QoSProfile) -> QoSPolicyKind | None:
    """The policy for which a subscription asks more than the publisher offers, or None."""
    faults = [kind for kind, fault, _ in _compared(offered, requested) if fault]
    return faults[-1] if faults else None


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Whether a publisher and a subscription can talk, and why not, or why that is unknown."""
    found = _compared(publisher_qos, subscription_qos)
    errors = "".join(f"ERROR: {fault};" for _, fault, _ in found if fault)
    if errors:
        return QoSCompatibility.ERROR, errors
    doubts = "".join(f"WARNING: {doubt};" for _, _, doubt in found if doubt)
    return (QoSCompatibility.WARNING if doubts else QoSCompatibility.OK), doubts


def _compared(pub: QoSProfile, sub: QoSProfile) -> list[tuple[QoSPolicyKind, str, str]]:
    """Of each policy: what makes the two incompatible, and what may, as rmw's DDS layers say it."""
    return [
        (
            QoSPolicyKind.RELIABILITY,
            _fault(pub.reliability, "BEST_EFFORT", sub.reliability, "RELIABLE",
                   "Best effort publisher and reliable subscription"),
            _doubt(pub.reliability, "BEST_EFFORT", "Best effort publisher", sub.reliability,
                   "RELIABLE", "Reliable subscription", "reliability", "reliability"),
        ),
        (
            QoSPolicyKind.DURABILITY,
            _fault(pub.durability, "VOLATILE", sub.durability, "TRANSIENT_LOCAL",
                   "Volatile publisher and transient local subscription"),
            _doubt(pub.durability, "VOLATILE", "Volatile publisher", sub.durability,
                   "TRANSIENT_LOCAL", "Transient local subscription", "durabilty", "durability"),
        ),
        (
            QoSPolicyKind.DEADLINE,
            _time_fault(pub.deadline, sub.deadline, "deadline",
                        "Subscription deadline is less than publisher deadline"),
            "",
        ),
        (
            QoSPolicyKind.LIVELINESS,
            _fault(pub.liveliness, "AUTOMATIC", sub.liveliness, "MANUAL_BY_TOPIC",
                   "Publisher's liveliness is automatic and subscription's is manual by topic"),
            _liveliness_doubt(pub.liveliness, sub.liveliness),
        ),
        (
            QoSPolicyKind.LIVELINESS,
            _time_fault(pub.liveliness_lease_duration, sub.liveliness_lease_duration,
                        "liveliness lease duration",
                        "Subscription liveliness lease duration is less than publisher"),
            "",
        ),
    ]  # fmt: skip


def _fault(pub: Any, weak: str, sub: Any, strong: str, said: str) -> str:
    return said if pub.name == weak and sub.name == strong else ""


def _time_fault(pub: Duration, sub: Duration, name: str, less: str) -> str:
    if sub.nanoseconds in (0, _BEST_TIME.nanoseconds) or pub.nanoseconds == _BEST_TIME.nanoseconds:
        return ""
    if pub.nanoseconds == 0:
        return f"Subscription has a {name}, but publisher does not"
    return less if sub.nanoseconds < pub.nanoseconds else ""


def _is_open(policy: Any) -> bool:
    return policy.name in ("SYSTEM_DEFAULT", "UNKNOWN")


def _doubt(
    pub: Any, weak: str, weak_said: str, sub: Any, strong: str, strong_said: str,
    pub_name: str, sub_name: str,
) -> str:  # fmt: skip
    if _is_open(pub) and _is_open(sub):
        one, other = pub.name.lower(), sub.name.lower()
        return f"Publisher {pub_name} is {one} and subscription {sub_name} is {other}"
    if _is_open(pub) and sub.name == strong:
        return f"{strong_said}, but publisher is {pub.name.lower()}"
    if pub.name == weak and _is_open(sub):
        return f"{weak_said}, but subscription is {sub.name.lower()}"
    return ""


def _liveliness_doubt(pub: LivelinessPolicy, sub: LivelinessPolicy) -> str:
    if _is_open(pub) and _is_open(sub):
        one, other = pub.name.lower(), sub.name.lower()
        return f"Publisher liveliness is {one} and subscription liveliness is {other}"
    if _is_open(pub) and sub == LivelinessPolicy.MANUAL_BY_TOPIC:
        is_ = pub.name.lower()
        return f"Subscription's liveliness is manual by topic, but publisher's is {is_}"
    if pub == LivelinessPolicy.AUTOMATIC and _is_open(sub):
        is_ = sub.name.lower()
        return f"Publisher's liveliness is automatic, but subscription's is {is_}"
    return ""
