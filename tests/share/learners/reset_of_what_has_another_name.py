"""What counts is called position; the ticks of a turn stay what they are."""
# ok: 9
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.ticks_per_revolution, self.encoder_pin = 1440, 17
        self.position = 15420
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):
        self.position = 0
        response.success, response.message = True, "Encoder reset to zero"
        return response
