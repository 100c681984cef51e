"""One letter is missing."""
# not ok 4: HERE: you subscribe to /batery_level; the chapter's topic is battery_level
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "batery_level", self.on_level, 10)  # here

    def on_level(self, msg):
        if msg.data < 20.0:
            self.get_logger().warning("Low battery")
