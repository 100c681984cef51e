"""Another type hears nothing."""
# not ok 4: HERE: the type that is subscribed to is a std_msgs/msg/String; the chapter's is a std_msgs
from rclpy.node import Node
from std_msgs.msg import String


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(String, "battery_level", self.on_level, 10)  # here

    def on_level(self, msg):
        if float(msg.data) < 20.0:
            self.get_logger().warning("Low battery")
