"""Loggers without a node: their levels, what thins their lines out, where ROS keeps its logs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import rclpy.logging
from rclpy.clock import ROSClock
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import LoggingSeverity
from rclpy.time import Time

from tests.support.ros import Ros

pytestmark = pytest.mark.pure

UNSET, DEBUG, INFO, WARN, ERROR, FATAL = LoggingSeverity
ROOT = ""


@pytest.fixture
def logger(ros: Ros) -> Iterator[Any]:  # within a context: only then are lines not printed
    before = rclpy.logging.get_logger_effective_level(ROOT)
    yield rclpy.logging.get_logger("workshop")
    rclpy.logging.set_logger_level(ROOT, before)
    for name in ("workshop", "workshop.bench"):
        rclpy.logging.set_logger_level(name, UNSET)


@pytest.fixture
def clock() -> ROSClock:
    """Simulated time, at 0."""
    made = ROSClock()
    made._set_ros_time_is_active(True)
    return made


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


@pytest.mark.parametrize(
    ("first", "second", "is_refused"),
    [
        ({"once": True}, {"skip_first": True}, True),
        ({"throttle_duration_sec": 1}, {"throttle_duration_sec": 2}, True),
        ({"once": False}, {}, False),
        ({"throttle_duration_sec": 0}, {"skip_first": False}, False),
    ],
)
def test_filters_stay_the_same_at_one_place(
    logger: RcutilsLogger, first: dict[str, Any], second: dict[str, Any], is_refused: bool
) -> None:
    refused = []
    for options in (first, second):
        try:
            logger.info("line", **options)
        except ValueError as error:
            refused.append("cannot be changed between calls" in str(error))
    assert refused == ([True] if is_refused else [])


def test_a_severity_stays_the_same_at_one_place(logger: RcutilsLogger) -> None:
    def say(severity: LoggingSeverity) -> bool:
        return logger.log("line", severity)

    assert say(INFO)
    assert not logger.log("another place", DEBUG)
    with pytest.raises(ValueError, match="Logger severity cannot be changed between calls"):
        say(WARN)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"onec": True}, "onec"),
        ({"severity": DEBUG}, "got multiple values for argument 'severity'"),
    ],
)
def test_what_is_no_filter_is_refused(
    logger: RcutilsLogger, options: dict[str, Any], said: str
) -> None:
    for _ in range(2):  # also where something was logged before
        with pytest.raises(TypeError, match=said):
            logger.error("line", **options)
    logger.set_level(FATAL)
    if "severity" not in options:
        assert not logger.error("line", **options)  # nobody looks at what is not logged


def test_a_throttle_goes_by_the_clock_that_it_is_given(
    logger: RcutilsLogger, clock: ROSClock
) -> None:
    logged = []
    for second in range(1, 6):
        logged.append(logger.info("line", throttle_duration_sec=2, throttle_time_source_type=clock))
        clock.set_ros_time_override(Time(seconds=second, clock_type=clock.clock_type))
    assert logged == [False, False, True, False, True]  # from the second 2 on


def test_what_is_throttled_is_not_counted_as_the_first(
    logger: RcutilsLogger, clock: ROSClock
) -> None:
    logged = []
    for second in range(1, 7):
        clock.set_ros_time_override(Time(seconds=second, clock_type=clock.clock_type))
        logged.append(
            logger.info(
                "line", skip_first=True, throttle_duration_sec=2, throttle_time_source_type=clock
            )
        )
    assert logged == [False, False, False, True, False, True]


def test_severities_by_their_names() -> None:
    named = [rclpy.logging.get_logging_severity_from_string(one.name) for one in LoggingSeverity]
    assert named == list(LoggingSeverity)
    with pytest.raises((RuntimeError, KeyError)):
        rclpy.logging.get_logging_severity_from_string("LOUD")


@pytest.mark.parametrize("name", ["", None])
def test_a_logger_has_a_name(logger: RcutilsLogger, name: Any) -> None:
    with pytest.raises(ValueError, match="Child logger name must not be empty"):
        logger.get_child(name)
    with pytest.raises(ValueError, match="name must not be empty"):
        rclpy.logging.get_logger(name)
