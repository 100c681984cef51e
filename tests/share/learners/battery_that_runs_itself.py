"""It publishes in a loop of its own, not by a timer, and nobody keeps the node."""
# ok: 1 2 3
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class Battery(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.level = 100.0

    def run(self):
        while rclpy.ok():
            self.level -= 0.5
            self.publisher.publish(Float32(data=self.level))
            rclpy.spin_once(self, timeout_sec=0)
            time.sleep(1.0)


def main(args=None):
    rclpy.init(args=args)
    Battery().run()


if __name__ == "__main__":
    main()
