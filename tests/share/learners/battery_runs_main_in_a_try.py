"""main() without its `if`, in a try."""
# nothing
import rclpy
from rclpy.node import Node


class BatteryMonitor(Node):
    def __init__(self):
        super().__init__("battery_monitor")


def main():
    rclpy.init()
    rclpy.spin(BatteryMonitor())


try:
    main()
except KeyboardInterrupt:
    pass
