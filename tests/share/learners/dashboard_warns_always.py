"""No if."""
# not ok 4: HERE: 87.5 was published, and it warned: 'Battery 87.5': only below 20.0
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)

    def on_level(self, msg):  # here
        self.get_logger().warning(f"Battery {msg.data}")
