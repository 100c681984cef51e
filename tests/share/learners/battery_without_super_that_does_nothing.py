"""super().__init__() is missing, and nothing raises."""
# exit 2: HERE: __init__ does not call super().__init__('name_of_the_node')
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):  # here
        self.level = 100.0
