"""spin() in the constructor."""
# exit 2: HERE: BatteryMonitor.__init__ 
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(Float32(data=87.5)))
        rclpy.spin(self)  # here
