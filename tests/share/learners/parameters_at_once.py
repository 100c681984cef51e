"""Declared together, with one more beside them."""
# ok: 5 6
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        known = [("max_speed", 1.0), ("wheel_radius", 0.05), ("gear", "low")]
        self.declare_parameters("", known)
