"""An int takes no 0.8 from a file."""
# exit 2: HERE: InvalidParameterTypeException
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 1)  # here
        self.declare_parameter("wheel_radius", 1)
