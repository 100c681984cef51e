"""A thread of its own prints, and ends by a mistake."""
# ok: 9
# not ok 11: HERE: NameError: name 'ticks' is not defined, in: self.ticks = ticks + 1
import threading

from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)
        threading.Thread(target=self.turn, daemon=True).start()

    def turn(self):
        print("not ok 9 - this is no line of the check")
        self.ticks = ticks + 1  # here

    def reset(self, request, response):
        response.success, response.message = True, "Encoder reset to zero"
        return response
