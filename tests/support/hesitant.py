"""A robot that takes its time before it takes a goal."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future


class Hesitant(Node):
    """Takes a goal only when it is told to, and drives it until it is cancelled."""

    def __init__(self, action: str = "move_to_shelf", **options: Any) -> None:
        super().__init__("hesitant", **options)
        self.seen = 0
        self.takes: Future[bool] = Future()
        self.cancelled: Future[bool] = Future()
        self.create_timer(0.05, lambda: None)  # an awaited future is noticed when something wakes
        self.server = ActionServer(
            self,
            MoveToShelf,
            action,
            self.execute,
            goal_callback=self.on_goal,
            cancel_callback=self.on_cancel,
            callback_group=ReentrantCallbackGroup(),
        )

    async def on_goal(self, request: Any) -> GoalResponse:
        self.seen += 1
        return GoalResponse.ACCEPT if await self.takes else GoalResponse.REJECT

    def on_cancel(self, goal: Any) -> CancelResponse:
        self.cancelled.set_result(True)
        return CancelResponse.ACCEPT

    async def execute(self, goal: Any) -> Any:
        await self.cancelled
        goal.canceled()
        return MoveToShelf.Result(success=False, final_message="Cancelled")

    def answer(self, taken: bool = True) -> None:
        """Take the goal, or refuse it."""
        assert self.executor is not None
        self.executor.create_task(lambda: self.takes.set_result(taken))
