"""A script: everything runs as it is read."""
# nothing
import rclpy
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")


rclpy.init()
rclpy.spin(BatteryMonitor())
