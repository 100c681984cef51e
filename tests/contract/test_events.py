"""What endpoints are told: who matches, and who does not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from std_msgs.msg import String

from tests.support.ros import Ros
from tests.support.waiting import wait_until

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1)
SECOND, TWO_SECONDS = Duration(seconds=1), Duration(seconds=2)
Told = list[tuple[Any, ...]]


def test_endpoints_are_told_who_does_not_match(ros: Ros) -> None:
    node = ros.node()
    told: Told = []

    def refused(who: str) -> Callable[[Any], None]:
        return lambda e: told.append((who, e.total_count, int(e.last_policy_kind)))

    publisher = node.create_publisher(
        String,
        "words",
        BEST_EFFORT,
        event_callbacks=PublisherEventCallbacks(incompatible_qos=refused("publisher")),
    )
    ros.spin(node)
    node.create_subscription(
        String,
        "words",
        lambda _: None,
        RELIABLE,
        event_callbacks=SubscriptionEventCallbacks(incompatible_qos=refused("subscription")),
    )
    wait_until(lambda: len(told) == 2)
    kind = int(QoSPolicyKind.RELIABILITY)
    assert sorted(told) == [("publisher", 1, kind), ("subscription", 1, kind)]
    assert publisher.get_subscription_count() == 0


def test_a_subscription_that_asks_for_more_is_told_for_which_policy(ros: Ros) -> None:
    node = ros.node()
    told: dict[str, str] = {}
    manual = LivelinessPolicy.MANUAL_BY_TOPIC
    cases: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
        ("RELIABILITY", {"reliability": ReliabilityPolicy.BEST_EFFORT}, {}),
        ("DURABILITY", {}, {"durability": DurabilityPolicy.TRANSIENT_LOCAL}),
        ("DEADLINE", {}, {"deadline": SECOND}),
        ("DEADLINE", {"deadline": TWO_SECONDS}, {"deadline": SECOND}),
        ("LIVELINESS", {"liveliness": LivelinessPolicy.AUTOMATIC}, {"liveliness": manual}),
        ("LIVELINESS", {}, {"liveliness_lease_duration": SECOND}),
        ("", {"deadline": SECOND}, {"deadline": TWO_SECONDS}),
        ("", {"liveliness": manual, "liveliness_lease_duration": SECOND}, {"liveliness": manual}),
    ]
    for number, (policy, offered, requested) in enumerate(cases):
        topic = f"topic_{number}"

        def refused(event: Any, topic: str = topic) -> None:
            told[topic] = QoSPolicyKind(event.last_policy_kind).name

        callbacks = SubscriptionEventCallbacks(incompatible_qos=refused)
        publisher = node.create_publisher(String, topic, QoSProfile(depth=1, **offered))
        profile = QoSProfile(depth=1, **requested)
        node.create_subscription(String, topic, print, profile, event_callbacks=callbacks)
        if not policy:
            wait_until(lambda p=publisher: p.get_subscription_count() == 1)  # type: ignore[misc]
    ros.spin(node)
    refusals = {f"topic_{n}": policy for n, (policy, *_) in enumerate(cases) if policy}
    wait_until(lambda: told == refusals)
