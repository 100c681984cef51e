#!/usr/bin/env python3
import rclpy
from my_cpp.steps import STEP
from rclpy.node import Node
from std_msgs.msg import Int32


class Count(Node):
    def __init__(self):
        super().__init__("count")
        self.publisher = self.create_publisher(Int32, "count", 10)
        self.count = 0
        self.create_timer(0.1, self.publish)

    def publish(self):
        self.count += STEP
        self.publisher.publish(Int32(data=self.count))


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Count())
