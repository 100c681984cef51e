"""An action whose goals are tracked: its client, feedback and status. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.qos import qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from archo_tui.robot import calls
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.node import Listener
from archo_tui.robot_file.model import GoalKind


class GoalAction:
    """The client of one action, and the subscriptions to its feedback and status.

    Attributes:
        kind: The kind of goal for which this object was made; other kinds of the action share it.
        since: When it was made, in Unix seconds.
        name: The full name of the action.
        reported: The ids of the goals in the last status message that came while the action had a
            single server; None before the first. Set by `Goals`.
        is_exempt: True if no STOP cancels its goals.
        type: The class of the action; None if it is not installed here: then nothing is sent.
    """

    def __init__(
        self,
        node: Listener,
        kind: GoalKind,
        on_feedback: Callable[[GoalAction, Any], None],
        on_status: Callable[[GoalAction, Any], None],
        watching: bool,
        since: float,
        is_exempt: bool,
    ) -> None:
        self._node, self.kind, self.since, self.is_exempt = node, kind, since, is_exempt
        self.name = str(node.resolve_service_name(kind.action))
        self.reported: set[bytes] | None = None
        self.type = load_class(kind.type)
        self._client: Any = None  # None in a console that only watches.
        if self.type is None:
            return
        if not watching:
            self._client = ActionClient(node, self.type, kind.action)
        self._topics, impl = f"{kind.action}/_action", self.type.Impl
        self._results = node.create_client(impl.GetResultService, f"{self._topics}/get_result")
        # rclpy's client would drop a goal's feedback once its result is requested a second time.
        node.listen_quietly(
            impl.FeedbackMessage,
            f"{self._topics}/feedback",
            lambda message: on_feedback(self, message),
            10,
        )
        node.listen_quietly(
            impl.GoalStatusMessage,
            f"{self._topics}/status",
            lambda message: on_status(self, message),
            qos_profile_action_status_default,
        )

    def close(self) -> None:
        """Destroy the client."""
        if self._client is not None:
            self._client.destroy()

    @property
    def is_served(self) -> bool:
        """True if a server of the action is found; False if its type is not installed here."""
        if self.type is None:
            return False
        if self._client is None:
            return bool(self._results.service_is_ready())
        return bool(self._client.server_is_ready())

    @property
    def _servers(self) -> int:
        """The number of servers of the action; normally 1. Each request reaches all of them."""
        return int(self._node.count_services(f"{self._topics}/cancel_goal"))

    @property
    def is_alone(self) -> bool:
        """True if a single server reports the status; each of several reports only its goals."""
        return self._node.count_publishers(f"{self._topics}/status") == 1

    def send(self, goal_id: bytes, request: Any) -> Any:
        """Send a goal; return the future of rclpy's handle, which tells if it was accepted."""
        return self._client.send_goal_async(request, goal_uuid=_uuid(goal_id))

    def cancel(self, goal_id: bytes) -> Any:
        """Request the cancel of a goal, accepted or not; return the future of the answer.

        It ends with the answer of the server that cancels the goal, else when all have answered.
        """
        accepted = self.type.Impl.SendGoalService.Response(accepted=True)
        handle = ClientGoalHandle(self._client, _uuid(goal_id), accepted)
        future = handle.cancel_goal_async()
        calls.require_all_answers(future, self._servers, lambda a: len(a.goals_canceling) > 0)
        return future

    def ask_result(self, goal_id: bytes) -> Any:
        """Ask for the result of a goal, which its server sends when the goal has ended.

        The future ends with the answer of the server that knows the goal, or when all have
        answered.
        """
        request = self.type.Impl.GetResultService.Request(goal_id=_uuid(goal_id))
        future = self._results.call_async(request)
        known = lambda answer: answer.status != GoalStatus.STATUS_UNKNOWN  # noqa: E731
        calls.require_all_answers(future, self._servers, known)
        return future


def _uuid(goal_id: bytes) -> UUID:
    return UUID(uuid=list(goal_id))
