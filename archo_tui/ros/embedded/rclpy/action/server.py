"""The module `rclpy.action.server`."""

from __future__ import annotations

import threading
import traceback
from collections import deque
from collections.abc import Callable
from enum import Enum
from functools import partial, partialmethod
from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy._rclpy_pybind11 import RCLError
from rclpy.action.client import ACTIVE, check_action
from rclpy.callback_groups import CallbackGroup
from rclpy.executors import await_or_execute
from rclpy.qos import (
    QoSProfile,
    qos_profile_action_status_default,
    qos_profile_services_default,
)
from rclpy.service import DeferredService, RequestHeader, Service
from rclpy.task import Future

if TYPE_CHECKING:
    from rclpy.node import Node


class GoalEvent(Enum):
    """The events that move a goal from one state to another, as rclpy names them."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


_NEXT = {
    (GoalStatus.STATUS_ACCEPTED, GoalEvent.EXECUTE): GoalStatus.STATUS_EXECUTING,
    (GoalStatus.STATUS_ACCEPTED, GoalEvent.CANCEL_GOAL): GoalStatus.STATUS_CANCELING,
    (GoalStatus.STATUS_EXECUTING, GoalEvent.CANCEL_GOAL): GoalStatus.STATUS_CANCELING,
    (GoalStatus.STATUS_EXECUTING, GoalEvent.SUCCEED): GoalStatus.STATUS_SUCCEEDED,
    (GoalStatus.STATUS_EXECUTING, GoalEvent.ABORT): GoalStatus.STATUS_ABORTED,
    (GoalStatus.STATUS_CANCELING, GoalEvent.SUCCEED): GoalStatus.STATUS_SUCCEEDED,
    (GoalStatus.STATUS_CANCELING, GoalEvent.ABORT): GoalStatus.STATUS_ABORTED,
    (GoalStatus.STATUS_CANCELING, GoalEvent.CANCELED): GoalStatus.STATUS_CANCELED,
}


def _is_cancelable(state: int) -> bool:
    """Return True for an accepted or executing goal, which a cancel request may still reach."""
    return (state, GoalEvent.CANCEL_GOAL) in _NEXT


class GoalResponse(Enum):
    """The answer of a goal callback."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(Enum):
    """The answer of a cancel callback."""

    REJECT = 1
    ACCEPT = 2


class ServerGoalHandle:
    """An accepted goal, as its server sees it: callbacks get it, and end the goal by it.

    Handles of the same goal are equal; they have no hash.
    """

    def __init__(self, server: ActionServer, info: GoalInfo, request: Any) -> None:
        self._server = server
        self._info = info
        self.request = request  # The goal message.
        self._status = GoalStatus.STATUS_ACCEPTED
        self._lock = threading.Lock()
        self._result: Future[Any] = Future()
        self._expires = 0  # In ns of the node's clock, once the goal has ended.
        self._destroyed = False

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ServerGoalHandle) and self.goal_id == other.goal_id

    __hash__ = None  # type: ignore[assignment]  # as rclpy's

    @property
    def goal_id(self) -> Any:
        """Return the goal's UUID."""
        return self._info.goal_id

    @property
    def status(self) -> int:
        """Return one of GoalStatus's constants; STATUS_UNKNOWN once the goal is forgotten.

        A goal is forgotten when its result expires, or by `destroy()` of the goal or its server.
        """
        self._server._forget_expired()
        return GoalStatus.STATUS_UNKNOWN if self._destroyed else int(self._status)

    @property
    def is_active(self) -> bool:
        """Return True until the goal has succeeded, was aborted or canceled, or is forgotten.

        See `status` about a goal that is forgotten.
        """
        return self.status in ACTIVE

    @property
    def is_cancel_requested(self) -> bool:
        """Return True once a cancel was accepted, until the goal has ended."""
        return self.status == GoalStatus.STATUS_CANCELING

    def execute(self, execute_callback: Callable[[ServerGoalHandle], Any] | None = None) -> None:
        """Set the goal EXECUTING, unless a cancel was accepted, and schedule its execution.

        The status is published at once; the callback runs in a later turn of the executor. A
        forgotten goal is executed, too, but has no status.
        """
        if not self.is_cancel_requested:
            self._update(GoalEvent.EXECUTE)
        self._server.notify_execute(self, execute_callback)

    def publish_feedback(self, feedback: Any) -> None:
        """Publish feedback on this goal; do nothing once the goal is forgotten."""
        if not isinstance(feedback, self._server.action_type.Feedback):
            raise TypeError
        if self._destroyed:
            return
        message = self._server.action_type.Impl.FeedbackMessage(
            goal_id=self.goal_id, feedback=feedback
        )
        self._server._feedback.publish(message)

    def _update(self, event: GoalEvent) -> None:
        with self._lock:
            if self._destroyed:
                return
            if (self._status, event) not in _NEXT:
                state = f"invalid transition from state {self._status}: {event.name}"
                raise RCLError(f"Failed to update goal state: goal_handle attempted {state}")
            self._status = _NEXT[self._status, event]
        self._server._publish_status(self)

    # Each ends the goal, and publishes that; it does nothing once the goal is forgotten.
    succeed = partialmethod(_update, GoalEvent.SUCCEED)
    abort = partialmethod(_update, GoalEvent.ABORT)
    canceled = partialmethod(_update, GoalEvent.CANCELED)

    def destroy(self) -> None:
        """Forget the goal: it can no longer be canceled, and its end is not published."""
        self._destroyed = True


