"""`use_sim_time`: ROS clocks and their timers follow /clock, steady ones do not."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.clock import Clock, ROSClock
from rclpy.clock_type import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMsg

from tests.support.ros import Ros
from tests.support.waiting import wait_until

SIMULATED: Parameter[bool] = Parameter("use_sim_time", value=True)
REAL: Parameter[bool] = Parameter("use_sim_time", value=False)


class Simulation:
    """A node in simulated time, and the hand that moves the time."""

    def __init__(self, ros: Ros) -> None:
        self.node = ros.node("simulated", parameter_overrides=[SIMULATED])
        self.clock: Any = self.node.get_clock()
        self.executor = SingleThreadedExecutor(context=ros.context)
        self.executor.add_node(self.node)
        self._publisher = self.node.create_publisher(ClockMsg, "/clock", 1)
        wait_until(lambda: self._publisher.get_subscription_count() == 1)

    def at(self, seconds: float) -> bool:
        """It is that time now; everything that is due has been done."""
        message = ClockMsg()
        message.clock.sec, part = divmod(int(seconds * 1e9), 10**9)
        message.clock.nanosec = part
        self._publisher.publish(message)
        wanted = int(seconds * 1e9)
        wait_until(lambda: self.spin() or self.clock.now().nanoseconds == wanted)
        for _ in range(5):
            self.spin()
        return False

    def spin(self) -> bool:
        self.executor.spin_once(timeout_sec=0.01)
        return False


@pytest.fixture
def simulation(ros: Ros) -> Simulation:
    return Simulation(ros)


def test_without_a_clock_message_it_is_zero_and_ros_timers_stand_still(
    simulation: Simulation,
) -> None:
    ticks: list[str] = []
    node = simulation.node
    node.create_timer(0.01, lambda: ticks.append("ros"))
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    node.create_timer(0.01, lambda: ticks.append("steady"), clock=steady)
    wait_until(lambda: simulation.spin() or ticks.count("steady") >= 3)
    assert simulation.clock.ros_time_is_active
    assert simulation.clock.now() == Time(clock_type=ClockType.ROS_TIME)
    assert "ros" not in ticks


def test_timers_follow_the_clock_skip_what_was_missed_and_survive_a_jump_back(
    simulation: Simulation,
) -> None:
    ticks: list[float] = []
    now = simulation.clock.now
    timer = simulation.node.create_timer(1.0, lambda: ticks.append(now().nanoseconds / 1e9))
    for second in (0.5, 0.75, 1.0, 1.5, 3.75, 4.25):
        simulation.at(second)
    assert ticks == [1.0, 3.75, 4.25]
    assert timer.time_until_next_call() == 750_000_000
    simulation.at(2.0)
    assert timer.time_until_next_call() == 1_000_000_000
    for second in (2.5, 3.0):
        simulation.at(second)
    assert ticks == [1.0, 3.75, 4.25, 3.0]


def test_a_clock_of_ros_time_is_a_ros_clock_and_takes_an_override() -> None:
    clock: Any = Clock(clock_type=ClockType.ROS_TIME)
    assert isinstance(clock, ROSClock)
    clock.set_ros_time_override(Time(seconds=5, clock_type=ClockType.ROS_TIME))
    assert clock.now().nanoseconds > 10**15  # not active yet
    clock._set_ros_time_is_active(True)
    assert clock.now().nanoseconds == 5 * 10**9


def test_something_besides_a_bool_is_refused(ros: Ros) -> None:
    node: Node = ros.node()
    result = node.set_parameters([Parameter("use_sim_time", value=3)])[0]
    assert not result.successful
    assert not node.get_clock().ros_time_is_active
