"""The topic is called battery, not battery_level."""
# not ok 1: HERE: you publish /battery; the chapter's topic is battery_level
# not ok 2: HERE: you publish /battery; the chapter's topic is battery_level
# not ok 3: HERE: you publish /battery; the chapter's topic is battery_level
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery", 10)  # here
        self.create_timer(1.0, lambda: self.publisher.publish(Float32(data=87.5)))
