"""success is False by itself."""
# not ok 9: HERE: answered False, 'Encoder reset to zero': set response.success = True
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):  # here
        response.message = "Encoder reset to zero"
        return response
