"""A node is made without arguments."""
# exit 2: HERE: TypeError: BatteryMonitor.__init__() missing 1 required positional argument: 'name'
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self, name):  # here
        super().__init__(name)
