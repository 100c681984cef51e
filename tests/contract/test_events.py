"""What endpoints are told: who matches, what comes too late, who is alive."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any

import pytest
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import LivelinessPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from tests.support import clock
from tests.support.ros import Ros
from tests.support.waiting import wait_until

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1)
PERIOD = Duration(seconds=0.3)
LATE = QoSProfile(depth=1, deadline=PERIOD)
MANUAL = QoSProfile(
    depth=1,
    liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
    liveliness_lease_duration=PERIOD,
)
MANUAL_LONG = copy(MANUAL)
MANUAL_LONG.liveliness_lease_duration = Duration(seconds=60)
Told = list[tuple[Any, ...]]


def pair(node: Node, qos: QoSProfile, told: Told) -> Publisher[String]:
    """A publisher, and a subscription that it matches; each says what it is told."""

    def counts(who: str) -> Callable[[Any], None]:
        return lambda e: told.append((who, e.total_count, e.total_count_change))

    def alive(event: Any) -> None:
        told.append(("alive", event.alive_count, event.not_alive_count))

    node.create_subscription(
        String,
        "words",
        lambda _: told.append(("heard",)),
        qos,
        event_callbacks=SubscriptionEventCallbacks(deadline=counts("sub"), liveliness=alive),
    )
    publisher = node.create_publisher(
        String,
        "words",
        qos,
        event_callbacks=PublisherEventCallbacks(deadline=counts("pub"), liveliness=counts("lost")),
    )
    wait_until(lambda: publisher.get_subscription_count() == 1)
    return publisher


def pass_by(periods: float) -> None:
    clock.pass_time(periods * PERIOD.nanoseconds / 1e9)


def missed(told: Told, who: str) -> int:
    """How many periods it was told that it missed."""
    return max((one[1] for one in told if one[0] == who), default=0)


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


def test_a_deadline_counts_from_the_first_message_on_and_each_period_again(ros: Ros) -> None:
    told: Told = []
    node = ros.node()
    publisher = pair(node, LATE, told)
    ros.spin(node)
    pass_by(2)
    assert told == []
    publisher.publish(String())
    for who in ("pub", "sub"):
        wait_until(lambda who=who: missed(told, who) >= 3)  # type: ignore[misc]
        assert missed(told, who) == sum(one[2] for one in told if one[0] == who)
    node.destroy_publisher(publisher)
    offered, requested = missed(told, "pub"), missed(told, "sub")
    wait_until(lambda: missed(told, "sub") > requested + 1)
    assert missed(told, "pub") == offered


def test_deadlines_that_nobody_looked_for_are_told_at_once_before_the_message(ros: Ros) -> None:
    told: Told = []
    node = ros.node()
    executor = SingleThreadedExecutor(context=ros.context)
    executor.add_node(node)
    publisher = pair(node, LATE, told)
    for _ in range(4):
        told.clear()
        publisher.publish(String())
        pass_by(2.5)
        publisher.publish(String())
        ros.spin_here(executor, lambda: ("heard",) in told)
        before = told[: told.index(("heard",))]
        assert sorted(who for who, *_ in before) == ["pub", "sub"]
        assert all(change >= 2 for _, _, change in before)
    assert missed(told, "pub") >= 8


def test_messages_in_time_miss_no_deadline(ros: Ros) -> None:
    told: Told = []
    node = ros.node()
    publisher = pair(node, QoSProfile(depth=1, deadline=Duration(seconds=60)), told)
    ros.spin(node)
    for number in range(1, 4):
        publisher.publish(String())
        wait_until(lambda number=number: len(told) == number)  # type: ignore[misc]
    assert set(told) == {("heard",)}


def test_who_does_not_assert_liveliness_is_lost_and_comes_back(ros: Ros) -> None:
    told: Told = []
    node = ros.node()
    publisher = pair(node, MANUAL, told)
    ros.spin(node)
    pass_by(2)
    assert told == []
    for say in (lambda: publisher.publish(String()), publisher.assert_liveliness):
        lost = missed(told, "lost")
        told[:] = [one for one in told if one[0] == "lost"]
        wait_until(lambda say=say: say() or ("alive", 1, 0) in told)  # type: ignore[misc]
        wait_until(lambda: ("alive", 0, 1) in told)
        wait_until(lambda lost=lost: missed(told, "lost") > lost)  # type: ignore[misc]
    told.clear()
    node.destroy_publisher(publisher)
    wait_until(lambda: told)
    pass_by(2)
    assert told == [("alive", 0, 0)]


def test_each_word_counts_and_what_was_lost_meanwhile_is_told_later(ros: Ros) -> None:
    told: Told = []
    node = ros.node()
    publisher = pair(node, MANUAL, told)
    for _ in range(2):
        publisher.assert_liveliness()
        pass_by(1.5)
    ros.spin(node)
    wait_until(lambda: len(told) == 2)
    assert sorted(told) == [("alive", 0, 1), ("lost", 2, 2)]


def test_publishers_are_alive_each_for_itself(ros: Ros) -> None:
    told: Told = []
    node = ros.node()
    publishers = [pair(node, MANUAL_LONG, told)]
    publishers += [node.create_publisher(String, "words", MANUAL_LONG) for _ in range(3)]
    for one in publishers:
        wait_until(lambda one=one: one.get_subscription_count() == 1)  # type: ignore[misc]
    executor = ros.spin(node)
    for number, one in enumerate(publishers, 1):
        one.assert_liveliness()
        wait_until(lambda n=number: told[-1:] == [("alive", n, 0)])  # type: ignore[misc]
    assert len(getattr(executor, "_timers", ())) <= 2  # the embedded engine's heap


@pytest.mark.parametrize(
    "liveliness", [LivelinessPolicy.AUTOMATIC, LivelinessPolicy.MANUAL_BY_TOPIC]
)
def test_only_who_must_assert_liveliness_loses_its_lease(
    ros: Ros, liveliness: LivelinessPolicy
) -> None:
    told: Told = []
    node = ros.node()
    node.create_subscription(
        String,
        "words",
        lambda _: None,
        10,
        event_callbacks=SubscriptionEventCallbacks(liveliness=lambda _: told.append(("sub",))),
    )
    publisher = node.create_publisher(
        String,
        "words",
        QoSProfile(depth=1, liveliness=liveliness, liveliness_lease_duration=PERIOD),
        event_callbacks=PublisherEventCallbacks(liveliness=lambda _: told.append(("pub",))),
    )
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    publisher.publish(String())
    pass_by(2)
    if liveliness == LivelinessPolicy.MANUAL_BY_TOPIC:
        wait_until(lambda: told)
        assert told == [("pub",)]
    else:
        assert told == []


@pytest.mark.parametrize(
    ("given", "publisher", "subscription"),
    [
        ({}, 2, 2),
        ({"use_default_callbacks": False}, 0, 0),
        ({"deadline": print}, 3, 3),
        ({"deadline": print, "liveliness": print, "incompatible_qos": print}, 4, 4),
        ({"matched": print, "use_default_callbacks": False}, 1, 1),
    ],
)
def test_an_endpoint_has_a_handler_for_each_callback_and_two_by_default(
    ros: Ros, given: dict[str, Any], publisher: int, subscription: int
) -> None:
    node = ros.node()
    published = node.create_publisher(
        String, "words", 10, event_callbacks=PublisherEventCallbacks(**given)
    )
    heard = node.create_subscription(
        String, "words", lambda _: None, 10, event_callbacks=SubscriptionEventCallbacks(**given)
    )
    assert len(published.event_handlers) == publisher
    assert len(heard.event_handlers) == subscription
