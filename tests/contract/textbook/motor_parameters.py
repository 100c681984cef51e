import rclpy
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 0.8)
        self.declare_parameter("wheel_radius", 0.05)
        max_speed = self.get_parameter("max_speed").value
        radius = self.get_parameter("wheel_radius").get_parameter_value().double_value
        self.get_logger().info(f"max_speed={max_speed}, wheel_radius={radius}")


def main(args=None):
    rclpy.init(args=args)
    node = MotorController()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
