"""The chapter's service."""
# ok: 9
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.encoder_ticks = 15420
        self.srv = self.create_service(ResetEncoder, "reset_encoder", self.reset_callback)

    def reset_callback(self, request, response):
        self.encoder_ticks = 0
        response.success = True
        response.message = "Encoder reset to zero"
        return response
