"""The second one is missing."""
# not ok 5: not declared: wheel_radius: self.declare_parameter('wheel_radius', value)
# skip 6: no node declares wheel_radius
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 0.8)