def default_handle_accepted_callback(goal_handle: ServerGoalHandle) -> None:
    """Call `execute()` of an accepted goal."""
    goal_handle.execute()


def default_goal_callback(goal_request: Any) -> GoalResponse:
    """Accept every goal."""
    return GoalResponse.ACCEPT


def default_cancel_callback(cancel_request: Any) -> CancelResponse:
    """Reject every cancel."""
    return CancelResponse.REJECT


class ActionServer:
    """A server of an action. Cancels are rejected unless `cancel_callback` accepts them.

    A goal that `execute_callback` leaves active is aborted. An exception of the callback is logged,
    and the goal's result is then an empty one.
    """

    def __init__(
        self,
        node: Node,
        action_type: Any,
        action_name: str,
        execute_callback: Callable[[ServerGoalHandle], Any],
        *,
        callback_group: CallbackGroup | None = None,
        goal_callback: Callable[[Any], Any] = default_goal_callback,
        handle_accepted_callback: Callable[
            [ServerGoalHandle], Any
        ] = default_handle_accepted_callback,
        cancel_callback: Callable[[ServerGoalHandle], Any] = default_cancel_callback,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_pub_qos_profile: QoSProfile = QoSProfile(depth=10),  # noqa: B008
        status_pub_qos_profile: QoSProfile = qos_profile_action_status_default,
        result_timeout: float = 10,
    ) -> None:
        check_action(action_type, action_name)
        if result_timeout < 0:
            raise ValueError("Failed to create action server: timer period must be non-negative")
        self._node = node
        self.action_type = action_type
        self.register_execute_callback(execute_callback)
        self.register_goal_callback(goal_callback)
        self.register_handle_accepted_callback(handle_accepted_callback)
        self.register_cancel_callback(cancel_callback)
        self._clock, self._result_timeout = node.get_clock(), round(result_timeout * 1e9)  # ns
        self._kept: dict[bytes, ServerGoalHandle] = {}
        self._ended: deque[ServerGoalHandle] = deque()  # The first to expire comes first.
        self._logger = node.get_logger().get_child("action_server")
        impl, goal_qos = action_type.Impl, goal_service_qos_profile
        cancel_qos, result_qos = cancel_service_qos_profile, result_service_qos_profile
        self._goal_service, self._cancel_service, self._result_service = self._services = [
            node._add(
                partial(kind, callback),
                node._graph.services,
                srv_type,
                f"{action_name}/_action/{name}",
                callback_group,
                qos,
            )
            for kind, srv_type, name, callback, qos in (
                (DeferredService, impl.SendGoalService, "send_goal", self._on_goal, goal_qos),
                (Service, impl.CancelGoalService, "cancel_goal", self._on_cancel, cancel_qos),
                (DeferredService, impl.GetResultService, "get_result", self._on_result, result_qos),
            )
        ]
        for service in self._services:
            service._rank, service._is_part_of_action = 0, True
        self._feedback = node.create_publisher(
            impl.FeedbackMessage, f"{action_name}/_action/feedback", feedback_pub_qos_profile
        )
        self._status = node.create_publisher(
            impl.GoalStatusMessage, f"{action_name}/_action/status", status_pub_qos_profile
        )
        self._status._set_latched(self._all_statuses)
        self._feedback._is_part_of_action = self._status._is_part_of_action = True

    @property
    def _goal_handles(self) -> dict[bytes, ServerGoalHandle]:
        """Return the handles of goals whose results have not expired, by the bytes of their ids."""
        self._forget_expired()
        return self._kept

    def register_execute_callback(self, execute_callback: Callable[..., Any]) -> None:
        """Execute goals with this callback from now on; raise TypeError if it cannot be called."""
        if not callable(execute_callback):
            raise TypeError("Failed to register goal execution callback: not callable")
        self._execute_callback = execute_callback

    def register_goal_callback(self, goal_callback: Callable[..., Any] | None) -> None:
        """Let this callback accept or refuse goals from now on; None accepts all of them."""
        self._goal_callback = goal_callback or default_goal_callback

    def register_cancel_callback(self, cancel_callback: Callable[..., Any] | None) -> None:
        """Let this callback accept or refuse cancels from now on; None refuses all of them."""
        self._cancel_callback = cancel_callback or default_cancel_callback

    def register_handle_accepted_callback(
        self, handle_accepted_callback: Callable[..., Any] | None
    ) -> None:
        """Hand accepted goals to this callback from now on; None executes them."""
        self._handle_accepted_callback = (
            handle_accepted_callback or default_handle_accepted_callback
        )

    def destroy(self) -> None:
        """Stop offering the action and forget its goals; their results are never sent."""
        for goal in self._goal_handles.values():
            goal.destroy()
        for service in self._services:
            self._node.destroy_service(service)
        self._node.destroy_publisher(self._feedback)
        self._node.destroy_publisher(self._status)

    async def _on_goal(self, request: Any, header: RequestHeader) -> None:
        response = self.action_type.Impl.SendGoalService.Response()
        goal_id = bytes(request.goal_id.uuid)
        answer = GoalResponse.REJECT
        if goal_id not in self._goal_handles:
            answer = await await_or_execute(self._goal_callback, request.goal)
            if not isinstance(answer, GoalResponse):
                self._logger.warning(
                    "Goal request callback did not return a GoalResponse type. Rejecting goal."
                )
        response.accepted = answer == GoalResponse.ACCEPT
        if not response.accepted:
            self._goal_service.send_response(response, header)
            return
        response.stamp = self._node.get_clock().now().to_msg()
        info = GoalInfo(goal_id=request.goal_id, stamp=response.stamp)
        goal = ServerGoalHandle(self, info, request.goal)
        self._goal_handles[goal_id] = goal
        self._goal_service.send_response(response, header)
        self._publish_status(goal)
        await await_or_execute(self._handle_accepted_callback, goal)

    def notify_execute(
        self, goal_handle: ServerGoalHandle, execute_callback: Callable[..., Any] | None
    ) -> None:
        """Schedule a goal's execution in a later turn of the executor.

        While the node has no executor, nothing happens.
        """
        if self._node.executor is not None:
            callback = execute_callback or self._execute_callback
            self._node.executor.create_task(self._execute, goal_handle, callback)

    async def _execute(self, goal: ServerGoalHandle, callback: Any) -> None:
        try:
            result = await await_or_execute(callback, goal)
        except Exception as error:
            result = self.action_type.Result()
            self._logger.error(f"Error raised in execute callback: {error}")
            traceback.print_exc()
        if goal.is_active:
            self._logger.warning(
                f"Goal state not set, assuming aborted. Goal ID: {goal.goal_id.uuid}"
            )
            goal.abort()
        goal._expires = self._clock.now().nanoseconds + self._result_timeout
        self._ended.append(goal)
        goal._result.set_result(
            self.action_type.Impl.GetResultService.Response(status=goal.status, result=result)
        )

    async def _on_cancel(self, request: CancelGoal.Request, response: Any) -> Any:
        response.return_code, goals = self._asked_to_cancel(request.goal_info)
        accepted = []
        for goal in goals:
            answer = await await_or_execute(self._cancel_callback, goal)
            if answer == CancelResponse.ACCEPT:
                try:
                    goal._update(GoalEvent.CANCEL_GOAL)
                    accepted.append(goal._info)
                except RCLError:
                    self._logger.debug("the goal ended before it could be canceled")
        response.goals_canceling = accepted
        return response

    def _asked_to_cancel(self, info: GoalInfo) -> tuple[int, list[ServerGoalHandle]]:
        """Return the code of a cancel response, and the goals that a cancel request means.

        Without an id and a time these are all goals, with an id only that goal, else those accepted
        until the time and the goal of the id. Goals that cannot be canceled are left out.
        """
        goal_id, until = bytes(info.goal_id.uuid), _ns(info.stamp)
        if any(goal_id) and not until:
            goal = self._goal_handles.get(goal_id)
            if goal is None or goal._destroyed:
                return CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID, []
            if not _is_cancelable(goal.status):
                return CancelGoal.Response.ERROR_GOAL_TERMINATED, []
            return CancelGoal.Response.ERROR_NONE, [goal]
        named = [
            goal
            for key, goal in self._goal_handles.items()
            if _is_cancelable(goal.status)
            and (key == goal_id or not until or _ns(goal._info.stamp) <= until)
        ]
        return CancelGoal.Response.ERROR_NONE, named

    def _on_result(self, request: Any, header: RequestHeader) -> None:
        goal = self._goal_handles.get(bytes(request.goal_id.uuid))
        service = self._result_service
        if goal is None:
            unknown = self.action_type.Impl.GetResultService.Response()
            service.send_response(unknown, header)
            return
        goal._result.add_done_callback(
            lambda future: service.send_response(future.result(), header)
        )

    def _publish_status(self, changed: ServerGoalHandle) -> None:
        """Publish the status of all kept goals; action clients get only that of `changed`."""
        key, status = bytes(changed.goal_id.uuid), changed.status
        self._status._publish_lazily(self._all_statuses, ((key, status),))

    def _all_statuses(self) -> GoalStatusArray:
        goals = [goal for goal in self._goal_handles.values() if not goal._destroyed]
        statuses = [GoalStatus(goal_info=goal._info, status=goal.status) for goal in goals]
        return GoalStatusArray(status_list=statuses)

    def _forget_expired(self) -> None:
        while self._ended and self._ended[0]._expires <= self._clock.now().nanoseconds:
            expired = self._ended.popleft()
            expired.destroy()
            self._kept.pop(bytes(expired.goal_id.uuid), None)


def _ns(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
