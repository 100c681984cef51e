"""A String is published."""
# not ok 1: HERE: it is a std_msgs/msg/String; the chapter's is a std_msgs/msg/Float32
# ok: 2
# not ok 3: heard nan
from rclpy.node import Node
from std_msgs.msg import String


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(String, "battery_level", 10)  # here
        self.create_timer(1.0, lambda: self.publisher.publish(String(data="87.5")))
