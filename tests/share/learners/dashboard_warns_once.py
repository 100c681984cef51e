"""Warns when the level falls below 20, and again only when it was above meanwhile."""
# ok: 4
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)
        self.is_low = False

    def on_level(self, msg):
        was_low, self.is_low = self.is_low, msg.data < 20.0
        if self.is_low and not was_low:
            self.get_logger().warning("Low battery")
