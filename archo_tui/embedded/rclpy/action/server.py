"""`rclpy.action.ActionServer`."""

from __future__ import annotations

import inspect
import threading
import traceback
from collections import deque
from collections.abc import Callable
from enum import Enum
from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy import _time_source
from rclpy._names import topic_problem
from rclpy._rclpy_pybind11 import RCLError
from rclpy.action import _goal_states as states
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import (
    QoSProfile,
    qos_profile_action_status_default,
    qos_profile_services_default,
)
from rclpy.service import DeferredService, RequestHeader, Service
from rclpy.task import Future

if TYPE_CHECKING:
    from rclpy.node import Node


class GoalResponse(Enum):
    """A goal callback's answer."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(Enum):
    """A cancel callback's answer."""

    REJECT = 1
    ACCEPT = 2


class ServerGoalHandle:
    """One accepted goal, as its server sees it."""

    def __init__(self, server: ActionServer, info: GoalInfo, request: Any) -> None:
        self._server = server
        self._info = info
        self._request = request
        self._status = GoalStatus.STATUS_ACCEPTED
        self._lock = threading.Lock()
        self._result: Future[Any] = Future()
        self._expires: int | None = None  # monotonic ns

    @property
    def request(self) -> Any:
        """The goal message."""
        return self._request

    @property
    def goal_id(self) -> Any:
        """The goal's UUID."""
        return self._info.goal_id

    @property
    def status(self) -> int:
        """One of GoalStatus's constants."""
        return self._status

    @property
    def is_active(self) -> bool:
        """True until the goal has succeeded, was aborted or canceled."""
        return self._status in states.ACTIVE

    @property
    def is_cancel_requested(self) -> bool:
        """True once a cancel was accepted, until the goal has ended."""
        return self._status == GoalStatus.STATUS_CANCELING

    def execute(self, execute_callback: Callable[[ServerGoalHandle], Any] | None = None) -> None:
        """Have the goal executed, in a later turn of the executor."""
        if not self.is_cancel_requested:
            self._update(states.EXECUTE)
        self._server._start(self, execute_callback)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the clients. Raises TypeError for another type."""
        if not isinstance(feedback, self._server.action_type.Feedback):
            raise TypeError
        message = self._server.action_type.Impl.FeedbackMessage(
            goal_id=self.goal_id, feedback=feedback
        )
        self._server._feedback.publish(message)

    def succeed(self) -> None:
        """End the goal as SUCCEEDED. Raises RCLError when it has ended."""
        self._update(states.SUCCEED)

    def abort(self) -> None:
        """End the goal as ABORTED. Raises RCLError when it has ended."""
        self._update(states.ABORT)

    def canceled(self) -> None:
        """End the goal as CANCELED. Raises RCLError unless a cancel was accepted."""
        self._update(states.CANCELED)

    def destroy(self) -> None:
        """Forget the goal; who asks for its result hears of no such goal."""
        self._server._goals.pop(bytes(self.goal_id.uuid), None)

    def _update(self, event: str) -> None:
        with self._lock:
            self._status = states.next_state(self._status, event)
        self._server._publish_status(self)


class GoalEvent(Enum):
    """What moves a goal from one state to another."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


def default_handle_accepted_callback(goal_handle: ServerGoalHandle) -> None:
    """Execute the goal."""
    goal_handle.execute()


def default_goal_callback(goal_request: Any) -> GoalResponse:
    """Accept it."""
    return GoalResponse.ACCEPT


def default_cancel_callback(cancel_request: Any) -> CancelResponse:
    """Reject it."""
    return CancelResponse.REJECT


