"""The attribute was called otherwise in the constructor; the second tick would be right."""
# ok: 1
# not ok 2: HERE: AttributeError: 'BatteryMonitor' object has no attribute 'levl'
# not ok 3: too few messages
# not ok 11: HERE
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, self.tick)
        self.level = 100.0

    def tick(self):
        self.publisher.publish(Float32(data=self.levl))  # here
