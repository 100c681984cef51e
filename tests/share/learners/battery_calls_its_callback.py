"""self.tick() is called when the timer is made, and its None given."""
# ok: 1
# not ok 2: HERE: 
# not ok 2: Error: give the callback itself: self.name, not self.name()
# not ok 3: too few messages
# not ok 11: HERE
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, self.tick())  # here

    def tick(self):
        self.publisher.publish(Float32(data=87.5))
