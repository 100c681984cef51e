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


def mismatches(
    topic: str, publishers: Iterable[Any], subscriptions: Iterable[Any]
) -> tuple[str, ...]:
    """Describe each subscription that hears nothing of a publisher, and what to change.

    Args:
        topic: Its full name.
        publishers: An rclpy `TopicEndpointInfo` each, as for `subscriptions`.
        subscriptions: Those of hidden nodes, consoles among them, are left out.

    Returns:
        A sentence for each subscribing node and reason, sorted; it names all publishers.
    """
    found: dict[tuple[str, str, str], set[str]] = {}
    offered = list(publishers)
    for subscription in subscriptions:
        node = _node(subscription)
        if "/_" in node:
            continue
        for publisher in offered:
            if reason := _reason(publisher, subscription):
                found.setdefault((node, *reason), set()).add(_node(publisher))
    return tuple(
        sorted(
            f"{node.lstrip('/')} hears nothing of {', '.join(n.lstrip('/') for n in sorted(them))}"
            f" on {topic}: {reason}. {remedy}."
            for (node, reason, remedy), them in found.items()
        )
    )


def _reason(publisher: Any, subscription: Any) -> tuple[str, str] | None:
    """Return why the two do not match and what mends it; None when they do."""
    wanted, given = subscription.topic_type, publisher.topic_type
    if wanted != given:
        return f"it subscribes to {wanted}, published is {given}", "Use one type in both"
    for policy, asked, offered in _UNMATCHED:
        wants, has = (getattr(end.qos_profile, policy) for end in (subscription, publisher))
        if (wants, has) == (asked, offered):
            return (
                f"it asks for {asked.name}, published is {offered.name}",
                f"Publish {asked.name}, or subscribe with {offered.name}",
            )
    return None


def _node(info: Any) -> str:
    return in_namespace(info.node_namespace, info.node_name)
