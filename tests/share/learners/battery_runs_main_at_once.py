"""main() without its `if`."""
# nothing
import rclpy
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")


def main():
    rclpy.init()
    rclpy.spin(BatteryMonitor())


main()
