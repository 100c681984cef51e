import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class FakeBatteryDrain(Node):
    def __init__(self):
        super().__init__("fake_battery_drain")
        self.publisher = self.create_publisher(Float32, "battery_drain", 10)
        self.timer = self.create_timer(1.0, self.drain)

    def drain(self):
        message = Float32()
        message.data = 2.0
        self.publisher.publish(message)


def main(args=None):
    rclpy.init(args=args)
    node = FakeBatteryDrain()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
