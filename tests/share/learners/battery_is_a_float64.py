"""A Float64 never meets a subscription of Float32."""
# not ok 1: it is a std_msgs/msg/Float64; the chapter's is a std_msgs/msg/Float32
# ok: 2 3
from rclpy.node import Node
from std_msgs.msg import Float64


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float64, "battery_level", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(Float64(data=87.5)))
