"""The module `rclpy.time_source`: simulated time, by `use_sim_time` and the topic `/clock`."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import ROSClock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMsg

if TYPE_CHECKING:
    from rclpy.node import Node

CLOCK_TOPIC = "/clock"
USE_SIM_TIME_NAME = "use_sim_time"


class TimeSource:
    """A source that gives clocks the time of /clock while its node's `use_sim_time` is True."""

    def __init__(self, *, node: Node | None = None) -> None:
        self._get_node: Any = lambda: None
        self._clock_sub: Any = None
        self._clocks: set[ROSClock] = set()
        self._last = Time(clock_type=ClockType.ROS_TIME)
        self._is_active = False
        if node is not None:
            self.attach_node(node)

    @property
    def ros_time_is_active(self) -> bool:
        """Return True while the attached clocks tell simulated time.

        Setting it switches all of them, and subscribes to /clock or ends the subscription.
        """
        return self._is_active

    @ros_time_is_active.setter
    def ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._is_active:
            return
        self._is_active = enabled
        for clock in self._clocks:
            clock._set_ros_time_is_active(enabled)
        if enabled:
            self._subscribe()
        else:
            self._unsubscribe()

    def attach_node(self, node: Node) -> None:
        """Follow the parameter `use_sim_time` of a node, now and whenever it changes.

        The parameter is declared, as False, if it is not. A value that is no bool is logged as an
        error. The node attached before is detached first.
        """
        self.detach_node()
        self._get_node = weakref.ref(node)
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        value = node.get_parameter(USE_SIM_TIME_NAME).value
        if isinstance(value, bool):
            self.ros_time_is_active = value
            if value:
                self._subscribe()
        elif value is not None:
            node.get_logger().error(f"Invalid type for parameter '{USE_SIM_TIME_NAME}': not a bool")
        node.add_on_set_parameters_callback(self._on_parameters)

    def detach_node(self) -> None:
        """Unsubscribe from /clock; attached clocks go on telling the time that they have.

        As in rclpy, setting `use_sim_time` of the node still switches the clocks.
        """
        self._unsubscribe()
        self._get_node = lambda: None

    def attach_clock(self, clock: ROSClock) -> None:
        """Let a clock follow this source from now on, and give it the last time of /clock.

        That time is 0 before the first message. The clock tells simulated time only while this
        source's `ros_time_is_active`.
        """
        if not isinstance(clock, ROSClock):
            raise ValueError("Only clocks with type ROS_TIME can be attached.")
        clock.set_ros_time_override(self._last)
        clock._set_ros_time_is_active(self._is_active)
        self._clocks.add(clock)

    def clock_callback(self, msg: ClockMsg) -> None:
        """Set the time of a message of /clock on all attached clocks."""
        self._last = Time.from_msg(msg.clock)
        for clock in self._clocks:
            clock.set_ros_time_override(self._last)

    def _subscribe(self) -> None:
        node = self._get_node()
        if node is not None and self._clock_sub is None:
            qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
            self._clock_sub = node.create_subscription(
                ClockMsg, CLOCK_TOPIC, self.clock_callback, qos
            )

    def _unsubscribe(self) -> None:
        node = self._get_node()
        if node is not None and self._clock_sub is not None:
            node.destroy_subscription(self._clock_sub)
        self._clock_sub = None

    def _on_parameters(self, parameters: list[Parameter[Any]]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name != USE_SIM_TIME_NAME:
                continue
            if not isinstance(parameter.value, bool):
                reason = f"{USE_SIM_TIME_NAME} parameter set to something besides a bool"
                return SetParametersResult(successful=False, reason=reason)
            self.ros_time_is_active = parameter.value
        return SetParametersResult(successful=True)
