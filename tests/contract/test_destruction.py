"""What is destroyed says so to whoever uses it: by `destroy()`, and by the context's shutdown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

from tests.support.clock import pass_time
from tests.support.ros import Ros
from tests.support.waiting import wait_until

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


@pytest.mark.parametrize("use", OF_A_NODE)
def test_a_destroyed_node_cannot_be_asked(use: Use, ros: Ros) -> None:
    node = ros.node()
    use(node)
    node.destroy_node()
    node.destroy_node()
    with pytest.raises(InvalidHandle):
        use(node)


@pytest.mark.parametrize("kind", [kind for kind, (_, uses) in USES.items() if uses])
def test_a_shutdown_destroys_all_there_is(kind: str, ros: Ros) -> None:
    make, uses = USES[kind]
    thing = make(ros.node())
    ros.context.try_shutdown()
    for use in uses:
        with pytest.raises(InvalidHandle):
            use(thing)


@pytest.mark.parametrize("use", OF_A_NODE)
def test_a_shutdown_destroys_the_nodes(use: Use, ros: Ros) -> None:
    node = ros.node()
    ros.context.try_shutdown()
    with pytest.raises(InvalidHandle):
        use(node)
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


def test_a_nodes_own_endpoints_are_counted_without_those_of_its_actions(ros: Ros) -> None:
    node = ros.node()
    kinds = ("publishers", "subscriptions", "services", "clients")
    before = [len(list(getattr(node, kind))) for kind in kinds]
    server = ActionServer(node, MoveToShelf, "move", print)
    client = ActionClient(node, MoveToShelf, "move")
    assert [len(list(getattr(node, kind))) for kind in kinds] == before
    node.create_publisher(Int32, "a", 1)
    node.create_client(Trigger, "a")
    after = [len(list(getattr(node, kind))) for kind in kinds]
    assert after == [before[0] + 1, before[1], before[2], before[3] + 1]
    client.destroy()
    server.destroy()


def test_an_executor_lists_a_destroyed_node_until_it_is_removed(ros: Ros) -> None:
    node = ros.node()
    executor = ros.executor(node)
    ticks: list[int] = []
    node.create_timer(0.0, lambda: ticks.append(1))
    node.destroy_node()
    assert executor.get_nodes() == [node]
    assert node.executor is executor
    executor.spin_once(timeout_sec=0.0)
    assert ticks == []
    executor.remove_node(node)
    assert executor.get_nodes() == []


@pytest.mark.parametrize("destroys", ["service", "node"])
def test_a_service_that_is_destroyed_in_its_own_callback_ends_the_spinning(
    destroys: str, ros: Ros
) -> None:
    node, other = ros.node("server"), ros.node("client")

    def end(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if destroys == "node":
            node.destroy_node()
        else:
            node.destroy_service(service)
        return response

    service = node.create_service(Trigger, "end", end)
    client = other.create_client(Trigger, "end")
    wait_until(client.service_is_ready)
    future = client.call_async(Trigger.Request())
    executor = ros.executor(node)
    with pytest.raises(InvalidHandle):
        ros.spin_here(executor, lambda: False)
    assert not future.done()


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
