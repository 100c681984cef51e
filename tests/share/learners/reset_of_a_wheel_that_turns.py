"""The encoder counts on; a constant beside it is no count. Several threads."""
# ok: 9
import rclpy
from archo_interfaces.srv import ResetEncoder
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class MotorController(Node):
    TICKS_PER_TURN = 1024

    def __init__(self):
        super().__init__("motor_controller")
        self.ticks, self.ticks_per_metre = 0, 20000
        self.create_timer(0.01, self.turn)
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def turn(self):
        self.ticks += 1

    async def reset(self, request, response):
        self.ticks = 0
        response.success, response.message = True, "Encoder reset to zero"
        return response


def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(MotorController())
    executor.spin()
