"""A loop that sleeps, in a callback: it publishes, and the node does nothing else."""
# ok: 1 2 3
# not ok 10: no answer in 3 s: a callback does not return, HERE, in: time.sleep(1.0)
import time

from rclpy.node import Node
from std_msgs.msg import Float32
from std_srvs.srv import Trigger


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_service(Trigger, "emergency_stop", lambda request, response: response)
        self.create_timer(1.0, self.tick)

    def tick(self):
        while self.context.ok():
            self.publisher.publish(Float32(data=87.5))
            time.sleep(1.0)  # here
