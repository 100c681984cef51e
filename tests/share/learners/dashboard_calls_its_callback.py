"""self.on_level(...) is called when the subscription is made, and its None given."""
# exit 2: HERE: RuntimeError: give the callback itself: self.name, not self.name()
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level(None), 10)  # here

    def on_level(self, msg):
        self.get_logger().info("Dashboard sees a level")
