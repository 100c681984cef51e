"""The goals of a robot's actions: sent from here, and tracked whoever sent them. ROS thread only.

Their states come from the actions alone: from status, feedback and result.
"""

from __future__ import annotations

import itertools
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.qos import qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot import message_classes, messages, services
from archo_tui.robot.listener import Listener
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.period import Pause
from archo_tui.robot.services import Services
from archo_tui.robot.state import Goal, Motion, Phase, not_offered
from archo_tui.robot.stops import NEVER_LEFT, Gate
from archo_tui.robot.tracked_goal import ENDS, NOBODY_SERVES, TrackedGoal
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import GoalKind

HISTORY = 20  # Ended goals that are kept.
_ENDED_IDS = 100  # Ids that are kept: more than goals end between two status messages.
# All in seconds.
_FIND_PERIOD = 0.05  # Between two looks for the server of an action.
_REASON_WAIT = 0.3  # For the log line with the reason, after a refusal.
_NEW = 1.0  # A younger goal has just begun.
_LONGEST_AGE = 86_400.0  # An older goal has a stamp of another clock.

_RUNNING = {
    GoalStatus.STATUS_ACCEPTED: Phase.MOVING,
    GoalStatus.STATUS_EXECUTING: Phase.MOVING,
    GoalStatus.STATUS_CANCELING: Phase.CANCELLING,
}


def _seconds(status: Any) -> float:
    """Return when the server accepted a goal, in seconds on the robot's clock."""
    stamp = status.goal_info.stamp
    return float(stamp.sec + stamp.nanosec / 1e9)


class _Action:
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
        on_feedback: Callable[[_Action, Any], None],
        on_status: Callable[[_Action, Any], None],
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


