"""An action whose goals are tracked: its client, and its feedback and status."""

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
        kind: The kind of goal for which this object was made; other kinds of the action share it.
        since: When this object was made, in Unix seconds.
        name: The full name of the action.
        reported: The ids of the goals in the last status message that came while the action had a
            single server; None before the first. Set by `GoalFinder`.
        type: The class of the action. None if it is not installed here: then nothing is subscribed
            to, and `client` and `status_topic` are not set.
        client: rclpy's action client; None in a console that only watches.
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
        """Create the client, and subscribe to feedback and status, if the type is installed here.

        Args:
            node: The console's node.
            kind: A kind of goal for this action.
            on_feedback: Called with this object and each feedback message.
            on_status: Called with this object and each status message.
            watching: True to create no client except that for results.
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
        """True if a server of the action is found; False if its type is not installed here."""
        if self.type is None:
            return False
        if self.client is None:
            return bool(self._results.service_is_ready())
        return bool(self.client.server_is_ready())

    def ask_result(self, goal_id: bytes) -> Any:
        """Request the result of a goal, which its server sends when the goal has ended.

        Args:
            goal_id: The 16 bytes of the goal's UUID.

        Returns:
            The future of the answer. It ends with the answer of the server that knows the goal, or,
            if none does, when all have answered.
        """
        request = self.type.Impl.GetResultService.Request(goal_id=UUID(uuid=list(goal_id)))
        future = self._results.call_async(request)
        known = lambda answer: answer.status != GoalStatus.STATUS_UNKNOWN  # noqa: E731
        # Only one of the servers knows the goal.
        services.require_all_answers(future, self.servers, known)
        return future

    @property
    def servers(self) -> int:
        """The number of servers of the action; normally 1. Each request reaches all of them."""
        return int(self._node.count_services(f"{self.kind.action}/_action/cancel_goal"))
