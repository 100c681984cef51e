"""A stop that says that it did not stop."""
# not ok 10: answered False: set response.success = True
from archo_interfaces.srv import EmergencyStop
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(EmergencyStop, "emergency_stop", lambda request, response: response)
