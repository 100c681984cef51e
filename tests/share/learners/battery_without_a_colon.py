"""A line that is no Python."""
# exit 2: HERE: SyntaxError
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self)  # here
        super().__init__("battery_monitor")
