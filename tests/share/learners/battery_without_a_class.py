"""A node that is no class: main() does everything with it."""
# ok: 1 2 3
import rclpy
from std_msgs.msg import Float32


def main():
    rclpy.init()
    node = rclpy.create_node("battery_monitor")
    publisher = node.create_publisher(Float32, "battery_level", 10)
    node.create_timer(1.0, lambda: publisher.publish(Float32(data=87.5)))
    rclpy.spin(node)
