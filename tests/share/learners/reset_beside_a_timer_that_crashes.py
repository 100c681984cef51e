"""The service is right; a second later the node ends."""
# ok: 9
# not ok 11: HERE: NameError: name 'ticks' is not defined
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)
        self.create_timer(1.0, self.turn)

    def turn(self):
        self.ticks = ticks + 1  # here

    def reset(self, request, response):
        response.success, response.message = True, "Encoder reset to zero"
        return response
