"""What the file says is overwritten."""
# ok: 5
# not ok 6: wheel_radius is 0.05, and the file says 0.07
from rclpy.node import Node
from rclpy.parameter import Parameter


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 0.8)
        self.declare_parameter("wheel_radius", 0.05)
        self.set_parameters([Parameter("wheel_radius", value=0.05)])
