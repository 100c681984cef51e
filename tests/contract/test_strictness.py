"""What ROS 2 refuses, also of what was destroyed, is refused here by the same exception."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from archo_interfaces.action import MoveToShelf
from rcl_interfaces.msg import Log
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.action import ActionClient, ActionServer
from rclpy.clock import Clock
from rclpy.duration import Duration
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, InvalidQoSProfileException, QoSProfile
from rclpy.time import Time
from std_msgs.msg import Int32, Int32MultiArray
from std_srvs.srv import Trigger

from tests.support.clock import pass_time
from tests.support.ros import Ros

Profile: Any = QoSProfile  # what is asked of them is wrong on purpose
Stamp: Any = Time
Number: Any = Duration
AnyClock: Any = Clock
MultiArray: Any = Int32MultiArray
NO_CLOCK: Any = {"throttle_time_source_type": "STEADY_TIME"}
Question = Callable[[Node], Any]
A_SECOND = Duration(seconds=1)


def _say(node: Node, level: str) -> object:
    """One place in the source that logs."""
    return getattr(node.get_logger(), level)("x")


@pytest.mark.parametrize(
    ("ask", "error"),
    [
        (lambda _: Profile(), InvalidQoSProfileException),
        (lambda _: Profile(depth=1, lifespan="x"), AssertionError),
        (lambda _: Profile(depth=1, reliability="reliable"), AssertionError),
        (lambda _: Profile(depth=1.5), AssertionError),
        (lambda n: n.create_publisher(int, "a", 1), AttributeError),
        (lambda n: n.create_publisher(Trigger, "a", 1), RuntimeError),
        (lambda n: n.create_publisher(Int32, "a", "1"), TypeError),
        (lambda n: n.create_publisher(Int32, "a", -1), ValueError),
        (lambda n: n.create_publisher(Int32, "a", 1).publish(Log()), TypeError),
        (lambda n: n.count_publishers(3), TypeError),
        (lambda _: AnyClock(clock_type=3), (TypeError, ValueError)),
        (lambda n: n.create_publisher(Int32, "a" * 300, 1), InvalidTopicNameException),
        (lambda n: n.create_subscription(int, "a", print, 1), AttributeError),
        (lambda n: n.create_subscription(Int32, "a", None, 1), RuntimeError),
        (lambda n: n.create_subscription(Int32, "a", lambda: 0, 1), RuntimeError),
        (lambda n: n.create_service(Int32, "a", print), RuntimeError),
        (lambda n: n.create_service(MoveToShelf, "a", print), RuntimeError),  # no service
        (lambda n: n.create_client(Int32, "a"), RuntimeError),
        (lambda n: n.create_timer(-1.0, print), RCLError),
        (lambda n: n.get_logger().info(42), TypeError),
        (lambda n: n.get_logger().info("x", onec=True), TypeError),
        (lambda n: [n.get_logger().info("x", once=bool(i)) for i in (0, 1)], ValueError),
        (lambda n: n.create_client(Trigger, "a").call_async(Int32()), TypeError),
        (lambda _: Stamp() + Stamp(), TypeError),
        (lambda _: Stamp() < 1, TypeError),
        (lambda _: Stamp(seconds=-1), ValueError),
        (lambda _: Stamp(clock_type="STEADY_TIME"), TypeError),
        (lambda _: Stamp() - A_SECOND, ValueError),
        (lambda _: Stamp.from_msg(A_SECOND.to_msg()), TypeError),
        (lambda _: 2 * Number(seconds=1), TypeError),  # though a span times two is one
        (lambda n: n.create_publisher(Int32, "a//b", 1), InvalidTopicNameException),
        (lambda n: n.create_service(Trigger, "1a", print), InvalidServiceNameException),
        (lambda n: n.get_logger().get_child(""), ValueError),
        (lambda n: n.get_logger().set_level(25), ValueError),
        (lambda n: [_say(n, level) for level in ("error", "fatal")], ValueError),
        (lambda n: MultiThreadedExecutor(0, context=n.context), ValueError),
        (lambda _: setattr(Log, "WARN", Log.WARN), AttributeError),  # a constant
        (lambda _: Trigger(), NotImplementedError),
        (lambda n: ActionServer(n, MoveToShelf, "a?", print), ValueError),
        (lambda n: ActionServer(n, MoveToShelf, "a", NO_CLOCK), TypeError),
        (lambda n: ActionServer(n, MoveToShelf, "a", print, result_timeout=-1), ValueError),
    ],
)
def test_it_is_refused(ask: Question, error: Any, ros: Ros) -> None:
    node = ros.node()
    with pytest.raises(error):
        ask(node)


@pytest.mark.parametrize(
    ("ask", "value"),
    [
        (lambda _: Profile(history=HistoryPolicy.KEEP_ALL).depth, 10),
        (lambda n: n.create_publisher(Int32, "{node}/x", 1).topic_name.rpartition("/")[0], "/node"),
        (lambda _: Stamp(seconds=5) - A_SECOND, Stamp(seconds=4)),
        (lambda _: Stamp() == 1, False),
        (lambda n: n.create_publisher(Int32, "a", 1).topic, "a"),
        (lambda n: n.create_client(Trigger, "~/a").srv_name, "~/a"),
        (lambda n: n.create_client(Trigger, "~/a").service_name, "/node/a"),
        (lambda n: n.create_service(Trigger, "a", print).srv_name, "a"),
        (lambda n: repr(MultiArray(data=[1, 2])).rpartition("data=")[2], "[1, 2])"),
    ],
)
def test_it_is_granted(ask: Question, value: object, ros: Ros) -> None:
    assert ask(ros.node()) == value


def test_a_call_that_nobody_answers_in_time_raises(ros: Ros) -> None:
    with pytest.raises(TimeoutError):
        ros.node().create_client(Trigger, "a").call(Trigger.Request(), 0.05)


def test_spans_are_added_subtracted_and_multiplied() -> None:
    assert Duration(seconds=5) + A_SECOND == Duration(seconds=6)
    assert Duration(seconds=5) - A_SECOND == Duration(seconds=4)
    assert (A_SECOND * 2).nanoseconds == 2_000_000_000


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # rclpy's own
def test_after_shutdown_nothing_is_made_and_nothing_spins(ros: Ros) -> None:
    node = ros.node()
    ros.context.try_shutdown()
    with pytest.raises(RCLError):
        node.create_timer(1.0, print)
    with pytest.raises(InvalidHandle):
        node.create_publisher(Int32, "a", 1)
    with pytest.raises(RuntimeError):
        rclpy.executors.SingleThreadedExecutor(context=ros.context)


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
    makes = [make for kind, (make, _) in USES.items() if kind != "timer"]
    for use in (*OF_A_NODE, *makes, lambda n: n.declare_parameter("a", 1)):
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


def test_a_nodes_endpoints_are_its_own_without_those_of_its_actions(ros: Ros) -> None:
    node = ros.node()
    kinds = ("publishers", "subscriptions", "services", "clients")
    before = [len(list(getattr(node, kind))) for kind in kinds]
    ActionServer(node, MoveToShelf, "move", print)
    ActionClient(node, MoveToShelf, "move")
    node.create_publisher(Int32, "a", 1)
    after = [len(list(getattr(node, kind))) for kind in kinds]
    assert after == [before[0] + 1, *before[1:]]


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
