"""Two levels are right, the third one is not."""
# ok: 1 3
# not ok 2: HERE: ZeroDivisionError
# not ok 11: HERE
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, self.tick)
        self.left = 2

    def tick(self):
        self.publisher.publish(Float32(data=100.0 - 1.0 / self.left))  # here
        self.left -= 1
