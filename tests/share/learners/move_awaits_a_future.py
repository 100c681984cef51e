"""A timer drives, and execute awaits: one thread is enough."""
# ok: 7 8
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future


class MotorController(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
        self.server.register_cancel_callback(lambda goal: CancelResponse.ACCEPT)

    async def execute(self, goal):
        done, way = Future(), [0.0, 3.0, 6.0, 9.0, 12.0, 15.0]

        def drive():
            if goal.is_cancel_requested:
                done.set_result("Cancelled mid-route")
            elif not way:
                done.set_result(f"Arrived at shelf {goal.request.shelf_number}")
            else:
                goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=way.pop()))

        timer = self.create_timer(0.5, drive)
        words = await done
        timer.destroy()
        arrived = words.startswith("Arrived")
        goal.succeed() if arrived else goal.canceled()
        return MoveToShelf.Result(success=arrived, final_message=words)
