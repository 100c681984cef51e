"""It takes the whole of rclpy along."""
# not ok 10: HERE: RuntimeError: rclpy.shutdown() would end every node here: call it in main() only
# not ok 11: HERE: RuntimeError
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(Trigger, "emergency_stop", self.stop)

    def stop(self, request, response):
        response.success = True
        rclpy.shutdown()  # here
        return response
