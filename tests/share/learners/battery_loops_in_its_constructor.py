"""The loop that the timer is there for."""
# exit 2: HERE: BatteryMonitor.__init__ 
import time

from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        while self.context.ok():
            self.publisher.publish(Float32(data=87.5))
            time.sleep(0.01)  # here
