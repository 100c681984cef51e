import rclpy
from rclpy.node import Node


class Talker(Node):
    def __init__(self, name):
        super().__init__(name)
        self.create_timer(1.0, lambda: self.get_logger().warning("here"))


def main():
    rclpy.init()
    rclpy.spin(Talker("talker"))


if __name__ == "__main__":
    main()
