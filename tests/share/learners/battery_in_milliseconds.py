"""1000 was meant to be milliseconds."""
# ok: 1
# not ok 2: HERE: 0 messages in 7.5 s: create_timer(1.0, ...), in seconds
# not ok 3: too few messages
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1000, lambda: self.publisher.publish(Float32(data=87.5)))  # here
