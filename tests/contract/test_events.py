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


def test_endpoints_are_told_who_matches_and_who_does_not(ros: Ros) -> None:
    node = ros.node()
    told: Told = []

    def matched(who: str) -> Callable[[Any], None]:
        return lambda e: told.append((who, e.total_count, e.current_count, e.current_count_change))

    def refused(who: str) -> Callable[[Any], None]:
        return lambda e: told.append((who, e.total_count, int(e.last_policy_kind)))

    publisher = node.create_publisher(
        String,
        "words",
        BEST_EFFORT,
        event_callbacks=PublisherEventCallbacks(
            matched=matched("pub"), incompatible_qos=refused("pub refused")
        ),
    )
    ros.spin(node)
    subscription = node.create_subscription(
        String,
        "words",
        lambda _: None,
        BEST_EFFORT,
        event_callbacks=SubscriptionEventCallbacks(matched=matched("sub")),
    )
    wait_until(lambda: len(told) == 2)
    assert sorted(told) == [("pub", 1, 1, 1), ("sub", 1, 1, 1)]
    node.create_subscription(
        String,
        "words",
        lambda _: None,
        RELIABLE,
        event_callbacks=SubscriptionEventCallbacks(incompatible_qos=refused("sub refused")),
    )
    wait_until(lambda: len(told) == 4)
    kind = int(QoSPolicyKind.RELIABILITY)
    assert sorted(told[2:]) == [("pub refused", 1, kind), ("sub refused", 1, kind)]
    node.destroy_subscription(subscription)
    wait_until(lambda: len(told) == 5)
    assert told[4] == ("pub", 1, 0, -1)
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
    for number, (_, offered, requested) in enumerate(cases):
        topic = f"topic_{number}"

        def matched(event: Any, topic: str = topic) -> None:
            told[topic] = ""

        def refused(event: Any, topic: str = topic) -> None:
            told[topic] = QoSPolicyKind(event.last_policy_kind).name

        callbacks = SubscriptionEventCallbacks(matched=matched, incompatible_qos=refused)
        node.create_publisher(String, topic, QoSProfile(depth=1, **offered))
        profile = QoSProfile(depth=1, **requested)
        node.create_subscription(String, topic, print, profile, event_callbacks=callbacks)
    ros.spin(node)
    wait_until(lambda: len(told) == len(cases))
    assert [told[f"topic_{n}"] for n in range(len(cases))] == [policy for policy, *_ in cases]
