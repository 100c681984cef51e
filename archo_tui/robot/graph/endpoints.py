"""The QoS of a topic's ends: which QoS fits its publishers, and which ends do not match."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from types import SimpleNamespace
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from archo_tui.robot.state.graph import TopicEnd, TopicInfo, node_of
from archo_tui.ros.names import package_of

# A policy with the values of a subscription and of a publisher that DDS does not match.
_UNMATCHED = (
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
)
# Filled with the subscriber, the publishers, the topic and the reason.
_HEARS_NOTHING = "{} hears nothing of {} on {}: {}"
_MISREADS = "{} may misread {} on {}: {}"
_SHOWN = 8  # Digits of a type hash; enough to tell two versions of a type apart.
_OWN = "this console"
_ENDLESS = 10**18  # Nanoseconds; rmw reports more where no deadline is asked for.
DEPTH = 10  # Messages that wait, as in rclpy's examples.


def is_latched(publishers: Sequence[Any]) -> bool:
    """Return True if every publisher of a topic is transient local; False if there is none."""
    durable = DurabilityPolicy.TRANSIENT_LOCAL
    return bool(publishers) and all(p.qos_profile.durability == durable for p in publishers)


def fitting_qos(publishers: Sequence[Any], depth: int = DEPTH) -> QoSProfile:
    """Return the QoS with which a subscription gets the messages of all publishers."""
    latched = is_latched(publishers)
    reliable = all(p.qos_profile.reliability == ReliabilityPolicy.RELIABLE for p in publishers)
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def topic_info(
    topic: str, publishers: Sequence[Any], subscriptions: Sequence[Any], console: str
) -> TopicInfo:
    """Return the publishers and subscriptions of a topic, and the pairs that do not match."""
    shown = [end for end in subscriptions if "/_" not in node_of(end) or node_of(end) == console]
    return TopicInfo(
        tuple(sorted(map(_end, publishers))),
        tuple(sorted(map(_end, shown))),
        mismatches(topic, publishers, subscriptions, console),
    )


def _end(info: Any) -> TopicEnd:
    qos = info.qos_profile
    words = f"{qos.reliability.name}, {qos.durability.name}"
    return TopicEnd(node_of(info), info.topic_type, words)


def mismatches(
    topic: str, publishers: Iterable[Any], subscriptions: Iterable[Any], console: str = ""
) -> tuple[str, ...]:
    """Return a sentence for each subscription that cannot read a publisher, with the remedy.

    With different types or QoS, nothing is delivered. With different versions of one type, such as
    one with an additional field, DDS delivers all the same, and what is read may be wrong.
    """
    found: dict[tuple[str, str, str, str], set[str]] = {}
    offered = list(publishers)
    for subscription in subscriptions:
        node = node_of(subscription)
        is_own = node == console
        if "/_" in node and not is_own:
            continue
        for publisher in offered:
            reason = None if is_own else _unmatched(publisher, subscription)
            reason = reason or _another_version(publisher, subscription)
            if reason is not None:
                name = _OWN if is_own else node.lstrip("/")
                found.setdefault((name, *reason), set()).add(node_of(publisher))
    return tuple(
        sorted(
            what.format(name, ", ".join(n.lstrip("/") for n in sorted(them)), topic, reason)
            + f". {remedy}."
            for (name, what, reason, remedy), them in found.items()
        )
    )


def is_matched(kind: str, qos: QoSProfile, subscription: Any) -> bool:
    """Return True if a subscription gets what is published as a type, by a QoS without deadline."""
    deadline = subscription.qos_profile.deadline.nanoseconds
    asks_deadline = 0 < deadline < _ENDLESS
    publisher = SimpleNamespace(topic_type=kind, qos_profile=qos)
    return not asks_deadline and _unmatched(publisher, subscription) is None


def _unmatched(publisher: Any, subscription: Any) -> tuple[str, str, str] | None:
    """Return why DDS does not match a publisher with a subscription; None if it does."""
    wanted, given = subscription.topic_type, publisher.topic_type
    if wanted != given:
        return (
            _HEARS_NOTHING,
            f"it subscribes to {wanted}, published is {given}",
            "Use one type in both",
        )
    for policy, asked, offered in _UNMATCHED:
        wants, has = (getattr(end.qos_profile, policy) for end in (subscription, publisher))
        if (wants, has) == (asked, offered):
            return (
                _HEARS_NOTHING,
                f"it asks for {asked.name}, published is {offered.name}",
                f"Publish {asked.name}, or subscribe with {offered.name}",
            )
    return None


def _another_version(publisher: Any, subscription: Any) -> tuple[str, str, str] | None:
    """Return the same as `_unmatched` for two versions of one type; None for one version."""
    kind, wanted, given = subscription.topic_type, _hash(subscription), _hash(publisher)
    if not (wanted and given) or wanted == given or publisher.topic_type != kind:
        return None
    reason = f"its {kind} is another version, hash {wanted}, published is {given}"
    package = package_of(kind)
    return _MISREADS, reason, f"Build both with one version of {package}"


def _hash(info: Any) -> str:
    """Return the first eight digits of a type's hash; "" before ROS 2 Iron, or if DDS has none."""
    version, _, digits = str(getattr(info, "topic_type_hash", "")).partition("_")
    return digits[:_SHOWN] if version.startswith("RIHS") else ""
