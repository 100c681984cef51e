"""The service is called reset; a right stop beside it does not hide that."""
# not ok 9: HERE: you serve /reset; the chapter's service is reset_encoder
# ok: 10
from archo_interfaces.srv import EmergencyStop, ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset", self.reset)  # here
        self.create_service(EmergencyStop, "emergency_stop", self.stop)

    def reset(self, request, response):
        response.success, response.message = True, "Encoder reset to zero"
        return response

    def stop(self, request, response):
        response.success = True
        return response
