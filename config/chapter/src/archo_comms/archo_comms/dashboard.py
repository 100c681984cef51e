import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class Dashboard(Node):
    def __init__(self):
        super().__init__("dashboard")
        self.subscription = self.create_subscription(
            Float32, "battery_level", self.on_level, 10
        )

    def on_level(self, message):
        self.get_logger().info(f"Battery: {message.data:.1f}%")
        if message.data < 20.0:
            self.get_logger().warning(f"Low battery: {message.data:.1f}%")


def main(args=None):
    rclpy.init(args=args)
    node = Dashboard()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
