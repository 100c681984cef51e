"""The node battery_monitor, which publishes the battery's state and simulates its use."""

from __future__ import annotations

import random
from typing import Any

import rclpy
from archo_interfaces.msg import BatteryStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import InvalidParameterValueException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Float32
from std_srvs.srv import SetBool

from archo_bringup import battery_model
from archo_bringup.parameters import double


class BatteryMonitor(Node):
    """A node that publishes `battery_level`, serves `set_charging`, and takes `battery_drain`."""

    def __init__(self, **options: Any) -> None:
        super().__init__("battery_monitor", enable_logger_service=True, **options)
        self.declare_parameter(
            "low_battery_threshold", *double(20.0, "% below which the battery is low", 0.0, 100.0)
        )
        self.declare_parameter("publish_period", *double(1.0, "s between two readings", 0.02, 10.0))
        self.declare_parameter("drain_min", *double(0.05, "least % drained a tick", 0.0, 100.0))
        self.declare_parameter("drain_max", *double(0.2, "most % drained a tick", 0.0, 100.0))
        self.declare_parameter("charge_rate", *double(1.0, "%/s gained on the dock", 0.0, 100.0))
        refused = self.check_drain_range([])
        if not refused.successful:
            raise InvalidParameterValueException(
                "drain_min", self.value("drain_min"), refused.reason
            )
        self.add_on_set_parameters_callback(self.check_drain_range)
        self.add_post_set_parameters_callback(self.apply_publish_period)

        self.percentage = battery_model.START
        self.health = battery_model.GOOD
        self.is_charging = False
        self.publisher = self.create_publisher(BatteryStatus, "battery_level", 10)
        self.create_service(SetBool, "set_charging", self.set_charging)
        self.create_subscription(Float32, "battery_drain", self.on_drain, 10)
        self.timer = self.create_timer(self.value("publish_period"), self.on_timer)

    def value(self, name: str) -> float:
        return float(self.get_parameter(name).value)

    def on_timer(self) -> None:
        self.publish()
        if self.is_charging:
            gained = self.value("charge_rate") * self.value("publish_period")
            self.percentage = battery_model.changed(self.percentage, gained)
        else:
            drained = random.uniform(self.value("drain_min"), self.value("drain_max"))
            self.percentage = battery_model.changed(self.percentage, -drained)

    def publish(self) -> None:
        self.health = battery_model.health(
            self.percentage, self.value("low_battery_threshold"), self.health
        )
        self.publisher.publish(
            BatteryStatus(
                percentage=self.percentage,
                voltage=battery_model.voltage(self.percentage),
                is_charging=self.is_charging,
                battery_health=self.health,
            )
        )

    def on_drain(self, message: Float32) -> None:
        if self.is_charging:  # The charger feeds the robot.
            return
        self.percentage = battery_model.changed(self.percentage, -message.data)

    def set_charging(
        self, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        self.is_charging = request.data
        self.publish()
        response.success = True
        response.message = "Charging" if request.data else "Not charging"
        self.get_logger().info(f"{response.message}, {self.percentage:.1f}%")
        return response

    def check_drain_range(self, parameters: list[Parameter[Any]]) -> SetParametersResult:
        new = {parameter.name: parameter.value for parameter in parameters}
        low = new.get("drain_min", self.value("drain_min"))
        high = new.get("drain_max", self.value("drain_max"))
        if low > high:
            return SetParametersResult(
                successful=False, reason=f"drain_min {low:g} is above drain_max {high:g}"
            )
        return SetParametersResult(successful=True)

    def apply_publish_period(self, parameters: list[Parameter[Any]]) -> None:
        for parameter in parameters:
            if parameter.name == "publish_period":
                self.timer.timer_period_ns = int(parameter.value * 1e9)
                self.timer.reset()


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    try:
        rclpy.spin(BatteryMonitor())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
