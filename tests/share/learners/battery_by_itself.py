"""A node that has no chapter's name, in capitals, with its own words for everything."""
# ok: 1 2 3 4
from rclpy.node import Node
from std_msgs.msg import Float32


class Robot(Node):
    def __init__(self):
        super().__init__("Robot")
        self.pub = self.create_publisher(Float32, "battery_level", 10)
        self.sub = self.create_subscription(Float32, "battery_level", self.heard, 10)
        self.timer = self.create_timer(1.0, self.tick)
        self.level = 80.0

    def tick(self):
        self.level -= 0.1
        message = Float32()
        message.data = self.level
        self.pub.publish(message)

    def heard(self, message):
        if message.data < 20:
            self.get_logger().warning(f"{message.data} left")
