"""The action of ARCHO's motor by its three services, of which a test writes what matters to it."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from tests.support.ros import begin


class ByHand(Node):
    """Takes every goal, at once or when it is told to, and every cancel, and tells no result."""

    def __init__(self, name: str, hesitates: bool = False, **options: Any) -> None:
        super().__init__(name, **options)
        self.takes: Future[bool] = Future()
        if not hesitates:
            self.takes.set_result(True)
        impl: Any = MoveToShelf.Impl
        self.never: Future[bool] = Future()
        self.goal_ids: list[bytes] = []
        self.cancelled: list[bytes] = []
        self.create_timer(0.1, lambda: None)  # rclpy looks at what waits when it is awake
        group, prefix = ReentrantCallbackGroup(), "move_to_shelf/_action"
        for kind, service, answer in (
            (impl.SendGoalService, "send_goal", self.accept),
            (impl.GetResultService, "get_result", self.result),
            (impl.CancelGoalService, "cancel_goal", self.cancel),
        ):
            self.create_service(kind, f"{prefix}/{service}", answer, callback_group=group)
        self.feedback = self.create_publisher(impl.FeedbackMessage, f"{prefix}/feedback", 10)
        qos = qos_profile_action_status_default
        self.status = self.create_publisher(impl.GoalStatusMessage, f"{prefix}/status", qos)

    async def accept(self, request: Any, response: Any) -> Any:
        self.goal_ids.append(bytes(request.goal_id.uuid))
        response.accepted = True
        await self.takes
        return response

    def take(self) -> None:
        begin(self, lambda: self.takes.set_result(True))

    async def result(self, _: Any, response: Any) -> Any:
        await self.never
        return response

    async def cancel(self, request: Any, response: Any) -> Any:
        self.cancelled.append(bytes(request.goal_info.goal_id.uuid))
        response.goals_canceling = [request.goal_info]
        return response

    def feed(self, goal_id: bytes, left: float) -> None:
        """Tell once how far a goal is from its shelf, in m."""
        said = MoveToShelf.Impl.FeedbackMessage(goal_id=UUID(uuid=list(goal_id)))
        said.feedback.distance_remaining = left
        self.feedback.publish(said)
