"""The sign is wrong."""
# ok: 1 2
# not ok 3: heard 50, 51, 52, 53, 54: a battery that drains only falls
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.level = 50.0
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.publisher.publish(Float32(data=self.level))
        self.level += 1.0
