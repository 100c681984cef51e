"""The threshold is a parameter; what is empty is an error, which is more than a warning."""
# ok: 4
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.declare_parameter("low_battery_threshold", 20.0)
        qos = qos_profile_sensor_data
        self.create_subscription(Float32, "battery_level", self.on_level, qos)

    def on_level(self, msg):
        low = self.get_parameter("low_battery_threshold").value
        if msg.data < 10.0:
            self.get_logger().error("Battery nearly empty")
        elif msg.data <= low:
            self.get_logger().warning("Low battery")
