import rclpy
from rclpy.node import Node


def main(args=None):
    with rclpy.init(args=args):
        rclpy.spin(Node("listener"))
