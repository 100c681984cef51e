"""Loggers: levels, what thins lines out, /rosout; and what the graph names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import rclpy.logging
from rcl_interfaces.msg import Log
from rclpy.clock import ROSClock
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import LoggingSeverity
from rclpy.time import Time
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from tests.support.ros import Ros
from tests.support.waiting import wait_until


def test_log_lines_are_published_with_level_name_and_place(ros: Ros) -> None:
    lines: list[Log] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lines.append, 50)
    node = ros.node("talker", namespace="/ns")
    wait_until(lambda: node.count_subscribers("/rosout") == 1)
    node.get_logger().debug("not shown")
    node.get_logger().info("shown")
    node.get_logger().get_child("part").warning("too")

    def mine() -> list[Log]:
        return [line for line in [*lines] if line.name.startswith("ns.talker")]

    wait_until(lambda: len(mine()) == 2)
    first, second = mine()
    assert (first.name, first.level, first.msg) == ("ns.talker", 20, "shown")
    assert (second.name, second.level, second.msg) == ("ns.talker.part", 30, "too")
    assert first.function == "test_log_lines_are_published_with_level_name_and_place"
    assert first.stamp.sec > 0


def test_none_is_logged_and_a_line_feed_stays(ros: Ros) -> None:
    lines: list[Log] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lines.append, 50)
    node = ros.node("talker")
    wait_until(lambda: node.count_subscribers("/rosout") == 1)
    for line in (None, "Incoming request\na: 2 b: 3"):
        node.get_logger().info(line)
    wait_until(lambda: len([line for line in [*lines] if line.name == "talker"]) == 2)
    none, request = [line.msg for line in lines if line.name == "talker"]
    assert none in ("None", "(null)")  # As C writes it.
    assert request == "Incoming request\na: 2 b: 3"


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


def test_a_service_that_has_only_clients_is_named_but_counts_no_server(ros: Ros) -> None:
    one, two = ros.node("one"), ros.node("two")
    one.create_client(Trigger, "wanted")
    wait_until(lambda: two.count_clients("wanted") == 1)
    assert two.count_services("wanted") == 0
    assert ("/wanted", ["std_srvs/srv/Trigger"]) in two.get_service_names_and_types()


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


def test_a_throttle_goes_by_the_clock_that_it_is_given(logger: RcutilsLogger) -> None:
    clock = ROSClock()  # simulated time, at 0
    clock._set_ros_time_is_active(True)
    logged = []
    for second in range(1, 6):
        logged.append(logger.info("line", throttle_duration_sec=2, throttle_time_source_type=clock))
        clock.set_ros_time_override(Time(seconds=second, clock_type=clock.clock_type))
    assert logged == [False, False, True, False, True]  # from the second 2 on


def test_severities_by_their_names() -> None:
    named = [rclpy.logging.get_logging_severity_from_string(one.name) for one in LoggingSeverity]
    assert named == list(LoggingSeverity)
    with pytest.raises((RuntimeError, KeyError)):
        rclpy.logging.get_logging_severity_from_string("LOUD")
