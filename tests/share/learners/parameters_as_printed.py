"""The chapter's parameters."""
# ok: 5 6
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 0.8)
        self.declare_parameter("wheel_radius", 0.05)
        radius = self.get_parameter("wheel_radius").get_parameter_value().double_value
        self.get_logger().info(f"wheel_radius={radius}")
