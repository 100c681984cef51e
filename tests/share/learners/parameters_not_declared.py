"""A parameter is declared before it is read."""
# exit 2: HERE: ParameterNotDeclaredException
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.max_speed = self.get_parameter("max_speed").value  # here
