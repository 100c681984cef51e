"""A crash in one of several threads is seen at once, and not at the next call."""
# not ok 9: HERE: TypeError: reset returns nothing: end it with return response
# not ok 11: HERE
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def reset(self, request, response):  # here
        response.success, response.message = True, "Encoder reset to zero"


def main():
    import rclpy
    from rclpy.executors import MultiThreadedExecutor

    rclpy.init()
    rclpy.spin(MotorController(), executor=MultiThreadedExecutor())
