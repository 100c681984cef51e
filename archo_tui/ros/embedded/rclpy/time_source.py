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

_NAME = "use_sim_time"


class TimeSource:
    """A source that gives a node's clock the time of /clock while its `use_sim_time` is True."""

    def __init__(self, node: Node, clock: ROSClock) -> None:
        self._node, self._clock = weakref.proxy(node), clock
        self._subscription: Any = None
        if not node.has_parameter(_NAME):
            node.declare_parameter(_NAME, False)
        value = node.get_parameter(_NAME).value
        if not isinstance(value, bool):
            node.get_logger().error(f"Invalid type for parameter '{_NAME}': not a bool")
        self._switch(value is True)
        node.add_on_set_parameters_callback(self._on_parameters)

    def _switch(self, simulated: bool) -> None:
        self._clock._set_ros_time_is_active(simulated)
        if simulated and self._subscription is None:
            qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
            self._subscription = self._node.create_subscription(
                ClockMsg, "/clock", self._on_clock, qos
            )
        elif not simulated and self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _on_clock(self, message: ClockMsg) -> None:
        self._clock.set_ros_time_override(Time.from_msg(message.clock, ClockType.ROS_TIME))

    def _on_parameters(self, parameters: list[Parameter[Any]]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == _NAME and not isinstance(parameter.value, bool):
                reason = f"{_NAME} parameter set to something besides a bool"
                return SetParametersResult(successful=False, reason=reason)
            if parameter.name == _NAME:
                self._switch(parameter.value)
        return SetParametersResult(successful=True)
