"""A script: everything runs when it is imported."""
# exit 2: HERE: RuntimeError: rclpy.init() runs here already: call it in main() only
import rclpy
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")


rclpy.init()  # here
rclpy.spin(BatteryMonitor())