class Goals:
    """The goals that run, and the last ones that ended.

    Attributes:
        history: The ended goals, the newest first.
        are_over: True once no goal may be sent any more.
    """

    def __init__(
        self,
        node: Listener,
        clock: Clock,
        pending: Services,
        on_change: Callable[[bool], None],
        note: Callable[[str, str], None],
        on_end: Callable[[Goal, str], None],
        watching: bool = False,
    ) -> None:
        """Begin without goals.

        Args:
            node: The console's node.
            clock: The clock of all times.
            pending: Calls services, and watches deadlines.
            on_change: Called after each change; with True if a goal is new or has another phase.
            note: Called with level and text of an event that no verb reports any more.
            on_end: Called with a goal that was sent and has ended, and a text about its end.
            watching: True for a console that sends nothing.
        """
        self._node, self._clock = node, clock
        self._services = pending
        self._on_change = on_change
        self._note, self._on_end = note, on_end
        self._watching = watching
        self._actions: dict[tuple[str, str], _Action] = {}  # By name and type.
        self._numbers = itertools.count(1)
        self._coming: list[TrackedGoal] = []  # Of this console, about to be sent.
        self._running: dict[bytes, TrackedGoal] = {}
        self._ended_ids: deque[bytes] = deque(maxlen=_ENDED_IDS)
        self._lost: dict[bytes, Goal] = {}  # Goals whose node has left.
        self._last: Goal | None = None  # The goal that ended last.
        self._refusals: deque[str] = deque(maxlen=5)  # Reasons in the log.
        self.history: deque[Goal] = deque(maxlen=HISTORY)
        self.are_over = False
        self._pause = Pause()

    @property
    def goal(self) -> Goal | None:
        """The goal to show: ours that runs, else another that runs, else the last that ended."""
        shown = self._shown
        return self._last if shown is None else shown.goal

    @property
    def running(self) -> int:
        """The number of running goals."""
        return len(self._running)

    @property
    def _shown(self) -> TrackedGoal | None:
        ours = self._ours
        return ours or next(reversed(self._running.values()), None)

    @property
    def _ours(self) -> TrackedGoal | None:
        return next((tracked for tracked in self._running.values() if tracked.goal.mine), None)

    def open(self, kind: GoalKind) -> _Action:
        """Return the client of an action; its goals are tracked from the first call on."""
        key = (kind.action, kind.type)
        if key not in self._actions:
            callbacks = self._on_feedback, self._on_status
            made = _Action(self._node, kind, *callbacks, self._watching, self._clock.now())
            self._actions[key] = made
        return self._actions[key]

    def close(self) -> None:
        """Destroy the clients of the actions: with one left, rclpy keeps the node on the graph."""
        for action in self._actions.values():
            if action.type is not None and action.client is not None:
                action.client.destroy()

    async def send(
        self, kind: GoalKind, values: Mapping[str, Any], length: float | None, gate: Gate
    ) -> Outcome:
        """Send a goal; return when it was accepted, refused, or not answered in time.

        If a STOP is read before the goal is accepted, it is cancelled as soon as it is.

        Args:
            kind: The kind of goal.
            values: The typed values by dotted path.
            length: The length of the way, in the unit of the remainder; None if not known.
            gate: The last check before the request is sent.

        Raises:
            Void: A STOP was read after the goal was typed; nothing was sent.
        """
        known = (kind.action, kind.type) in self._actions
        action = self.open(kind)
        if action.type is None:
            return Outcome(Code.REFUSED, mismatch.not_installed(kind.action, kind.type))
        goal = Goal(kind, values, Phase.SENT, 0.0, 0.0, length=length)
        tracked = TrackedGoal(goal, uuid.uuid4().bytes, action, self._clock, self._goal_changed)
        tracked.gate = gate
        self._coming.append(tracked)  # From here on a cancel finds it.
        try:
            if not known:
                await self._wait_for_server(tracked)
            request = self._request(tracked)
            gate()
        finally:
            self._coming.remove(tracked)
        if isinstance(request, Outcome):
            return request
        return await self._send(tracked, request)

    def _request(self, tracked: TrackedGoal) -> Any:
        """Return the request that sends a goal, or an Outcome that says why it is not sent."""
        action, kind = tracked.action, tracked.goal.kind
        if tracked.is_cancelled:
            return Outcome(Code.CANCELLED, NEVER_LEFT)
        if self._ours is not None and self._ours.goal.phase in (Phase.UNKNOWN, Phase.LOST):
            doubt = f"nothing is heard of the goal to {self._ours.goal.name}"
            return Outcome(Code.REFUSED, f"{doubt}: cancel it, or wait until the robot is heard")
        if self._ours is not None:
            return Outcome(Code.REFUSED, "a goal is already running: cancel it first")
        if not action.is_served:
            return Outcome(Code.NOT_OFFERED, not_offered(kind.action))
        if self.are_over:
            return Outcome(Code.CANCELLED, "not sent: the console ends")
        try:
            return messages.goal_request(action.type, kind, tracked.goal.fields)
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))

    async def _send(self, tracked: TrackedGoal, request: Any) -> Outcome:
        """Send the request of a goal; return as `send` does."""
        now, time = self._clock.monotonic(), self._clock.now()
        tracked.goal = tracked.goal._replace(sent=now, time=time, number=next(self._numbers))
        tracked.since = now
        self._refusals.clear()
        self._running[tracked.id] = tracked
        self._on_change(True)
        answered = self._future()

        def on_answer(done: Any) -> None:
            handle = done.result()
            if handle is not None and tracked.goal.is_running:
                self._answered(tracked, handle)
            elif (
                handle is not None
                and handle.accepted
                and (tracked.is_unwanted or not tracked.is_taken)
            ):
                self._note("WARN", f"{tracked.goal.name} was accepted after its end: cancelling it")
                handle.cancel_goal_async()
            answered.set_result(True)
            self._wake()

        try:
            goal_id = UUID(uuid=list(tracked.id))
            future = tracked.action.client.send_goal_async(request, goal_uuid=goal_id)
        except Exception as error:  # The request was not sent.
            reason = f"not sent: {in_one_line(error)}"
            tracked.end(Phase.REFUSED, reason)
            return Outcome(Code.REFUSED, reason)
        future.add_done_callback(on_answer)
        self._services.watch(answered)
        if await answered is None:
            tracked.assume()
            tracked.update(phase=Phase.UNKNOWN)
            return Outcome(
                Code.TIMEOUT, f"no answer in {services.DEADLINE:g} s: the goal may be running"
            )
        if tracked.goal.phase == Phase.SENT:
            reason = await self._reason()
            tracked.end(Phase.REFUSED, reason)
            return Outcome(Code.REFUSED, reason)
        self._cancel_if_unwanted(tracked)  # A STOP may have come since it was accepted.
        if tracked.is_void:
            return Outcome(Code.CANCELLED, "accepted after a STOP: cancelling it")
        return Outcome(
            Code.ACCEPTED, "accepted, and cancelled" if tracked.is_cancelled else "accepted"
        )

    def _answered(self, tracked: TrackedGoal, handle: Any) -> None:
        """Handle the answer of a server that accepts or refuses a goal, in time or later."""
        if handle.accepted:
            tracked.on_accepted(handle)
            if tracked.is_void:
                self._note("WARN", f"{tracked.goal.name} was accepted after a STOP: cancelling it")
            self._cancel_if_unwanted(tracked)
        elif tracked.goal.phase == Phase.UNKNOWN:
            tracked.end(Phase.REFUSED, "refused (the answer came late)")

    async def _wait_for_server(self, tracked: TrackedGoal) -> None:
        """Wait until a client that was just made has found a server, for DEADLINE at most."""
        end = self._clock.monotonic() + services.DEADLINE
        while (
            not (tracked.action.is_served or tracked.is_unwanted) and self._clock.monotonic() < end
        ):
            await self._services.pause(_FIND_PERIOD)

    async def cancel(self, *, another: bool) -> Outcome:
        """Request the cancel of a goal; return the answer. Its end is reported by the robot later.

        A goal of this console is also cancelled before it was sent, and before it was accepted.

        Args:
            another: True to cancel another client's goal, False for one of this console.
        """
        if self._coming and not another:
            for coming in self._coming:
                coming.is_cancelled = True
            return Outcome(Code.ACCEPTED, NEVER_LEFT)
        tracked = self._shown if another else self._ours
        if tracked is None or tracked.goal.mine == another:
            return Outcome(
                Code.REFUSED, "no goal is running" if tracked is None else "another goal runs now"
            )
        if tracked.goal.phase in (Phase.SENT, Phase.UNKNOWN):  # The server may accept it later.
            tracked.is_cancelled = True
        if tracked.goal.phase == Phase.SENT:
            return await self._cancelled_when_taken(tracked)
        return await self._cancel(tracked)

    async def _cancelled_when_taken(self, tracked: TrackedGoal) -> Outcome:
        """Wait for the answer to the cancel that begins when a goal is accepted."""
        end = self._clock.monotonic() + services.DEADLINE
        while tracked.goal.phase == Phase.SENT and self._clock.monotonic() < end:
            await self._services.pause(_FIND_PERIOD)
        if tracked.goal.phase in (Phase.SENT, Phase.UNKNOWN):
            return Outcome(Code.TIMEOUT, "the goal is not accepted yet: it is cancelled when it is")
        while tracked.cancel_outcome is None and tracked.goal.is_running:
            await self._services.pause(_FIND_PERIOD)
        if tracked.cancel_outcome is not None:
            return tracked.cancel_outcome
        return Outcome(Code.DONE, f"the goal was not driven: {tracked.goal.message}".rstrip(": "))

    def _cancel_if_unwanted(self, tracked: TrackedGoal) -> None:
        """Begin to cancel a goal that was accepted too late; only once, as a second is refused."""

        async def cancel() -> None:
            tracked.cancel_outcome = await self._cancel(tracked)

        if tracked.is_unwanted and tracked.goal.phase == Phase.MOVING and not tracked.cancel_began:
            tracked.cancel_began = True
            self._task(cancel)

    async def _cancel(self, tracked: TrackedGoal) -> Outcome:
        """Request the cancel of a goal that was sent; return the answer."""
        if tracked.handle is None:
            return Outcome(Code.REFUSED, "the goal has ended")
        before = tracked.goal.phase
        tracked.update(phase=Phase.CANCELLING, cancel_asked=self._clock.monotonic())
        future = tracked.handle.cancel_goal_async()
        services.hold_open(future, tracked.action.servers, lambda a: len(a.goals_canceling) > 0)
        answer = await self._in_time(future)
        if answer is not None and len(answer.goals_canceling):
            return Outcome(Code.ACCEPTED, "accepted")
        if tracked.goal.phase == Phase.CANCELLING:
            tracked.update(phase=before, cancel_asked=None)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer to the cancel in {services.DEADLINE:g} s")
        if tracked.goal.is_running:  # A restarted server does not know it, which its answer shows.
            tracked.ask_result()
        return Outcome(
            Code.REFUSED, "the robot rejected the cancel: the goal continues or has ended"
        )

    async def cancel_all(self, others: Iterable[str] = (), until: float = 0.0) -> Outcome:
        """Request every known action to cancel all its goals, whoever sent them.

        All requests leave at once: an action that does not answer delays no other.

        Args:
            others: The full names of further actions.
            until: How long to wait for servers that are not found yet, in monotonic seconds.
        """
        asked: dict[str, Any] = {}
        while True:
            for name in (*others, *(action.name for action in self._known if action.is_served)):
                if name not in asked:
                    asked[name] = self._task(self._cancel_every, name)
            is_found = all(action.is_served for action in self._known)
            if is_found or self._clock.monotonic() >= until:
                break
            await self._services.pause(_FIND_PERIOD)
        if not asked:
            return Outcome(Code.NOT_OFFERED, "no action is offered by any node")
        taken, silent = 0, []
        for name, task in asked.items():
            cancelling, is_answered = await task
            taken += cancelling
            if not is_answered:
                silent.append(name)
        if silent:
            waited = f"{services.DEADLINE:g} s"
            return Outcome(
                Code.TIMEOUT, f"no answer to the cancel in {waited}: {', '.join(silent)}"
            )
        if not taken:
            return Outcome(Code.REFUSED, "none was cancelled")
        return Outcome(Code.ACCEPTED, f"cancelling {taken} {'goal' if taken == 1 else 'goals'}")

    @property
    def _known(self) -> list[_Action]:
        """The actions with a type that is installed here."""
        return [action for action in self._actions.values() if action.type is not None]

    async def _cancel_every(self, action: str) -> tuple[int, bool]:
        """Request an action, by its full name, to cancel all its goals.

        Returns:
            How many it cancels, and True if all its servers have answered.
        """
        name = f"{action}/_action/cancel_goal"
        servers = max(self._node.count_services(name), 1)
        answers = await self._services.call_all(
            CancelGoal,
            name,
            CancelGoal.Request(),  # In action_msgs, no id and no time mean all goals.
            servers,
            services.DEADLINE,
        )
        return sum(len(answer.goals_canceling) for answer in answers), len(answers) >= servers

    async def _in_time(self, future: Any) -> Any:
        """Return the answer to a cancel; None after DEADLINE. A later rejection is an event."""
        in_time = self._future()

        def on_answer(done: Any) -> None:
            if in_time.cancelled() and not len(done.result().goals_canceling):
                self._note("WARN", "the robot rejected the cancel (its answer came late)")
            in_time.set_result(True)
            self._wake()

        future.add_done_callback(on_answer)
        self._services.watch(in_time)
        return future.result() if await in_time else None

    def update_lengths(self, length_of: Callable[[GoalKind], float | None]) -> None:
        """Set the lengths of ways that became known only after their goals were sent.

        Args:
            length_of: Returns the length for a kind of goal; None if it is not known.
        """
        for tracked in list(self._running.values()):
            if tracked.goal.length is not None and not tracked.goal.length_is_guessed:
                continue
            length = length_of(tracked.goal.kind)
            if length is not None:
                tracked.update(length=length, length_is_guessed=False)

    def on_refusal_log(self, reason: str) -> None:
        """Record the reason in a log line about a refused goal."""
        self._refusals.append(reason)

    def cancel_older(self, sent: float) -> tuple[str, ...]:
        """Return the names of running goals that began before `sent`, and cancel ours among them.

        Call it repeatedly: each is cancelled again after DEADLINE, until it ends.

        Args:
            sent: Monotonic time in seconds.
        """
        older = [tracked for tracked in self._running.values() if tracked.since < sent]
        now = self._clock.monotonic()
        for tracked in older:
            if tracked.goal.mine and now - tracked.tried_to_cancel > services.DEADLINE:
                tracked.tried_to_cancel = now
                self._task(self._cancel, tracked)
        return tuple(tracked.goal.name for tracked in older)

    def forget_periods(self, old: object, new: object, served: Callable[[GoalKind], bool]) -> None:
        """Measure the periods of feedback again, because a parameter has changed.

        Args:
            old: Its value before.
            new: Its present value.
            served: Returns True if the parameter's node serves that kind of goal.
        """
        for tracked in list(self._running.values()):
            tracked.forget_period(old if served(tracked.goal.kind) else None, new)

    def on_robot_message(self) -> None:
        """Ask about lost goals: a message of the robot was received."""
        for tracked in list(self._running.values()):
            tracked.on_robot_message()

    def node_gone(self, served: Callable[[GoalKind], bool]) -> None:
        """End the goals of a node of this process that was stopped or restarted, or crashed.

        Args:
            served: Returns True if that node served the kind of goal.
        """
        for tracked in list(self._running.values()):
            if served(tracked.goal.kind):
                tracked.node_gone()

    def check(self, now: float, motion: Motion) -> None:
        """Update every goal after a silence; call it about once a second.

        Args:
            now: Monotonic time in seconds.
            motion: The last message about the robot's motion.
        """
        self._pause = self._pause.checked_at(now)
        for tracked in list(self._running.values()):
            tracked.check(now, motion, self._pause.resumed)

    def _on_status(self, action: _Action, message: Any) -> None:
        """Handle the status of all goals of an action; track those that others sent."""
        reported = {bytes(s.goal_info.goal_id.uuid): s for s in message.status_list}
        # Each of several servers reports only its own goals.
        alone = self._node.count_publishers(action.status_topic) == 1
        for goal_id, status in reported.items():
            tracked = self._running.get(goal_id)
            if tracked is not None:
                tracked.on_status(status.status)
            elif status.status in _RUNNING or (alone and self._was_short(action, goal_id, status)):
                self._follow_another(action, goal_id, status)
        if not alone:
            return
        action.reported = set(reported)
        for tracked in list(self._running.values()):
            if tracked.action is action and not tracked.goal.mine and tracked.id not in reported:
                tracked.end_forgotten()

    def _was_short(self, action: _Action, goal_id: bytes, status: Any) -> bool:
        """Return True for a goal that began and ended between two status messages."""
        if status.status not in ENDS or goal_id in self._ended_ids:
            return False
        if action.reported is not None:
            return goal_id not in action.reported
        return _seconds(status) >= action.since  # Otherwise it ended before the console began.

    def _follow_another(self, action: _Action, goal_id: bytes, status: Any) -> None:
        """Track a goal that appears in the status of its action."""
        now = self._clock.monotonic()
        age = self._clock.now() - _seconds(status)
        begun = now - age if 0 <= age <= _LONGEST_AGE else now
        phase = _RUNNING.get(status.status, Phase.MOVING)
        is_new = 0 <= age < _NEW or action.reported is not None
        tracked = self._follow_found(action, goal_id, phase, begun, is_new=is_new)
        tracked.on_status(status.status)
        tracked.ask_result()

    def _follow_found(
        self, action: _Action, goal_id: bytes, phase: Phase, begun: float, *, is_new: bool
    ) -> TrackedGoal:
        """Track a goal that another client sent, or a lost one whose node is found again."""
        now, time = self._clock.monotonic(), self._clock.now()
        asked = now if phase == Phase.CANCELLING else None
        lost = self._lost.pop(goal_id, None)
        fields, mine = ({}, False) if lost is None else (lost.fields, lost.mine)
        goal = Goal(
            *(action.kind, fields, phase, begun, time),
            heard=now,
            started=begun,
            cancel_asked=asked,
            mine=mine,
            number=next(self._numbers),
            is_found=lost is not None or not is_new,
        )
        tracked = self._follow(goal, goal_id, action)
        if not self._watching:
            tracked.assume()
        sent = f"another client sent a goal to {action.kind.action}"
        again = f"{goal.name} was not lost: its node is heard again"
        self._note("GOAL", sent if lost is None else again)
        return tracked

    def _on_feedback(self, action: _Action, message: Any) -> None:
        goal_id = bytes(message.goal_id.uuid)
        tracked = self._running.get(goal_id) or self._found_again(action, goal_id)
        if tracked is not None:
            tracked.on_feedback(message.feedback)
            if tracked.is_cancelled:  # The answer that it was accepted may have been lost.
                self._cancel_if_unwanted(tracked)

    def _found_again(self, action: _Action, goal_id: bytes) -> TrackedGoal | None:
        """Return a lost goal whose feedback comes again, now tracked; None for any other goal.

        Fast DDS does not send the status again to a console that lost sight of the node.
        """
        lost, now = self._lost.get(goal_id), self._clock.monotonic()
        # Feedback from before its node left may be read a little later.
        if lost is None or not action.is_served or now - (lost.ended or now) < NOBODY_SERVES:
            return None
        begun = now if lost.started is None else lost.started
        tracked = self._follow_found(action, goal_id, Phase.MOVING, begun, is_new=False)
        tracked.ask_result()
        return tracked

    async def _reason(self) -> str:
        """Return why a goal was refused: ROS actions have no field for it, so the log has it."""
        end = self._clock.monotonic() + _REASON_WAIT
        while not self._refusals and self._clock.monotonic() < end:
            await self._services.pause(0.02)
        return self._refusals[-1] if self._refusals else "refused, no reason given"

    def _follow(self, goal: Goal, goal_id: bytes, action: _Action) -> TrackedGoal:
        tracked = TrackedGoal(goal, goal_id, action, self._clock, self._goal_changed)
        self._running[goal_id] = tracked
        self._on_change(True)
        return tracked

    def _goal_changed(self, tracked: TrackedGoal, before: Goal) -> None:
        goal = tracked.goal
        if before.is_running and not goal.is_running:
            self._running.pop(tracked.id, None)
            self._ended_ids.append(tracked.id)
            if goal.phase == Phase.GONE:
                self._lost = {**dict([*self._lost.items()][-HISTORY:]), tracked.id: goal}
            self._last = goal
            self.history.appendleft(goal)
            if (
                goal.phase != Phase.REFUSED or before.phase != Phase.SENT
            ):  # Otherwise the verb tells.
                self._on_end(goal, _end_text(goal))
        self._on_change(goal.phase != before.phase)

    def _task(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return self._node.executor.create_task(function, *arguments)  # type: ignore[union-attr]

    def _future(self) -> Future[bool]:
        return Future(executor=self._node.executor)

    def _wake(self) -> None:
        if self._node.executor is not None:
            self._node.executor.wake()


def _end_text(goal: Goal) -> str:
    """Return how a goal ended; the robot's words alone if they name both goal and phase."""
    word, message = goal.word.lower(), goal.message.lower()
    if message and word in message and goal.name.lower() in message:
        return goal.message
    return f"{goal.name} {word}: {goal.message}".rstrip(": ")
