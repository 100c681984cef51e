"""Functions that are called init and spin are not always rclpy's."""
# ok: 5 6
from rclpy.node import Node


class Table:
    def init(self):
        self.rows = []

    def spin(self):
        self.rows.append(0)


def load(table):
    table.init()
    table.spin()


load(Table())


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 1.5)
        self.declare_parameter("wheel_radius", 0.05)
