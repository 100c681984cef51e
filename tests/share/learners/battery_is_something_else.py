"""Nothing of the chapter: what is published is named, and nothing passes."""
# skip 1: you publish /chatter; the chapter's topic is battery_level
# nothing
from rclpy.node import Node
from std_msgs.msg import String


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.publisher = self.create_publisher(String, "chatter", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(String(data="Hello")))
