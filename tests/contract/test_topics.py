"""Rules 2 and 4: delivery in a later turn, history depth, durability, QoS that must match."""

from __future__ import annotations

import threading

import pytest
from rcl_interfaces.msg import Log
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float32, Int32

from tests.support.ros import Ros
from tests.support.waiting import wait_until

LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT)


def test_nothing_is_delivered_inside_publish(ros: Ros) -> None:
    node = ros.node()
    events: list[str] = []
    done = threading.Event()
    publisher = node.create_publisher(Int32, "chain", 10)

    def on_message(message: Int32) -> None:
        events.append(f"begin {message.data}")
        if message.data < 2:
            publisher.publish(Int32(data=message.data + 1))
        else:
            done.set()
        events.append(f"end {message.data}")

    node.create_subscription(Int32, "chain", on_message, 10)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    publisher.publish(Int32(data=0))
    wait_until(lambda: events and events[-1] == "end 2")
    assert events == ["begin 0", "end 0", "begin 1", "end 1", "begin 2", "end 2"]


@pytest.mark.parametrize("depth", [1, 3])
def test_an_unspun_subscription_keeps_the_last_depth_messages(ros: Ros, depth: int) -> None:
    node = ros.node()
    publisher, received = ros.topic(Int32, node, qos=depth)
    for number in range(10):
        publisher.publish(Int32(data=number))
    ros.spin(node)
    wait_until(lambda: received and received[-1].data == 9)
    assert [message.data for message in received] == [*range(10 - depth, 10)]


def test_a_transient_local_publisher_serves_late_joiners_that_ask(ros: Ros) -> None:
    late: list[int] = []
    volatile: list[int] = []
    node = ros.node()
    publisher = node.create_publisher(Int32, "topic", LATCHED)
    for number in range(5):
        publisher.publish(Int32(data=number))
    node.create_subscription(Int32, "topic", lambda m: late.append(m.data), LATCHED)
    node.create_subscription(Int32, "topic", lambda m: volatile.append(m.data), 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    ros.spin(node)
    wait_until(lambda: len(late) == 3)
    publisher.publish(Int32(data=5))
    wait_until(lambda: late[-1] == 5 and volatile)
    assert late == [2, 3, 4, 5]
    assert volatile == [5]


@pytest.mark.parametrize(
    ("offered", "requested", "policy"),
    [(10, LATCHED, "DURABILITY"), (BEST_EFFORT, 10, "RELIABILITY")],
)
def test_incompatible_qos_does_not_connect_and_says_so(
    ros: Ros, offered: QoSProfile | int, requested: QoSProfile, policy: str
) -> None:
    received: list[Int32] = []
    logs: list[str] = []
    listener = ros.node("listener")
    listener.create_subscription(Log, "/rosout", lambda m: logs.append(m.msg), 100)
    node = ros.node("node")
    ros.spin(listener, node)
    publisher = node.create_publisher(Int32, "topic", offered)
    node.create_subscription(Int32, "topic", received.append, requested)
    wait_until(lambda: any("incompatible QoS" in line and policy in line for line in logs))
    publisher.publish(Int32(data=1))
    assert publisher.get_subscription_count() == 0
    assert received == []


@pytest.mark.parametrize(("offered", "requested"), [(LATCHED, 10), (10, BEST_EFFORT)])
def test_a_subscription_that_asks_less_connects(
    ros: Ros, offered: QoSProfile | int, requested: QoSProfile | int
) -> None:
    node = ros.node()
    publisher = node.create_publisher(Int32, "topic", offered)
    node.create_subscription(Int32, "topic", lambda m: None, requested)
    wait_until(lambda: publisher.get_subscription_count() == 1)


def test_a_destroyed_subscription_gets_nothing(ros: Ros) -> None:
    received: list[int] = []
    node = ros.node()
    gone = node.create_subscription(Int32, "topic", lambda m: received.append(-1), 10)
    node.create_subscription(Int32, "topic", lambda m: received.append(m.data), 10)
    publisher = node.create_publisher(Int32, "topic", 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    assert node.destroy_subscription(gone)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    publisher.publish(Int32(data=1))
    wait_until(lambda: received)
    assert received == [1]


def test_publishing_on_what_was_destroyed_or_shut_down_raises(ros: Ros) -> None:
    node = ros.node()
    gone = node.create_publisher(Float32, "topic", 10)
    node.destroy_publisher(gone)
    with pytest.raises(Exception, match="destruction was requested"):
        gone.publish(Float32())
    publisher = node.create_publisher(Float32, "topic", 10)
    ros.context.shutdown()
    with pytest.raises(Exception, match=r"destruction was requested|context is invalid"):
        publisher.publish(Float32())


def test_a_late_joiner_gets_nothing_that_is_older_than_its_lifespan(ros: Ros) -> None:
    late: list[int] = []
    old: list[int] = []
    node = ros.node("n")
    short = QoSProfile(
        depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=0.2)
    )
    publisher = node.create_publisher(Int32, "topic", short)
    publisher.publish(Int32(data=1))
    watch = ros.node("watch")
    watch.create_timer(0.5, lambda: old.append(1))
    ros.spin(watch)
    wait_until(lambda: old)
    node.create_subscription(Int32, "topic", lambda m: late.append(m.data), LATCHED)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    publisher.publish(Int32(data=2))
    wait_until(lambda: late)
    assert late == [2]


def test_a_node_added_to_an_executor_late_gets_what_waits(ros: Ros) -> None:
    node = ros.node()
    publisher, received = ros.topic(Int32, node)
    publisher.publish(Int32(data=1))
    ros.executor(node).spin_once(timeout_sec=10)
    assert received == [Int32(data=1)]
