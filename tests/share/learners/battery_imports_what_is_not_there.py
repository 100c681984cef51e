"""float32 is Float32."""
# exit 2: HERE: ImportError: cannot import name 'float32'
from rclpy.node import Node
from std_msgs.msg import float32  # here


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(float32, "battery_level", 10)
