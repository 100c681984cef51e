"""The module `rclpy.action.client`."""

from __future__ import annotations

import contextlib
import uuid
import weakref
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalInfo, GoalStatus
from action_msgs.srv import CancelGoal
from rclpy import _time_source
from rclpy._names import topic_problem
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import CallbackGroup
from rclpy.executors import await_or_execute
from rclpy.qos import (
    QoSProfile,
    qos_profile_action_status_default,
    qos_profile_services_default,
)
from rclpy.task import Future, wait_for
from rclpy.type_support import check_is_valid_action_type
from unique_identifier_msgs.msg import UUID

if TYPE_CHECKING:
    from rclpy.node import Node


ACTIVE = (
    GoalStatus.STATUS_ACCEPTED,
    GoalStatus.STATUS_EXECUTING,
    GoalStatus.STATUS_CANCELING,
)


class ClientGoalHandle:
    """A goal that was sent and that the server has answered, as its client sees it.

    Handles of the same goal are equal; they have no hash.
    """

    def __init__(self, client: ActionClient, goal_id: UUID, response: Any) -> None:
        self._client = client
        self._goal_id = goal_id
        self.accepted = bool(response.accepted)
        self.stamp = response.stamp  # When the server accepted the goal; 0 if refused.
        # One of GoalStatus's constants, the last received; it stays so if the goal was refused.
        self.status = GoalStatus.STATUS_UNKNOWN

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and self.goal_id == other.goal_id

    __hash__ = None  # type: ignore[assignment]  # as rclpy's

    def __repr__(self) -> str:
        about = f"accepted={self.accepted}, status={self.status}"
        return f"ClientGoalHandle <id={self.goal_id.uuid}, {about}>"

    @property
    def goal_id(self) -> UUID:
        """Return the goal's UUID."""
        return self._goal_id

    def get_result_async(self) -> Future[Any]:
        """Request the result; the future gets a response with `status` and `result`.

        The response comes when the goal has ended; for a goal that the server does not know it
        comes at once, with STATUS_UNKNOWN. From then on no feedback is handed on.
        """
        request = self._client._action_type.Impl.GetResultService.Request(goal_id=self.goal_id)
        future: Future[Any] = self._client._result_client.call_async(request)
        key = bytes(self.goal_id.uuid)
        callbacks = self._client._feedback_callbacks
        future.add_done_callback(lambda _: callbacks.pop(key, None))
        return future

    def cancel_goal_async(self) -> Future[CancelGoal.Response]:
        """Request to cancel the goal; an empty `goals_canceling` in the response means refused."""
        info = GoalInfo(goal_id=self.goal_id)
        return self._client._cancel_client.call_async(CancelGoal.Request(goal_info=info))

    def get_result(self) -> Any:
        """Block until the goal has ended, and return the response of `get_result_async`.

        Another thread must spin the node.
        """
        return _wait(self.get_result_async())

    def cancel_goal(self) -> Any:
        """Request to cancel the goal, and block until the response of `cancel_goal_async` is there.

        Another thread must spin the node.
        """
        return _wait(self.cancel_goal_async())


