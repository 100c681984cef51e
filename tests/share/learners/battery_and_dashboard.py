"""Two nodes in one file."""
# ok: 1 2 3 4
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.pub = self.create_publisher(Float32, "battery_level", 10)
        self.level = 90.0
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.level -= 0.2
        self.pub.publish(Float32(data=self.level))


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)

    def on_level(self, msg):
        if msg.data < 20.0:
            self.get_logger().warning("Low battery!")
