"""Where nothing counts, nothing can be seen of it."""
# ok: 9
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):
        return ResetEncoder.Response(success=True, message="Encoder reset to zero")
