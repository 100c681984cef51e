import time

import rclpy
from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import ResetEncoder
from rclpy.action import ActionServer
from rclpy.node import Node


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 0.8)
        self.declare_parameter("wheel_radius", 0.05)
        self.ticks = 15420
        self.service = self.create_service(ResetEncoder, "reset_encoder", self.reset_encoder)
        self.action_server = ActionServer(
            self, MoveToShelf, "move_to_shelf", self.execute_move
        )

    def reset_encoder(self, request, response):
        self.ticks = 0
        response.success = True
        response.message = "Encoder reset to zero"
        return response

    # While this sleeps, nothing else of the node runs: no cancel is heard at 9 m.
    def execute_move(self, goal_handle):
        shelf = goal_handle.request.shelf_number
        feedback = MoveToShelf.Feedback()
        feedback.status = "moving"
        distance = 15.0
        while distance >= 0.0:
            feedback.distance_remaining = distance
            goal_handle.publish_feedback(feedback)
            time.sleep(0.5)
            distance -= 3.0
        goal_handle.succeed()
        result = MoveToShelf.Result()
        result.success = True
        result.final_message = f"Arrived at shelf {shelf}"
        return result


def main(args=None):
    rclpy.init(args=args)
    node = MotorController()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
