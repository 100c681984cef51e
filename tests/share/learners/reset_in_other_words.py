"""The chapter's words are asked for."""
# not ok 9: HERE: answered True, 'Done'
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):  # here
        response.success, response.message = True, "Done"
        return response
