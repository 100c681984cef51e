"""The right words at the wrong level."""
# not ok 4: HERE: 19.0 was published, and 'Low battery!' only logged as information
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)

    def on_level(self, msg):  # here
        if msg.data < 20.0:
            self.get_logger().info("Low battery!")
