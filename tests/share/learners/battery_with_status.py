"""The robot's own message instead of the chapter's."""
# ok: 1 2 3
from archo_interfaces.msg import BatteryStatus
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.pub = self.create_publisher(BatteryStatus, "battery_level", 10)
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.pub.publish(BatteryStatus(percentage=64.0, battery_health="good"))
