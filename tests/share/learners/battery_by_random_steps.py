"""Drains by chance, never below zero; takes rclpy's own arguments; an int made a float."""
# ok: 1 2 3
import random

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float32


class BatteryMonitor(Node):
    def __init__(self, **options):
        super().__init__("battery_monitor", **options)
        qos = QoSProfile(depth=5, reliability=ReliabilityPolicy.RELIABLE)
        self.pub = self.create_publisher(Float32, "/battery_level", qos)
        self.level = 100
        self.create_timer(1, self.tick)

    def tick(self):
        self.pub.publish(Float32(data=float(self.level)))
        self.level = max(0, self.level - random.randint(0, 3))
