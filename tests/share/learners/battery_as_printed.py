"""The chapter's battery_monitor."""
# ok: 1 2 3
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")
        self.publisher_ = self.create_publisher(Float32, "battery_level", 10)
        self.timer = self.create_timer(1.0, self.timer_callback)
        self.level = 100.0

    def timer_callback(self):
        msg = Float32()
        msg.data = self.level
        self.publisher_.publish(msg)
        self.get_logger().info(f"Battery: {msg.data:.1f}%")
        self.level -= 0.5


def main(args=None):
    rclpy.init(args=args)
    node = BatteryMonitor()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
