"""Ten times a second."""
# ok: 1 3
# not ok 2: HERE: one every 0.1
# not ok 2: s: the first argument of create_timer is in seconds
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(0.1, lambda: self.publisher.publish(Float32(data=87.5)))  # here
