"""The chapter's client calls another type."""
# not ok 9: HERE: it is a std_srvs/srv/Trigger; the chapter's is an archo_interfaces/srv/ResetEncoder
from rclpy.node import Node
from std_srvs.srv import Trigger


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(Trigger, "reset_encoder", self.reset)  # here

    def reset(self, request, response):
        response.success, response.message = True, "Encoder reset to zero"
        return response
