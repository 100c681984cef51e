"""It only says so."""
# not ok 9: HERE: self.encoder_ticks is what it was before: set it to 0 in the callback
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.encoder_ticks = 15420
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):  # here
        encoder_ticks = 0
        response.success, response.message = True, "Encoder reset to zero"
        return response
