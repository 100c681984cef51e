"""super().__init__() is missing."""
# exit 2: HERE: __init__ does not call super().__init__('name_of_the_node')
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):  # here
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(Float32(data=87.5)))
