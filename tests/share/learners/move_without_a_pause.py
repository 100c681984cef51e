"""All feedback at once."""
# not ok 7: the move ended at once: leave 0.5 s between two feedbacks
# not ok 8: the move ended at once: leave 0.5 s between two feedbacks
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
        goal_handle.succeed()
        result.success = True
        result.final_message = f"Arrived at shelf {goal_handle.request.shelf_number}"
        return result


def main():
    rclpy.init()
    executor = MultiThreadedExecutor()
    executor.add_node(MotorController())
    executor.spin()
