"""The actions whose goals are tracked: their clients, feedback and status. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.qos import qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from archo_tui.clock import Clock
from archo_tui.robot import calls
from archo_tui.robot.calls import DEADLINE, Services
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.node import Listener
from archo_tui.robot_file.model import GoalKind

FIND_PERIOD = 0.05  # Seconds between two looks for a server, or for an answer.


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
        node.listen(
            impl.FeedbackMessage,
            f"{self._topics}/feedback",
            lambda message: on_feedback(self, message),
            10,
        )
        node.listen(
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


class GoalActions:
    """The actions whose goals are tracked.

    Attributes:
        exempt: The full names of those whose goals no STOP cancels.
    """

    def __init__(
        self,
        node: Listener,
        clock: Clock,
        pending: Services,
        exempt: Collection[str],
        watching: bool,
        on_feedback: Callable[[GoalAction, Any], None],
        on_status: Callable[[GoalAction, Any], None],
    ) -> None:
        self._node, self._clock, self._services = node, clock, pending
        self._watching, self._callbacks = watching, (on_feedback, on_status)
        self.exempt = {str(node.resolve_service_name(name)) for name in exempt}
        self._actions: dict[tuple[str, str], GoalAction] = {}  # By name and type.

    def is_tracked(self, kind: GoalKind) -> bool:
        """Return True once `track` was called for the action."""
        return (kind.action, kind.type) in self._actions

    def track(self, kind: GoalKind) -> GoalAction:
        """Track the goals of an action from the first call on; return the action."""
        key = (kind.action, kind.type)
        if key not in self._actions:
            now = self._clock.now()
            is_exempt = str(self._node.resolve_service_name(kind.action)) in self.exempt
            made = GoalAction(self._node, kind, *self._callbacks, self._watching, now, is_exempt)
            self._actions[key] = made
        return self._actions[key]

    def close(self) -> None:
        """Destroy the clients: with one left, rclpy keeps the node on the graph."""
        for action in self._actions.values():
            action.close()

    async def cancel_every(
        self, others: Iterable[str] = (), until: float = 0.0, *, for_stop: bool
    ) -> tuple[set[bytes], str] | None:
        """Cancel all goals of these and of other actions; return their ids, and who is silent.

        Servers of these are waited for until a time. All requests leave at once: an action that
        does not answer delays no other. Returns None if there is no action.
        """
        exempt = self.exempt if for_stop else set()
        executor: Any = self._node.executor
        asked: dict[str, Any] = {}
        while True:
            known = [a for a in self._actions.values() if a.type and a.name not in exempt]
            served = [action.name for action in known if action.is_served]
            for name in {*others, *served} - exempt - asked.keys():
                asked[name] = executor.create_task(self._cancel_goals_of, name)
            if len(served) == len(known) or self._clock.monotonic() >= until:
                break
            await self._services.pause(FIND_PERIOD)
        answers = {name: await task for name, task in asked.items()}
        ids = set[bytes]().union(*(cancelled for cancelled, _ in answers.values()))
        silent = ", ".join(name for name, (_, is_answered) in answers.items() if not is_answered)
        text = f"no answer to the cancel in {DEADLINE:g} s: {silent}" if silent else ""
        return (ids, text) if asked else None

    async def _cancel_goals_of(self, action: str) -> tuple[set[bytes], bool]:
        """Cancel all goals of an action; return their ids, and True if all servers answered."""
        name = f"{action}/_action/cancel_goal"
        servers = max(self._node.count_services(name), 1)
        request = CancelGoal.Request()  # In action_msgs, no id and no time mean all goals.
        answers = await self._services.call_all(CancelGoal, name, request, servers, DEADLINE)
        ids = {bytes(g.goal_id.uuid) for answer in answers for g in answer.goals_canceling}
        return ids, len(answers) >= servers


def _uuid(goal_id: bytes) -> UUID:
    return UUID(uuid=list(goal_id))
