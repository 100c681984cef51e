"""What sensors publish is not heard by who asks for reliable."""
# ok: 1
# not ok 2: its QoS is best effort
# not ok 3: too few messages
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.pub = self.create_publisher(Float32, "battery_level", qos_profile_sensor_data)
        self.create_timer(1.0, lambda: self.pub.publish(Float32(data=87.5)))
