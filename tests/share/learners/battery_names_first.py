"""The type is the first argument."""
# exit 2: the type comes first, then the name
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher("battery_level", Float32, 10)
