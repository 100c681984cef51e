"""The right name below another one."""
# not ok 1: you publish /archo/battery_level; the chapter's topic is battery_level
# not ok 2: you publish /archo/battery_level
# not ok 3: you publish /archo/battery_level
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "archo/battery_level", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(Float32(data=87.5)))
