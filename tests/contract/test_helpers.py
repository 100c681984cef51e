"""The small things of rclpy that ordinary nodes use beside the four means of talking."""

from __future__ import annotations

import threading
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import InvalidTopicNameException, ROSInterruptException
from rclpy.executors import SingleThreadedExecutor
from rclpy.expand_topic_name import expand_topic_name
from rclpy.logging import LoggingSeverity
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from rclpy.validate_topic_name import validate_topic_name
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int32

from tests.support.ros import Ros
from tests.support.waiting import wait_until


def test_spinning_once_with_its_own_executor_leaves_the_node_in_it(ros: Ros) -> None:
    node, executor = ros.node(), SingleThreadedExecutor(context=ros.context)
    executor.add_node(node)
    rclpy.spin_once(node, executor=executor, timeout_sec=0.01)
    done: Future[int] = Future()
    done.set_result(1)
    rclpy.spin_until_future_complete(node, done, executor)
    assert node in executor.get_nodes()
    assert node.executor is executor
    executor.shutdown(0)


def test_between_two_spins_a_task_can_be_given_to_the_nodes_executor(ros: Ros) -> None:
    node, executor = ros.node(), SingleThreadedExecutor(context=ros.context)
    rclpy.spin_once(node, executor=executor, timeout_sec=0.01)
    ran: list[int] = []
    assert node.executor is executor
    node.executor.create_task(lambda: ran.append(1))
    rclpy.spin_once(node, executor=executor, timeout_sec=1.0)
    assert ran == [1]
    executor.shutdown(0)


def test_many_short_spins_leave_nothing_behind_of_a_timer(ros: Ros) -> None:
    node, executor = ros.node(), SingleThreadedExecutor(context=ros.context)
    ticks: list[int] = []
    node.create_timer(0.01, lambda: ticks.append(1))
    for _ in range(200):
        rclpy.spin_once(node, executor=executor, timeout_sec=0.0)
    assert len(getattr(executor, "_timers", ())) <= 1  # the embedded engine's heap
    ticks.clear()
    rclpy.spin_once(node, executor=executor, timeout_sec=1.0)
    assert ticks == [1]
    executor.shutdown(0)


def test_an_executor_that_is_assigned_runs_the_node(ros: Ros) -> None:
    node, executor = ros.node(), SingleThreadedExecutor(context=ros.context)
    node.executor = executor
    assert node in executor.get_nodes()
    node.executor = None
    assert node not in executor.get_nodes()
    executor.shutdown(0)


def test_a_long_wait_for_a_future_leaves_one_callback_on_it(ros: Ros) -> None:
    node, executor = ros.node(), SingleThreadedExecutor(context=ros.context)
    executor.add_node(node)
    node.create_timer(0.01, lambda: None)
    future: Future[int] = Future()
    executor.spin_until_future_complete(future, 0.3)
    assert len(future._callbacks) == 1
    executor.shutdown(0)


@pytest.mark.real_time
def test_a_future_that_another_thread_sets_ends_the_spin_at_once(ros: Ros) -> None:
    executor = SingleThreadedExecutor(context=ros.context)
    executor.add_node(ros.node())
    future: Future[int] = Future()
    setter = threading.Timer(0.05, lambda: future.set_result(1))
    setter.start()
    executor.spin_once_until_future_complete(future, 60.0)
    assert future.done()
    setter.join()
    executor.shutdown(0)


def test_a_rate_sleeps_from_tick_to_tick_until_the_end(ros: Ros) -> None:
    node = ros.spun()
    rate = node.create_rate(50.0)
    slept: list[int] = []

    def work() -> None:
        try:
            while True:
                rate.sleep()
                slept.append(1)
        except ROSInterruptException:
            slept.append(-1)

    thread = threading.Thread(target=work)
    thread.start()
    wait_until(lambda: len(slept) >= 3)
    ros.context.try_shutdown()
    thread.join(10)
    assert slept[-1] == -1


def test_a_clock_sleeps(ros: Ros) -> None:
    node = ros.node()
    clock = node.get_clock()
    before = clock.now()
    assert clock.sleep_for(Duration(nanoseconds=20_000_000), ros.context)
    assert clock.now() - before >= Duration(nanoseconds=19_000_000)


def test_a_guard_condition_runs_its_callback_once_for_all_triggers(ros: Ros) -> None:
    node, executor = ros.node(), SingleThreadedExecutor(context=ros.context)
    ran: list[int] = []
    guard = node.create_guard_condition(lambda: ran.append(1))
    guard.trigger()
    guard.trigger()
    executor.add_node(node)
    while not ran:
        executor.spin_once(1.0)
    executor.spin_once(0.02)
    assert ran == [1]
    executor.shutdown(0)


def test_one_message_is_waited_for(ros: Ros) -> None:
    node, talker = ros.node("waiting"), ros.node("talker")
    publisher = talker.create_publisher(Int32, "topic", 1)
    talker.create_timer(0.02, lambda: publisher.publish(Int32(data=7)))
    ros.spin(talker)
    found, message = wait_for_message(Int32, node, "topic", time_to_wait=30.0)
    assert (found, message.data) == (True, 7)
    assert wait_for_message(Int32, node, "silence", time_to_wait=0.05) == (False, None)


def test_a_node_is_waited_for(ros: Ros) -> None:
    node = ros.node("here")
    ros.node("there")
    assert node.wait_for_node("/there", 10.0)
    assert not node.wait_for_node("/nowhere", 0.1)


def test_parameters_are_found_by_their_prefix(ros: Ros) -> None:
    node = ros.node()
    node.declare_parameter("arm.left.speed", 1.0)
    node.declare_parameter("arm.right", 2.0)
    node.declare_parameter("armature", 3.0)
    found = node.get_parameters_by_prefix("arm")
    assert {name: p.value for name, p in found.items()} == {"left.speed": 1.0, "right": 2.0}


def test_a_parameter_of_a_name_only_is_warned_of_and_takes_any_type(ros: Ros) -> None:
    node = ros.node()
    with pytest.warns(UserWarning, match="only providing its name"):
        node.declare_parameter("any")
    for value in (1, "two"):
        (result,) = node.set_parameters([Parameter("any", value=value)])
        assert result.successful


def test_what_is_not_declared_may_be_described_where_that_is_allowed(ros: Ros) -> None:
    node = ros.node(allow_undeclared_parameters=True)
    assert node.describe_parameter("nothing").name == ""


def test_a_nodes_publishers_are_those_that_it_made_and_its_parameters(ros: Ros) -> None:
    node = ros.node()
    node.create_publisher(Int32, "topic", 1)
    assert sorted(p.topic_name for p in node.publishers) == ["/parameter_events", "/topic"]


def test_a_line_is_logged_at_a_severity(ros: Ros) -> None:
    logger = ros.node().get_logger()
    assert logger.log("x", LoggingSeverity.INFO)
    assert not logger.log("x", LoggingSeverity.DEBUG)


def test_init_returns_what_ends_it_again() -> None:
    context = Context()
    with rclpy.init(args=[], context=context) as begun:
        assert begun.context is context
        assert context.ok()
    assert not context.ok()


def test_names_are_checked_expanded_and_arguments_sorted_out() -> None:
    assert expand_topic_name("~/x", "node", "/ns") == "/ns/node/x"
    with pytest.raises(InvalidTopicNameException):
        validate_topic_name("a b")
    words: list[Any] = ["a", "--ros-args", "-r", "x:=y", "--", "b"]
    assert remove_ros_args(words) == ["a", "b"]
