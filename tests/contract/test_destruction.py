"""What is destroyed says so to whoever uses it: by `destroy()`, and by the context's shutdown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.action import ActionClient
from rclpy.node import Node
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

from tests.support.clock import pass_time
from tests.support.ros import Ros

Use = Callable[[Any], Any]

USES: dict[str, tuple[Callable[[Node], Any], list[Use]]] = {
    "publisher": (
        lambda n: n.create_publisher(Int32, "a", 1),
        [
            lambda p: p.publish(Int32()),
            lambda p: p.get_subscription_count(),
            lambda p: p.assert_liveliness(),
            lambda p: p.wait_for_all_acked(),
        ],
    ),
    "subscription": (
        lambda n: n.create_subscription(Int32, "a", lambda _: None, 1),
        [lambda s: s.get_publisher_count()],
    ),
    "client": (
        lambda n: n.create_client(Trigger, "a"),
        [
            lambda c: c.call_async(Trigger.Request()),
            lambda c: c.service_is_ready(),
            lambda c: c.wait_for_service(0.1),
        ],
    ),
    "service": (lambda n: n.create_service(Trigger, "a", lambda _, answer: answer), []),
    "timer": (
        lambda n: n.create_timer(1.0, print),
        [
            lambda t: t.cancel(),
            lambda t: t.reset(),
            lambda t: t.is_ready(),
            lambda t: t.is_canceled(),
            lambda t: t.timer_period_ns,
            lambda t: t.time_since_last_call(),
            lambda t: t.time_until_next_call(),
        ],
    ),
}
OF_A_NODE: list[Use] = [
    lambda n: n.get_name(),
    lambda n: n.get_namespace(),
    lambda n: n.get_fully_qualified_name(),
    lambda n: n.get_node_names(),
    lambda n: n.get_topic_names_and_types(),
    lambda n: n.get_service_names_and_types(),
    lambda n: n.count_publishers("a"),
    lambda n: n.resolve_topic_name("a"),
    lambda n: n.get_publisher_names_and_types_by_node("node", "/"),
]


@pytest.mark.parametrize("kind", USES)
def test_what_its_node_destroyed_cannot_be_used(kind: str, ros: Ros) -> None:
    make, uses = USES[kind]
    node = ros.node()
    thing = make(node)
    assert getattr(node, f"destroy_{kind}")(thing)
    assert not getattr(node, f"destroy_{kind}")(thing)
    for use in uses:
        with pytest.raises(InvalidHandle):
            use(thing)


def test_a_destroyed_node_cannot_be_asked(ros: Ros) -> None:
    node = ros.node()
    for use in OF_A_NODE:
        use(node)
    node.destroy_node()
    node.destroy_node()
    for use in OF_A_NODE:
        with pytest.raises(InvalidHandle):
            use(node)


def test_a_shutdown_destroys_nodes_and_all_that_they_made(ros: Ros) -> None:
    node = ros.node()
    made = [(make(node), uses) for make, uses in USES.values()]
    ros.context.try_shutdown()
    for thing, uses in [*made, (node, OF_A_NODE)]:
        for use in uses:
            with pytest.raises(InvalidHandle):
                use(thing)
    node.get_logger().info("a node may still log")
    node.destroy_node()


def test_a_destroyed_action_client_neither_sends_nor_waits(ros: Ros) -> None:
    client = ActionClient(ros.node(), MoveToShelf, "move")
    client.destroy()
    for use in (
        lambda: client.send_goal_async(MoveToShelf.Goal()),
        lambda: client.server_is_ready(),
        lambda: client.wait_for_server(0.1),
    ):
        with pytest.raises(RCLError):
            use()


def test_a_node_that_is_destroyed_in_a_timer_runs_no_other_timer(ros: Ros) -> None:
    node = ros.node()
    ran: list[int] = []

    def end() -> None:
        ran.append(1)
        node.destroy_node()

    for _ in range(2):
        node.create_timer(0.01, end)
    executor = ros.executor(node)
    pass_time(0.05)  # both are due
    for _ in range(4):
        executor.spin_once(timeout_sec=0.05)
    assert ran == [1]
