"""Sends goals, and follows all that the robot's actions run, whoever sent them. ROS thread only.

The truth about them is the actions' own: status, feedback and result.
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

HISTORY = 20  # ended goals that are kept
_OVER = 100  # ids that are kept: more than the goals that end between two looks at a status
_FIND_PERIOD = 0.05  # s between two looks for the server of an action
_REASON_WAIT = 0.3  # s that the log line with a refusal's reason may come after the refusal
_NEW = 1.0  # s; a goal that is younger has begun just now
_LONGEST_AGE = 86_400.0  # s; a goal that is older has a stamp of another clock

_RUNNING = {
    GoalStatus.STATUS_ACCEPTED: Phase.MOVING,
    GoalStatus.STATUS_EXECUTING: Phase.MOVING,
    GoalStatus.STATUS_CANCELING: Phase.CANCELLING,
}


def _seconds(status: Any) -> float:
    """When the robot took that goal, in s since the epoch of its clock."""
    stamp = status.goal_info.stamp
    return float(stamp.sec + stamp.nanosec / 1e9)


class _Action:
    """The client of one action, and what it tells of its goals."""

    def __init__(
        self,
        node: Listener,
        kind: GoalKind,
        on_feedback: Callable[[_Action, Any], None],
        on_status: Callable[[_Action, Any], None],
        watching: bool,
        since: float,
    ) -> None:
        """Watching, it makes no client but the one that asks for results.

        `since` is the time now, in s since the epoch.
        """
        self._node, self.kind, self.since = node, kind, since
        self.name = str(node.resolve_service_name(kind.action))  # fully qualified
        self.told: set[bytes] | None = None  # the goals in its last status
        self.type = message_classes.load(kind.type)  # None: not installed here, all else works
        if self.type is None:
            return
        topics, impl = f"{kind.action}/_action", self.type.Impl
        self.client: Any = None if watching else ActionClient(node, self.type, kind.action)
        self._results = node.create_client(impl.GetResultService, f"{topics}/get_result")
        # not by the client: it forgets a goal's feedback when the result is asked for anew
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
        """True when a server can be reached."""
        if self.type is None:
            return False
        if self.client is None:
            return bool(self._results.service_is_ready())
        return bool(self.client.server_is_ready())

    def ask_result(self, goal_id: bytes) -> Any:
        """The future of how a goal ends."""
        request = self.type.Impl.GetResultService.Request(goal_id=UUID(uuid=list(goal_id)))
        future = self._results.call_async(request)
        known = lambda answer: answer.status != GoalStatus.STATUS_UNKNOWN  # noqa: E731
        services.hold_open(future, self.servers, known)  # another server knows nothing of it
        return future

    @property
    def servers(self) -> int:
        """How many nodes serve it: one request reaches them all."""
        return int(self._node.count_services(f"{self.kind.action}/_action/cancel_goal"))


class Goals:
    """The goals that run, and those that ended."""

    def __init__(
        self,
        node: Listener,
        clock: Clock,
        pending: Services,
        changed: Callable[[bool], None],
        say: Callable[[str, str], None],
        ended: Callable[[Goal, str], None],
        watching: bool = False,
    ) -> None:
        """`say(level, text)` is called with what happens after the verb it belongs to has ended.

        `ended(goal, text)` with how a goal that was sent has ended; `changed(turned)` with each
        change: True when a goal came or went on to another phase, False when it only goes on.
        """
        self._node, self._clock = node, clock
        self._services = pending
        self._changed = changed
        self._say, self._ended = say, ended
        self._watching = watching
        self._actions: dict[tuple[str, str], _Action] = {}  # by name and type
        self._numbers = itertools.count(1)
        self._coming: list[TrackedGoal] = []  # ours, that are to be sent and have not left yet
        self._running: dict[bytes, TrackedGoal] = {}
        self._over: deque[bytes] = deque(maxlen=_OVER)  # those that ended
        self._lost: dict[bytes, Goal] = {}  # those whose node has gone
        self._last: Goal | None = None  # the one that ended last
        self._refusals: deque[str] = deque(maxlen=5)
        self.history: deque[Goal] = deque(maxlen=HISTORY)
        self.are_over = False  # none is sent any more
        self._pause = Pause()

    @property
    def goal(self) -> Goal | None:
        """The goal that matters: ours that runs, else another client's, else the last one."""
        shown = self._shown
        return self._last if shown is None else shown.goal

    @property
    def running(self) -> int:
        """How many run."""
        return len(self._running)

    @property
    def _shown(self) -> TrackedGoal | None:
        ours = self._ours
        return ours or next(reversed(self._running.values()), None)

    @property
    def _ours(self) -> TrackedGoal | None:
        return next((one for one in self._running.values() if one.goal.mine), None)

    def open(self, kind: GoalKind) -> _Action:
        """The client of an action, from now on."""
        key = (kind.action, kind.type)
        if key not in self._actions:
            said = self._on_feedback, self._on_status
            made = _Action(self._node, kind, *said, self._watching, self._clock.now())
            self._actions[key] = made
        return self._actions[key]

    def close(self) -> None:
        """Let go of the actions: rclpy keeps a node on the graph while it has a client of one."""
        for action in self._actions.values():
            if action.type is not None and action.client is not None:
                action.client.destroy()

    async def send(
        self, kind: GoalKind, values: Mapping[str, Any], length: float | None, gate: Gate
    ) -> Outcome:
        """Send a goal; ends when it was accepted, refused, or nobody answered in time.

        One that is accepted after a STOP that was read since is cancelled at once.
        """
        known = (kind.action, kind.type) in self._actions
        action = self.open(kind)
        if action.type is None:
            return Outcome(Code.REFUSED, mismatch.not_installed(kind.action, kind.type))
        goal = Goal(kind, values, Phase.SENT, 0.0, 0.0, length=length)
        one = TrackedGoal(goal, uuid.uuid4().bytes, action, self._clock, self._goal_changed)
        one.gate = gate
        self._coming.append(one)  # from here on a cancel finds it
        try:
            if not known:
                await self._found(one)
            request = self._request(one)
            gate()
        finally:
            self._coming.remove(one)
        if isinstance(request, Outcome):
            return request
        return await self._send(one, request)

    def _request(self, one: TrackedGoal) -> Any:
        """Build the request of a goal that is to be sent; an Outcome says why it cannot be."""
        action, kind = one.action, one.goal.kind
        if one.is_cancelled:
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
            return messages.goal_request(action.type, kind, one.goal.fields)
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))

    async def _send(self, one: TrackedGoal, request: Any) -> Outcome:
        """Send a goal's request; ends as `send` does."""
        now, time = self._clock.monotonic(), self._clock.now()
        one.goal = one.goal._replace(sent=now, time=time, number=next(self._numbers))
        one.since = now
        self._refusals.clear()
        self._running[one.id] = one
        self._changed(True)
        answered = self._future()

        def on_answer(done: Any) -> None:
            handle = done.result()
            if handle is not None and one.goal.is_running:
                self._answered(one, handle)
            elif handle is not None and handle.accepted and (one.is_unwanted or not one.is_taken):
                self._say("WARN", f"{one.goal.name} was accepted after its end: cancelling it")
                handle.cancel_goal_async()
            answered.set_result(True)
            self._wake()

        try:
            goal_id = UUID(uuid=list(one.id))
            future = one.action.client.send_goal_async(request, goal_uuid=goal_id)
        except Exception as error:  # it never left
            reason = f"not sent: {in_one_line(error)}"
            one.end(Phase.REFUSED, reason)
            return Outcome(Code.REFUSED, reason)
        future.add_done_callback(on_answer)
        self._services.watch(answered)
        if await answered is None:
            one.assume()
            one.update(phase=Phase.UNKNOWN)
            return Outcome(
                Code.TIMEOUT, f"no answer in {services.DEADLINE:g} s: the goal may be running"
            )
        if one.goal.phase == Phase.SENT:
            reason = await self._reason()
            one.end(Phase.REFUSED, reason)
            return Outcome(Code.REFUSED, reason)
        self._cancel_if_unwanted(one)  # since it was accepted
        if one.is_void:
            return Outcome(Code.CANCELLED, "accepted after a STOP: cancelling it")
        return Outcome(Code.ACCEPTED, "accepted, and cancelled" if one.is_cancelled else "accepted")

    def _answered(self, one: TrackedGoal, handle: Any) -> None:
        """The server accepted or refused, in time or later."""
        if handle.accepted:
            one.on_accepted(handle)
            if one.is_void:
                self._say("WARN", f"{one.goal.name} was accepted after a STOP: cancelling it")
            self._cancel_if_unwanted(one)
        elif one.goal.phase == Phase.UNKNOWN:
            one.end(Phase.REFUSED, "refused (the answer came late)")

    async def _found(self, one: TrackedGoal) -> None:
        """Wait for the server of a client that was made just now."""
        end = self._clock.monotonic() + services.DEADLINE
        while not (one.action.is_served or one.is_unwanted) and self._clock.monotonic() < end:
            await self._services.pause(_FIND_PERIOD)

    async def cancel(self, *, another: bool) -> Outcome:
        """Ask to cancel our goal, or another client's; how it ends is the robot's to say.

        Ours is cancelled also before it has left, and before its server has taken it.
        """
        if self._coming and not another:
            for coming in self._coming:
                coming.is_cancelled = True
            return Outcome(Code.ACCEPTED, NEVER_LEFT)
        one = self._shown if another else self._ours
        if one is None or one.goal.mine == another:
            return Outcome(
                Code.REFUSED, "no goal is running" if one is None else "another goal runs now"
            )
        if one.goal.phase in (Phase.SENT, Phase.UNKNOWN):  # its server may take it later
            one.is_cancelled = True
        if one.goal.phase == Phase.SENT:
            return await self._cancelled_when_taken(one)
        return await self._cancel(one)

    async def _cancelled_when_taken(self, one: TrackedGoal) -> Outcome:
        """Wait for the answer to the cancel that begins when a goal is accepted."""
        end = self._clock.monotonic() + services.DEADLINE
        while one.goal.phase == Phase.SENT and self._clock.monotonic() < end:
            await self._services.pause(_FIND_PERIOD)
        if one.goal.phase in (Phase.SENT, Phase.UNKNOWN):
            return Outcome(Code.TIMEOUT, "the goal is not accepted yet: it is cancelled when it is")
        while one.cancel_outcome is None and one.goal.is_running:
            await self._services.pause(_FIND_PERIOD)
        if one.cancel_outcome is not None:
            return one.cancel_outcome
        return Outcome(Code.DONE, f"the goal was not driven: {one.goal.message}".rstrip(": "))

    def _cancel_if_unwanted(self, one: TrackedGoal) -> None:
        """Begin to cancel a goal that was accepted too late, once: a second one is refused."""

        async def cancel() -> None:
            one.cancel_outcome = await self._cancel(one)

        if one.is_unwanted and one.goal.phase == Phase.MOVING and not one.cancel_began:
            one.cancel_began = True
            self._task(cancel)

    async def _cancel(self, one: TrackedGoal) -> Outcome:
        if one.handle is None:
            return Outcome(Code.REFUSED, "the goal has ended")
        before = one.goal.phase
        one.update(phase=Phase.CANCELLING, cancel_asked=self._clock.monotonic())
        future = one.handle.cancel_goal_async()
        services.hold_open(future, one.action.servers, lambda a: len(a.goals_canceling) > 0)
        answer = await self._in_time(future)
        if answer is not None and len(answer.goals_canceling):
            return Outcome(Code.ACCEPTED, "accepted")
        if one.goal.phase == Phase.CANCELLING:
            one.update(phase=before, cancel_asked=None)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer to the cancel in {services.DEADLINE:g} s")
        if one.goal.is_running:  # its server may have been restarted, and know nothing of it
            one.ask_result()
        return Outcome(
            Code.REFUSED, "the robot rejected the cancel: the goal continues or has ended"
        )

    async def cancel_all(self, others: Iterable[str] = (), until: float = 0.0) -> Outcome:
        """Ask every action that is known to cancel whatever it runs, whoever sent it.

        All of them at once: one that does not answer keeps no other from its cancel.

        Args:
            others: The full names of further actions that are asked.
            until: Monotonic time in s until which servers that are not found yet are waited for.
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
        """The actions whose type is installed here."""
        return [action for action in self._actions.values() if action.type is not None]

    async def _cancel_every(self, action: str) -> tuple[int, bool]:
        """Ask an action to cancel all its goals.

        Returns:
            How many it cancels, and whether all its servers have answered.
        """
        name = f"{action}/_action/cancel_goal"
        servers = max(self._node.count_services(name), 1)
        answers = await self._services.call_all(
            CancelGoal,
            name,
            CancelGoal.Request(),  # no goal id and no time mean all
            servers,
            services.DEADLINE,
        )
        return sum(len(answer.goals_canceling) for answer in answers), len(answers) >= servers

    async def _in_time(self, future: Any) -> Any:
        """The answer to a cancel, None after the deadline; a rejection that comes later is said."""
        in_time = self._future()

        def on_answer(done: Any) -> None:
            if in_time.cancelled() and not len(done.result().goals_canceling):
                self._say("WARN", "the robot rejected the cancel (its answer came late)")
            in_time.set_result(True)
            self._wake()

        future.add_done_callback(on_answer)
        self._services.watch(in_time)
        return future.result() if await in_time else None

    def way_is(self, length_of: Callable[[GoalKind], float | None]) -> None:
        """The length of a whole way may become known only after its goal was sent."""
        for one in list(self._running.values()):
            if one.goal.length is not None and not one.goal.length_is_guessed:
                continue
            length = length_of(one.goal.kind)
            if length is not None:
                one.update(length=length, length_is_guessed=False)

    def refused(self, reason: str) -> None:
        """Remember a log line that says why a goal is refused."""
        self._refusals.append(reason)

    def cancel_older(self, sent: float) -> tuple[str, ...]:
        """The names of goals that still run and began before then (monotonic s).

        Ours are cancelled, again and again until they end.
        """
        older = [one for one in self._running.values() if one.since < sent]
        now = self._clock.monotonic()
        for one in older:
            if one.goal.mine and now - one.tried_to_cancel > services.DEADLINE:
                one.tried_to_cancel = now
                self._task(self._cancel, one)
        return tuple(one.goal.name for one in older)

    def measure_anew(self, old: object, new: object, served: Callable[[GoalKind], bool]) -> None:
        """Measure the periods of feedback anew, because a parameter has changed.

        Args:
            old: What it was.
            new: What it is.
            served: Returns whether the parameter's node serves that kind of goal.
        """
        for one in list(self._running.values()):
            one.forget_period(old if served(one.goal.kind) else None, new)

    def heard(self) -> None:
        """The robot was heard again."""
        for one in list(self._running.values()):
            one.on_robot_message()

    def node_gone(self, served: Callable[[GoalKind], bool]) -> None:
        """End the goals of a node of this process that was halted or restarted, or crashed."""
        for one in list(self._running.values()):
            if served(one.goal.kind):
                one.node_gone()

    def check(self, now: float, motion: Motion) -> None:
        """Silent goals are lost; the robot is asked about doubtful ones."""
        self._pause = self._pause.look(now)
        for one in list(self._running.values()):
            one.check(now, motion, self._pause.resumed)

    def _on_status(self, action: _Action, message: Any) -> None:
        """The whole status of an action: goals of others are followed from now on."""
        told = {bytes(s.goal_info.goal_id.uuid): s for s in message.status_list}
        # of several servers each tells of its own goals
        alone = self._node.count_publishers(action.status_topic) == 1
        for goal_id, status in told.items():
            one = self._running.get(goal_id)
            if one is not None:
                one.on_status(status.status)
            elif status.status in _RUNNING or (alone and self._was_short(action, goal_id, status)):
                self._follow_another(action, goal_id, status)
        if not alone:
            return
        action.told = set(told)
        for one in list(self._running.values()):
            if one.action is action and not one.goal.mine and one.id not in told:
                one.end_forgotten()

    def _was_short(self, action: _Action, goal_id: bytes, status: Any) -> bool:
        """True for a goal that began and ended between two looks at the status."""
        if status.status not in ENDS or goal_id in self._over:
            return False
        if action.told is not None:
            return goal_id not in action.told
        return _seconds(status) >= action.since  # else it ended before the console came

    def _follow_another(self, action: _Action, goal_id: bytes, status: Any) -> None:
        """Follow a goal that the status of its action tells of."""
        now = self._clock.monotonic()
        age = self._clock.now() - _seconds(status)
        begun = now - age if 0 <= age <= _LONGEST_AGE else now
        phase = _RUNNING.get(status.status, Phase.MOVING)
        is_new = 0 <= age < _NEW or action.told is not None
        one = self._follow_found(action, goal_id, phase, begun, is_new=is_new)
        one.on_status(status.status)
        one.ask_result()

    def _follow_found(
        self, action: _Action, goal_id: bytes, phase: Phase, begun: float, *, is_new: bool
    ) -> TrackedGoal:
        """Follow a goal that another client sent, or one whose node was only out of sight."""
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
        one = self._follow(goal, goal_id, action)
        if not self._watching:
            one.assume()
        sent = f"another client sent a goal to {action.kind.action}"
        again = f"{goal.name} was not lost: its node is heard again"
        self._say("GOAL", sent if lost is None else again)
        return one

    def _on_feedback(self, action: _Action, message: Any) -> None:
        goal_id = bytes(message.goal_id.uuid)
        one = self._running.get(goal_id) or self._found_again(action, goal_id)
        if one is not None:
            one.on_feedback(message.feedback)
            if one.is_cancelled:  # the answer that it was accepted may have been lost
                self._cancel_if_unwanted(one)

    def _found_again(self, action: _Action, goal_id: bytes) -> TrackedGoal | None:
        """Return a goal whose node was only out of sight, when feedback of it comes.

        Fast DDS does not send the status again to a console that lost sight of its node.
        """
        lost, now = self._lost.get(goal_id), self._clock.monotonic()
        # what its node said before it left may be read a little later
        if lost is None or not action.is_served or now - (lost.ended or now) < NOBODY_SERVES:
            return None
        begun = now if lost.started is None else lost.started
        one = self._follow_found(action, goal_id, Phase.MOVING, begun, is_new=False)
        one.ask_result()
        return one

    async def _reason(self) -> str:
        """Why the goal was refused: an action has no field for the reason, the log has it."""
        end = self._clock.monotonic() + _REASON_WAIT
        while not self._refusals and self._clock.monotonic() < end:
            await self._services.pause(0.02)
        return self._refusals[-1] if self._refusals else "refused, no reason given"

    def _follow(self, goal: Goal, goal_id: bytes, action: _Action) -> TrackedGoal:
        one = TrackedGoal(goal, goal_id, action, self._clock, self._goal_changed)
        self._running[goal_id] = one
        self._changed(True)
        return one

    def _goal_changed(self, one: TrackedGoal, before: Goal) -> None:
        goal = one.goal
        if before.is_running and not goal.is_running:
            self._running.pop(one.id, None)
            self._over.append(one.id)
            if goal.phase == Phase.GONE:
                self._lost = {**dict([*self._lost.items()][-HISTORY:]), one.id: goal}
            self._last = goal
            self.history.appendleft(goal)
            if goal.phase != Phase.REFUSED or before.phase != Phase.SENT:  # else the verb says it
                self._ended(goal, _end_of(goal))
        self._changed(goal.phase != before.phase)

    def _task(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return self._node.executor.create_task(function, *arguments)  # type: ignore[union-attr]

    def _future(self) -> Future[bool]:
        return Future(executor=self._node.executor)

    def _wake(self) -> None:
        if self._node.executor is not None:
            self._node.executor.wake()


def _end_of(goal: Goal) -> str:
    """How a goal ended: in the robot's words alone where they name both."""
    word, said = goal.word.lower(), goal.message.lower()
    if said and word in said and goal.name.lower() in said:
        return goal.message
    return f"{goal.name} {word}: {goal.message}".rstrip(": ")
