"""The chapter's dashboard."""
# ok: 4
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.subscription = self.create_subscription(
            Float32, "battery_level", self.listener_callback, 10
        )

    def listener_callback(self, msg):
        self.get_logger().info(f"Dashboard sees: {msg.data:.1f}%")
        if msg.data < 20.0:
            self.get_logger().warn(f"Low battery: {msg.data:.1f}%")
