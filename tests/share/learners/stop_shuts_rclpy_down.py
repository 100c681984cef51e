"""It ends itself before it has answered."""
# not ok 10: HERE:
# not ok 10: rclpy.shutdown() ends the node that calls it: call it at the end of main() only
# not ok 11: HERE:
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
