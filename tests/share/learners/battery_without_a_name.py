"""super().__init__() needs the node's name."""
# exit 2: HERE: TypeError
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__()  # here
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
