"""The small things that ordinary nodes use, their loggers, and what the graph names."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
import rclpy.logging
from rcl_interfaces.msg import Log, LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import ROSInterruptException
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import LoggingSeverity
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Float32, Int32
from std_srvs.srv import Trigger

from tests.support.ros import Ros
from tests.support.waiting import wait_until


def test_spinning_once_with_its_own_executor_leaves_the_node_in_it(ros: Ros) -> None:
    node = ros.node()
    executor = ros.executor(node)
    rclpy.spin_once(node, executor=executor, timeout_sec=0.01)
    done: Future[int] = Future()
    done.set_result(1)
    rclpy.spin_until_future_complete(node, done, executor)
    assert node in executor.get_nodes()
    assert node.executor is executor


@pytest.mark.real_time
def test_a_future_that_another_thread_sets_ends_the_spin_at_once(ros: Ros) -> None:
    executor = ros.executor(ros.node())
    future: Future[int] = Future()
    setter = threading.Timer(0.05, lambda: future.set_result(1))
    setter.start()
    executor.spin_once_until_future_complete(future, 60.0)
    assert future.done()
    setter.join()


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


def test_parameters_are_found_by_their_prefix(ros: Ros) -> None:
    node = ros.node()
    node.declare_parameter("arm.left.speed", 1.0)
    node.declare_parameter("arm.right", 2.0)
    node.declare_parameter("armature", 3.0)
    found = node.get_parameters_by_prefix("arm")
    assert {name: p.value for name, p in found.items()} == {"left.speed": 1.0, "right": 2.0}


def test_init_returns_what_ends_it_again() -> None:
    context = Context()
    no = SignalHandlerOptions.NO
    begun = rclpy.init(args=[], context=context, signal_handler_options=no)
    try:
        with begun:
            assert begun.context is context
            assert context.ok()
        assert not context.ok()
    finally:
        context.try_shutdown()  # else its logging is that of the tests behind this one


def test_loggers_levels_are_seen_and_set_through_services(ros: Ros) -> None:
    ros.spun("talker", enable_logger_service=True)
    node = ros.spun("asker")
    get = node.create_client(GetLoggerLevels, "/talker/get_logger_levels")
    put = node.create_client(SetLoggerLevels, "/talker/set_logger_levels")
    assert get.wait_for_service(10.0)
    assert put.wait_for_service(10.0)
    levels = [LoggerLevel(name="some.logger", level=LoggerLevel.LOG_LEVEL_ERROR)]
    assert ros.result(put.call_async(SetLoggerLevels.Request(levels=levels))).results[0].successful
    answer = ros.result(get.call_async(GetLoggerLevels.Request(names=["some.logger"])))
    assert answer.levels[0].level == LoggerLevel.LOG_LEVEL_ERROR
    child = ros.result(get.call_async(GetLoggerLevels.Request(names=["some.logger.child"])))
    assert child.levels[0].level == LoggerLevel.LOG_LEVEL_UNKNOWN  # what it inherits is not its own
    root = ros.result(get.call_async(GetLoggerLevels.Request(names=["talker", ""])))
    assert [one.level for one in root.levels] == [0, LoggerLevel.LOG_LEVEL_INFO]
    levels[0].level = 33
    refused = ros.result(put.call_async(SetLoggerLevels.Request(levels=levels))).results[0]
    assert not refused.successful
    assert refused.reason == "Failed reason: Invalid logger level."


def test_what_a_node_makes_ends_with_its_with(ros: Ros) -> None:
    node = ros.node()
    with node.create_publisher(Int32, "numbers", 1) as publisher:
        publisher.publish(Int32(data=1))
    with pytest.raises(RuntimeError, match="destruction was requested"):
        publisher.publish(Int32(data=1))
    with SingleThreadedExecutor(context=ros.context) as executor:
        executor.add_node(ros.node("other"))
        executor.spin_once(timeout_sec=0.0)
    assert executor.get_nodes() == []
    with MultiThreadedExecutor(2, context=ros.context) as pool:
        pool.shutdown(wait_for_threads=False)


def test_lines_stay_off_rosout_when_that_is_switched_off() -> None:
    quiet = Ros(["--disable-rosout-logs"])
    node = quiet.node("quiet")
    assert node.count_publishers("/rosout") == 0
    quiet.close()


def test_arguments_that_ros_does_not_know_are_refused_when_they_are_removed() -> None:
    assert remove_ros_args(["x", "--ros-args", "-r", "a:=b", "--", "y"]) == ["x", "y"]
    with pytest.raises(RuntimeError, match="--bad"):
        remove_ros_args(["x", "--ros-args", "--bad"])


def test_log_lines_are_published_with_level_name_and_place(ros: Ros) -> None:
    lines: list[Log] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lines.append, 50)
    node = ros.node("talker", namespace="/ns")
    wait_until(lambda: node.count_subscribers("/rosout") == 1)
    node.get_logger().debug("not shown")
    node.get_logger().info("shown")
    node.get_logger().get_child("part").warning("too")
    node.get_logger().info(None)

    def mine() -> list[Log]:
        return [line for line in [*lines] if line.name.startswith("ns.talker")]

    wait_until(lambda: len(mine()) == 3)
    first, second, none = mine()
    assert none.msg in ("None", "(null)")  # As C writes it.
    assert (first.name, first.level, first.msg) == ("ns.talker", 20, "shown")
    assert (second.name, second.level, second.msg) == ("ns.talker.part", 30, "too")
    assert first.function == "test_log_lines_are_published_with_level_name_and_place"
    assert first.stamp.sec > 0


def test_filters_thin_lines_out(ros: Ros) -> None:
    logger = ros.node("filters").get_logger()
    assert [logger.info("once", once=True) for _ in range(3)] == [True, False, False]
    assert [logger.info("later", skip_first=True) for _ in range(3)] == [False, True, True]
    assert [logger.info("rare", throttle_duration_sec=60.0) for _ in range(3)] == [
        True,
        False,
        False,
    ]


def test_the_graph_names_nodes_topics_and_services(ros: Ros) -> None:
    one, two = ros.node("one"), ros.node("two", namespace="/ns")
    one.create_publisher(Float32, "topic", 10)
    two.create_subscription(Float32, "/topic", lambda message: None, 10)
    one.create_service(Trigger, "trigger", lambda request, response: response)
    wait_until(lambda: one.count_subscribers("topic") == 1)
    wait_until(lambda: set(two.get_node_names_and_namespaces()) == {("one", "/"), ("two", "/ns")})
    assert ("/topic", ["std_msgs/msg/Float32"]) in two.get_topic_names_and_types()
    assert ("/trigger", ["std_srvs/srv/Trigger"]) in two.get_service_names_and_types()
    info = two.get_publishers_info_by_topic("/topic")[0]
    assert (info.node_name, info.node_namespace, info.topic_type) == (
        "one",
        "/",
        "std_msgs/msg/Float32",
    )
    assert ("/trigger", ["std_srvs/srv/Trigger"]) in two.get_service_names_and_types_by_node(
        "one", "/"
    )
    assert ("/topic", ["std_msgs/msg/Float32"]) in two.get_publisher_names_and_types_by_node(
        "one", "/"
    )
    with pytest.raises(RuntimeError):
        two.get_service_names_and_types_by_node("nobody", "/")


def test_a_destroyed_node_is_off_the_graph(ros: Ros) -> None:
    one, two = ros.node("one"), ros.node("two")
    one.create_service(Trigger, "trigger", lambda request, response: response)
    wait_until(lambda: "one" in two.get_node_names())
    one.destroy_node()
    wait_until(lambda: "one" not in two.get_node_names())
    assert two.count_services("trigger") == 0


UNSET, DEBUG, INFO, WARN, ERROR, FATAL = LoggingSeverity
ROOT = ""


@pytest.fixture
def logger(ros: Ros) -> Iterator[Any]:  # within a context: only then are lines not printed
    before = rclpy.logging.get_logger_effective_level(ROOT)
    yield rclpy.logging.get_logger("workshop")
    rclpy.logging.set_logger_level(ROOT, before)
    for name in ("workshop", "workshop.bench"):
        rclpy.logging.set_logger_level(name, UNSET)


@pytest.mark.parametrize("level", LoggingSeverity)
def test_the_roots_level_is_that_of_all_that_have_none(
    logger: RcutilsLogger, level: LoggingSeverity
) -> None:
    rclpy.logging.set_logger_level(ROOT, level)
    assert rclpy.logging.get_logger_level(ROOT) == level
    assert rclpy.logging.get_logger_effective_level(ROOT) == level
    assert logger.get_effective_level() == level
    assert logger.is_enabled_for(DEBUG) == (level <= DEBUG)
    assert rclpy.logging.get_logger_level("workshop") == UNSET


def test_children_inherit_until_they_have_a_level(logger: RcutilsLogger) -> None:
    child = logger.get_child("bench")
    assert child.name == "workshop.bench"
    logger.set_level(ERROR)
    assert child.get_effective_level() == ERROR
    child.set_level(DEBUG)
    assert (child.get_effective_level(), logger.get_effective_level()) == (DEBUG, ERROR)
    child.set_level(UNSET)
    assert child.get_effective_level() == ERROR
