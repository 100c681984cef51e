"""_init_ is no constructor."""
# exit 2: HERE: BatteryMonitor has no __init__ that calls super().__init__('name_of_the_node')
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):  # here
    def _init_(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
