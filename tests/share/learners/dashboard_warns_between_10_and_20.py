"""Silent when it matters most."""
# not ok 4: 5.0 was published, and nothing logged as a warning
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)

    def on_level(self, msg):
        if 10.0 < msg.data < 20.0:
            self.get_logger().warning("Low battery")
