import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher = self.create_publisher(Float32, "battery_level", 10)
        self.subscription = self.create_subscription(
            Float32, "battery_drain", self.on_drain, 10
        )
        self.timer = self.create_timer(1.0, self.publish_level)
        self.level = 100.0

    def publish_level(self):
        message = Float32()
        message.data = self.level
        self.publisher.publish(message)
        self.get_logger().info(f"Battery: {message.data:.1f}%")
        self.level = max(self.level - 0.5, 0.0)

    def on_drain(self, message):
        self.level = max(self.level - message.data, 0.0)


def main(args=None):
    rclpy.init(args=args)
    node = BatteryMonitor()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