class ActionClient:
    """A client of an action: it sends goals and receives their status, feedback and results."""

    def __init__(
        self,
        node: Node,
        action_type: Any,
        action_name: str,
        *,
        callback_group: CallbackGroup | None = None,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_sub_qos_profile: QoSProfile = QoSProfile(depth=10),  # noqa: B008
        status_sub_qos_profile: QoSProfile = qos_profile_action_status_default,
    ) -> None:
        check_action(action_type, action_name)
        self._node = node
        self._action_type = action_type
        self._goal_handles: weakref.WeakValueDictionary[bytes, ClientGoalHandle] = (
            weakref.WeakValueDictionary()
        )
        self._feedback_callbacks: dict[bytes, Callable[[Any], Any]] = {}
        impl, prefix = action_type.Impl, f"{action_name}/_action"
        self._goal_client, self._cancel_client, self._result_client = self._clients = [
            node.create_client(
                srv_type, f"{prefix}/{name}", qos_profile=qos, callback_group=callback_group
            )
            for srv_type, name, qos in (
                (impl.SendGoalService, "send_goal", goal_service_qos_profile),
                (impl.CancelGoalService, "cancel_goal", cancel_service_qos_profile),
                (impl.GetResultService, "get_result", result_service_qos_profile),
            )
        ]
        self._subscriptions = [
            node.create_subscription(
                kind, f"{prefix}/{name}", callback, qos, callback_group=callback_group
            )
            for kind, name, callback, qos in (
                (impl.FeedbackMessage, "feedback", self._on_feedback, feedback_sub_qos_profile),
                (impl.GoalStatusMessage, "status", self._on_status, status_sub_qos_profile),
            )
        ]

        for entity in (*self._clients, *self._subscriptions):
            entity._rank, entity._is_part_of_action = 0, True
        self._status = self._subscriptions[1]
        self._status._follows_changes = True
        self._status._queue = deque()  # Without a bound, so that no change is lost.

    def send_goal_async(
        self,
        goal: Any,
        feedback_callback: Callable[[Any], Any] | None = None,
        goal_uuid: UUID | None = None,
    ) -> Future[ClientGoalHandle]:
        """Send a goal; the future gets the goal's handle when the server has accepted or refused.

        Without a server the future stays pending. Cancelling the future does not cancel the goal:
        only the server's answer is dropped.
        """
        if not isinstance(goal, self._action_type.Goal):
            raise TypeError(
                f"Expected goal type ({self._action_type.Goal}) but received ({type(goal)})"
            )
        self._use("send goal request")
        goal_id = goal_uuid or UUID(uuid=list(uuid.uuid4().bytes))
        if feedback_callback is not None:
            self._feedback_callbacks[bytes(goal_id.uuid)] = feedback_callback
        request = self._action_type.Impl.SendGoalService.Request(goal_id=goal_id, goal=goal)
        accepted: Future[ClientGoalHandle] = Future(executor=self._node.executor)

        answer = self._goal_client.call_async(request)

        def on_response() -> None:
            if answer.cancelled():
                return
            handle = ClientGoalHandle(self, goal_id, answer.result())
            if handle.accepted:
                self._goal_handles[bytes(goal_id.uuid)] = handle
            else:
                self._feedback_callbacks.pop(bytes(goal_id.uuid), None)
            accepted.set_result(handle)

        answer._when_done(on_response)  # At once, since the goal's status may be next in the queue.
        accepted.add_done_callback(lambda future: answer.cancel() if future.cancelled() else None)
        return accepted

    def send_goal(self, goal: Any, **options: Any) -> Any:
        """Send a goal and return its result response, blocking; another thread must spin the node.

        The options are those of `send_goal_async`. The response for a goal that was refused has
        STATUS_UNKNOWN.
        """
        return _wait(self.send_goal_async(goal, **options)).get_result()

    def server_is_ready(self) -> bool:
        """Return True if the action's three services are offered and both its topics published."""
        self._use("check if action server is available")
        return all(client.service_is_ready() for client in self._clients) and all(
            subscription.get_publisher_count() for subscription in self._subscriptions
        )

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Block until the action is offered; return False when `timeout_sec` (s) passed before.

        None means no limit, a negative timeout no wait.
        """
        graph = self._node._graph
        with graph.changed:
            _time_source.wait_until(
                graph.changed,
                lambda: self._goal_client._destroyed or self.server_is_ready(),
                _time_source.patience_ns(timeout_sec),
            )
            return self.server_is_ready()

    def destroy(self) -> None:
        """Leave the graph; futures that are pending stay pending."""
        for client in self._clients:
            self._node.destroy_client(client)
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def _use(self, to_do: str) -> None:
        if self._goal_client._destroyed:
            raise RCLError(f"Failed to {to_do}: the action client is destroyed")

    async def _on_feedback(self, message: Any) -> None:
        callback = self._feedback_callbacks.get(bytes(message.goal_id.uuid))
        if callback is not None:
            await await_or_execute(callback, message)

    def _on_status(self, news: Any) -> None:
        """Note the statuses of a message, and of all that are queued behind it.

        So the handles have them before a result that arrived together with them.
        """
        with contextlib.suppress(IndexError):  # The queue is empty.
            while True:
                self._take_status(news)
                news = self._status._queue.popleft()

    def _take_status(self, news: Any) -> None:
        if not isinstance(news, tuple):
            news = [(bytes(s.goal_info.goal_id.uuid), s.status) for s in news.status_list]
        for key, status in news:
            handle = self._goal_handles.get(key)
            if handle is not None:
                handle.status = status
            if status not in ACTIVE:
                self._goal_handles.pop(key, None)


def check_action(action_type: Any, name: str) -> None:
    """Raise AttributeError unless the type is an action's, and ValueError for a bad name."""
    check_is_valid_action_type(action_type)
    if problem := topic_problem(name):
        raise ValueError(f"invalid topic name '{name}' of an action: {problem}")


def _wait(future: Future[Any]) -> Any:
    wait_for(future, None)
    return future.result()