class ActionServer:
    """Serves one action. Cancels are rejected unless `cancel_callback` accepts them."""

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
        """`result_timeout` is how long a result is kept after the goal has ended, in s.

        Raises TypeError for an `execute_callback` that cannot be called, ValueError for a name that
        is none and a negative timeout.
        """
        problem = topic_problem(action_name)
        if problem:
            raise ValueError(
                f"Failed to create action server due to invalid topic name '{action_name}' : "
                f"{problem[0]}"
            )
        if result_timeout < 0:
            raise ValueError("Failed to create action server: timer period must be non-negative")
        self._node = node
        self.action_type = action_type
        self.register_execute_callback(execute_callback)
        self._goal_callback = goal_callback
        self._handle_accepted_callback = handle_accepted_callback
        self._cancel_callback = cancel_callback
        self._result_timeout = result_timeout
        self._goals: dict[bytes, ServerGoalHandle] = {}
        self._ended: deque[ServerGoalHandle] = deque()  # the first to expire first
        self._logger = node.get_logger().get_child("action_server")
        impl = action_type.Impl
        goal_qos, cancel_qos = goal_service_qos_profile, cancel_service_qos_profile

        def serve(
            kind: Any, srv_type: Any, name: str, callback: Any, qos: QoSProfile
        ) -> Service[Any, Any]:
            full = f"{action_name}/_action/{name}"
            service = node._add_service(kind, srv_type, full, callback, callback_group, qos)
            service._rank, service._is_part_of_action = 0, True
            return service

        self._services = [
            serve(DeferredService, impl.SendGoalService, "send_goal", self._on_goal, goal_qos),
            serve(Service, impl.CancelGoalService, "cancel_goal", self._on_cancel, cancel_qos),
            serve(
                DeferredService,
                impl.GetResultService,
                "get_result",
                self._on_result,
                result_service_qos_profile,
            ),
        ]
        self._feedback = node.create_publisher(
            impl.FeedbackMessage, f"{action_name}/_action/feedback", feedback_pub_qos_profile
        )
        self._status = node.create_publisher(
            impl.GoalStatusMessage, f"{action_name}/_action/status", status_pub_qos_profile
        )
        self._status._kept_by(self._all_statuses)
        self._feedback._is_part_of_action = self._status._is_part_of_action = True

    def register_execute_callback(self, execute_callback: Callable[..., Any]) -> None:
        """Execute goals with this from now on. Raises TypeError for what cannot be called."""
        self._execute_callback = _callable(execute_callback, "goal execution callback")

    def register_goal_callback(self, goal_callback: Callable[..., Any] | None) -> None:
        """Ask this whether to take a goal; None: the default."""
        self._goal_callback = _callable(goal_callback or default_goal_callback)

    def register_cancel_callback(self, cancel_callback: Callable[..., Any] | None) -> None:
        """Ask this whether to cancel a goal; None: the default."""
        self._cancel_callback = _callable(cancel_callback or default_cancel_callback)

    def register_handle_accepted_callback(
        self, handle_accepted_callback: Callable[..., Any] | None
    ) -> None:
        """Hand accepted goals to this; None: the default."""
        chosen = handle_accepted_callback or default_handle_accepted_callback
        self._handle_accepted_callback = _callable(chosen)

    def __enter__(self) -> ActionServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def destroy(self) -> None:
        """Stop offering the action."""
        for service in self._services:
            self._node.destroy_service(service)
        self._node.destroy_publisher(self._feedback)
        self._node.destroy_publisher(self._status)

    async def _on_goal(self, request: Any, header: RequestHeader) -> None:
        self._forget_expired()
        response = self.action_type.Impl.SendGoalService.Response()
        goal_id = bytes(request.goal_id.uuid)
        answer = GoalResponse.REJECT
        if goal_id not in self._goals:
            answer = await _value(self._goal_callback(request.goal))
            if not isinstance(answer, GoalResponse):
                self._logger.warning(
                    "Goal request callback did not return a GoalResponse type. Rejecting goal."
                )
        response.accepted = answer == GoalResponse.ACCEPT
        if not response.accepted:
            self._services[0].send_response(response, header)
            return
        response.stamp = self._node.get_clock().now().to_msg()
        info = GoalInfo(goal_id=request.goal_id, stamp=response.stamp)
        goal = ServerGoalHandle(self, info, request.goal)
        self._goals[goal_id] = goal
        self._services[0].send_response(response, header)
        self._publish_status(goal)
        await _value(self._handle_accepted_callback(goal))

    def _start(self, goal: ServerGoalHandle, callback: Any) -> None:
        self._create_task(self._execute, goal, callback or self._execute_callback)

    async def _execute(self, goal: ServerGoalHandle, callback: Any) -> None:
        try:
            result = await _value(callback(goal))
        except Exception as error:
            result = self.action_type.Result()
            self._logger.error(f"Error raised in execute callback: {error}")
            traceback.print_exc()
        if goal.is_active:
            self._logger.warning(
                f"Goal state not set, assuming aborted. Goal ID: {goal.goal_id.uuid}"
            )
            goal.abort()
        goal._expires = _time_source.deadline_ns(self._result_timeout)
        self._ended.append(goal)
        goal._result.set_result(
            self.action_type.Impl.GetResultService.Response(status=goal.status, result=result)
        )

    async def _on_cancel(self, request: CancelGoal.Request, response: Any) -> Any:
        self._forget_expired()
        response.return_code, goals = self._asked_to_cancel(request.goal_info)
        accepted = []
        for goal in goals:
            if await _value(self._cancel_callback(goal)) == CancelResponse.ACCEPT:
                try:
                    goal._update(states.CANCEL_GOAL)
                    accepted.append(goal._info)
                except RCLError:
                    self._logger.debug("the goal ended before it could be canceled")
        response.goals_canceling = accepted
        return response

    def _asked_to_cancel(self, info: GoalInfo) -> tuple[int, list[ServerGoalHandle]]:
        """The goals that a cancel request names: all, those until a time, or one of them too."""
        goal_id, until = bytes(info.goal_id.uuid), _ns(info.stamp)
        if any(goal_id) and not until:
            goal = self._goals.get(goal_id)
            if goal is None:
                return CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID, []
            if not states.is_cancelable(goal.status):
                return CancelGoal.Response.ERROR_GOAL_TERMINATED, []
            return CancelGoal.Response.ERROR_NONE, [goal]
        named = [
            goal
            for key, goal in self._goals.items()
            if states.is_cancelable(goal.status)
            and (key == goal_id or not until or _ns(goal._info.stamp) <= until)
        ]
        return CancelGoal.Response.ERROR_NONE, named

    def _on_result(self, request: Any, header: RequestHeader) -> None:
        self._forget_expired()
        goal = self._goals.get(bytes(request.goal_id.uuid))
        service = self._services[2]
        if goal is None:
            unknown = self.action_type.Impl.GetResultService.Response()
            service.send_response(unknown, header)
            return
        goal._result.add_done_callback(
            lambda future: service.send_response(future.result(), header)
        )

    def _publish_status(self, changed: ServerGoalHandle) -> None:
        """Tell of every goal that is kept; an action client of this engine, of the changed one."""
        key, status = bytes(changed.goal_id.uuid), changed.status
        self._status._publish_lazily(self._all_statuses, ((key, status),))

    def _all_statuses(self) -> GoalStatusArray:
        goals = list(self._goals.values())
        statuses = [GoalStatus(goal_info=goal._info, status=goal.status) for goal in goals]
        return GoalStatusArray(status_list=statuses)

    def _forget_expired(self) -> None:
        now = _time_source.monotonic_ns()
        while self._ended and (self._ended[0]._expires or 0) <= now:
            self._goals.pop(bytes(self._ended.popleft().goal_id.uuid), None)

    def _create_task(self, callback: Any, *args: Any) -> None:
        if self._node.executor is not None:
            self._node.executor.create_task(callback, *args)


def _callable(given: Any, name: str = "callback") -> Any:
    if not callable(given):
        raise TypeError(f"Failed to register {name}: not callable")
    return given


async def _value(result: Any) -> Any:
    """What a callback returned, awaited when it was a coroutine."""
    return await result if inspect.iscoroutine(result) else result


def _ns(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
