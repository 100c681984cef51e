"""A script: everything runs when it is imported."""
# nothing
import rclpy
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")


rclpy.init()  # here
rclpy.spin(BatteryMonitor())
