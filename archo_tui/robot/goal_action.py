"""An action whose goals are tracked: its client, and the topics on which its goals are reported."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.qos import qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from archo_tui.robot import message_classes, services
from archo_tui.robot.listener import Listener
from archo_tui.robot_file.model import GoalKind


class GoalAction:
    """The client of one action, and the subscriptions to its feedback and status.

    Attributes:
        kind: A kind of goal for this action.
        since: When it was made, in Unix seconds.
        name: The full name of the action.
        reported: The ids of the goals in the last status message; None before the first.
        type: The class of the action; None if it is not installed here, and nothing else works.
        client: rclpy's client; None in a console that only watches.
        status_topic: The name of the topic with the status.
    """

    def __init__(
        self,
        node: Listener,
        kind: GoalKind,
        on_feedback: Callable[[GoalAction, Any], None],
        on_status: Callable[[GoalAction, Any], None],
        watching: bool,
        since: float,
    ) -> None:
        """Make the client and the subscriptions.

        Args:
            node: The console's node.
            kind: A kind of goal for this action.
            on_feedback: Called with this object and each feedback message.
            on_status: Called with this object and each status message.
            watching: True to make no client except that for results.
            since: The time now, in Unix seconds.
        """
        self._node, self.kind, self.since = node, kind, since
        self.name = str(node.resolve_service_name(kind.action))
        self.reported: set[bytes] | None = None
        self.type = message_classes.load(kind.type)
        if self.type is None:
            return
        topics, impl = f"{kind.action}/_action", self.type.Impl
        self.client: Any = None if watching else ActionClient(node, self.type, kind.action)
        self._results = node.create_client(impl.GetResultService, f"{topics}/get_result")
        # rclpy's client would drop a goal's feedback once its result is requested a second time.
        node.listen(
            impl.FeedbackMessage,
            f"{topics}/feedback",
            lambda message: on_feedback(self, message),
            10,
        )
        node.listen(
            impl.GoalStatusMessage,
            f"{topics}/status",
            lambda message: on_status(self, message),
            qos_profile_action_status_default,
        )
        self.status_topic = f"{topics}/status"

    @property
    def is_served(self) -> bool:
        """True if a server is found."""
        if self.type is None:
            return False
        if self.client is None:
            return bool(self._results.service_is_ready())
        return bool(self.client.server_is_ready())

    def ask_result(self, goal_id: bytes) -> Any:
        """Request the result of a goal by its id; return the future of the answer."""
        request = self.type.Impl.GetResultService.Request(goal_id=UUID(uuid=list(goal_id)))
        future = self._results.call_async(request)
        known = lambda answer: answer.status != GoalStatus.STATUS_UNKNOWN  # noqa: E731
        services.hold_open(future, self.servers, known)  # Only one of the servers knows the goal.
        return future

    @property
    def servers(self) -> int:
        """The number of servers; one request reaches all of them."""
        return int(self._node.count_services(f"{self.kind.action}/_action/cancel_goal"))
