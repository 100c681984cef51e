"""The number itself is published, and not a message."""
# ok: 1
# not ok 2: HERE: TypeError
# not ok 3: too few messages
# not ok 11: HERE: TypeError
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.publisher.publish(87.5)  # here
