"""A motor that listens to the battery is no dashboard."""
# ok: 9
# skip 4: no node subscribes to battery_level
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node
from std_msgs.msg import Float32


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_subscription(Float32, "battery_level", self.on_level, 10)
        self.create_service(ResetEncoder, "reset_encoder", self.reset)

    def on_level(self, msg):
        self.is_empty = msg.data <= 0.0

    def reset(self, request, response):
        response.success, response.message = True, "Encoder reset to zero"
        return response
