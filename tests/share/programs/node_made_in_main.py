import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


def main():
    rclpy.init()
    node = Node("battery_monitor")
    publisher = node.create_publisher(Float32, "battery_level", 10)
    node.create_timer(1.0, lambda: publisher.publish(Float32(data=87.5)))
    rclpy.spin(node)


if __name__ == "__main__":
    main()
