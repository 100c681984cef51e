"""Too early."""
# not ok 4: HERE: 21.0 was published, and it warned
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)

    def on_level(self, msg):  # here
        if msg.data < 50.0:
            self.get_logger().warning("Low battery")
