"""A method without self."""
# not ok 9: HERE: TypeError
# not ok 9: its first parameter must be self
# not ok 11: HERE
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(request, response):  # here
        response.success, response.message = True, "Encoder reset to zero"
        return response
