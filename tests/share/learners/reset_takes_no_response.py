"""A service's callback is given two messages."""
# not ok 9: HERE: TypeError
# not ok 11: HERE
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request):  # here
        return ResetEncoder.Response(success=True, message="Encoder reset to zero")
