"""The executor is made in a function that main() calls."""
# ok: 7 8
import time

import rclpy
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.server = ActionServer(
            self, MoveToShelf, "move_to_shelf", self.execute, cancel_callback=self.on_cancel
        )

    def on_cancel(self, goal_handle):
        return CancelResponse.ACCEPT

    def execute(self, goal_handle):
        result = MoveToShelf.Result()
        for distance in (15.0, 12.0, 9.0, 6.0, 3.0, 0.0):
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                result.final_message = "Cancelled mid-route"
                return result
            goal_handle.publish_feedback(MoveToShelf.Feedback(distance_remaining=distance))
            time.sleep(0.5)
        goal_handle.succeed()
        result.success = True
        result.final_message = f"Arrived at shelf {goal_handle.request.shelf_number}"
        return result


def main():
    rclpy.init()
    spin(MotorController())


def spin(node):
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    executor.spin()
