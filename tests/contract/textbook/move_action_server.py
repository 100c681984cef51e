import time

import rclpy
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionServer
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self._action_server = ActionServer(
            self, MoveToShelf, "move_to_shelf", self.execute_callback
        )

    def execute_callback(self, goal_handle):
        self.get_logger().info(f"Moving to shelf {goal_handle.request.shelf_number}")
        feedback = MoveToShelf.Feedback()
        distance = 15.0
        while distance >= 0.0:
            feedback.distance_remaining = distance
            feedback.status = "moving"
            goal_handle.publish_feedback(feedback)
            time.sleep(0.5)
            distance -= 3.0
        goal_handle.succeed()
        result = MoveToShelf.Result()
        result.success = True
        result.final_message = f"Arrived at shelf {goal_handle.request.shelf_number}"
        return result


def main(args=None):
    rclpy.init(args=args)
    node = MotorController()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
