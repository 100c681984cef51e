"""The message is published as it was made."""
# ok: 1 2
# not ok 3: heard 0, 0, 0, 0, 0: the message's data is never set
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.level = 100.0
        self.create_timer(1.0, self.tick)

    def tick(self):
        msg = Float32()
        self.level -= 0.5
        self.publisher.publish(msg)
