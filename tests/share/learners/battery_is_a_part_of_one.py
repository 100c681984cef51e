"""0 .. 1 instead of percent."""
# ok: 1 2
# not ok 3: a level is in percent, 0 .. 100, not a fraction of 1
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.level = 1.0
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.publisher.publish(Float32(data=self.level))
        self.level -= 0.01
