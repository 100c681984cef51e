"""A subscription's callback is given the message."""
# exit 2: HERE: RuntimeError
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)  # here

    def on_level(self):
        self.get_logger().warning("Low battery")
