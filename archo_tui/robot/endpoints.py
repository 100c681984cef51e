"""Publishers and subscriptions of one topic that get no message from each other. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from archo_tui.robot.state import in_namespace

# what a subscription asks for, and what a publisher offers, where DDS does not match the two
_UNMATCHED = (
    ("reliability", ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT),
    ("durability", DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE),
)
# subscriber, publishers, topic, why
_HEARS_NOTHING = "{} hears nothing of {} on {}: {}"
_MISREADS = "{} may misread {} on {}: {}"
_SHOWN = 8  # digits of a type hash that are shown: two versions of a type differ in them
_OWN = "this console"


def mismatches(
    topic: str, publishers: Iterable[Any], subscriptions: Iterable[Any], console: str = ""
) -> tuple[str, ...]:
    """Describe each subscription that does not get what a publisher means, and what to change.

    It hears nothing where types or QoS differ. Where both name one type and have other versions of
    it, a field more for one, DDS delivers all the same, and what is read may be wrong.

    Args:
        topic: Its full name.
        publishers: An rclpy `TopicEndpointInfo` each, as for `subscriptions`.
        subscriptions: Those of hidden nodes are left out.
        console: The full name of this console's node, which is hidden and not left out. Its QoS
            fits always, and whoever reads the topic says where the type does not.

    Returns:
        A sentence for each subscribing node and reason, sorted; it names all publishers.
    """
    found: dict[tuple[str, str, str, str], set[str]] = {}
    offered = list(publishers)
    for subscription in subscriptions:
        node = _node(subscription)
        is_own = node == console
        if "/_" in node and not is_own:
            continue
        for publisher in offered:
            reason = None if is_own else _unmatched(publisher, subscription)
            reason = reason or _another_version(publisher, subscription)
            if reason is not None:
                name = _OWN if is_own else node.lstrip("/")
                found.setdefault((name, *reason), set()).add(_node(publisher))
    return tuple(
        sorted(
            what.format(name, ", ".join(n.lstrip("/") for n in sorted(them)), topic, reason)
            + f". {remedy}."
            for (name, what, reason, remedy), them in found.items()
        )
    )


def _unmatched(publisher: Any, subscription: Any) -> tuple[str, str, str] | None:
    """Return what happens where DDS does not match the two, why, and what mends it."""
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
    """Return as `_unmatched` does, where the two have different versions of one type."""
    kind, wanted, given = subscription.topic_type, _hash(subscription), _hash(publisher)
    if not (wanted and given) or wanted == given or publisher.topic_type != kind:
        return None
    reason = f"its {kind} is another version, hash {wanted}, published is {given}"
    package = kind.partition("/")[0]
    return _MISREADS, reason, f"Build both with one version of {package}"


def _hash(info: Any) -> str:
    """Return the first digits of a type's hash; empty before Iron, and where DDS has none.

    In full it is `RIHS01_` and 64 digits (REP 2016), or `INVALID`.
    """
    version, _, digits = str(getattr(info, "topic_type_hash", "")).partition("_")
    return digits[:_SHOWN] if version.startswith("RIHS") else ""


def _node(info: Any) -> str:
    return in_namespace(info.node_namespace, info.node_name)
