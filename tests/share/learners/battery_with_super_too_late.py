"""super().__init__() comes after the publisher."""
# exit 2: HERE: super().__init__('name_of_the_node') must be the first line of __init__
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):  # here
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        super().__init__("battery_monitor")
