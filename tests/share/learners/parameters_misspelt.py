"""A typo in each name."""
# not ok 5: HERE: you declare maxspeed; the chapter's name is max_speed
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("maxspeed", 0.8)  # here
        self.declare_parameter("wheel_radious", 0.05)
