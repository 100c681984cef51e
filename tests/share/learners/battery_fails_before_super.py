"""Another mistake in front of super().__init__() is said as it is."""
# exit 2: HERE: AttributeError: 'BatteryMonitor' object has no attribute 'start'
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        self.level = self.start  # here
        super().__init__("battery_monitor")
