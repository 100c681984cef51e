"""The dashboard warns of the battery itself, while the check publishes high levels."""
# ok: 1 2 3 4
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.level = 70.0
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.level = max(self.level - 10.0, 0.0)
        self.publisher.publish(Float32(data=self.level))


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.create_subscription(Float32, "battery_level", self.show, 10)

    def show(self, message):
        if message.data < 20.0:
            self.get_logger().warning(f"Low battery: {message.data}")
