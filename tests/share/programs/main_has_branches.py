import rclpy
from rclpy.node import Node

SIM = True


class Motor(Node):
    def __init__(self):
        super().__init__("motor")


class SimMotor(Node):
    def __init__(self):
        super().__init__("motor_sim")


def main():
    rclpy.init()
    if SIM:
        node = SimMotor()
    else:
        node = Motor()
    rclpy.spin(node)


if __name__ == "__main__":
    main()
