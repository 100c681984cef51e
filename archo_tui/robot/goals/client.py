"""The goals of a robot's actions: what the machine asks for is sent, what is heard is its event."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.qos import qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from archo_tui.base.errors import in_one_line
from archo_tui.robot.goals import machine
from archo_tui.robot.goals.machine import Event, GoalEffect, TrackedGoal
from archo_tui.robot.messages.period import Pause
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.messages.values import goal_request
from archo_tui.robot.node import DEADLINE, ConsoleNode, require_all_answers
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.runtime import Runtime
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.stop.gate import NEVER_LEFT, Gate
from archo_tui.robot_file import check
from archo_tui.robot_file.model import GoalKind

HISTORY = 20  # Ended goals that are kept.
_ENDED_IDS = 100  # Ids that are kept: more than goals end between two status messages.
# Seconds: a server that sleeps while it executes, as the textbook's does, takes none for so long.
CANCEL_WAIT = 4.0
FIND_PERIOD = 0.05  # Seconds between two looks for a server, or for an answer.
_REASON_WAIT = 0.3  # Seconds to wait for the log line with the reason, after a refusal.

_ENDS = {
    GoalStatus.STATUS_SUCCEEDED: Event.ARRIVED,
    GoalStatus.STATUS_CANCELED: Event.CANCELLED,
    GoalStatus.STATUS_ABORTED: Event.ABORTED,
}
_CANCELING = GoalStatus.STATUS_CANCELING
_RUNNING = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, _CANCELING)


class GoalAction:
    """The client of one action, and the subscriptions to its feedback and status."""

    def __init__(
        self,
        node: ConsoleNode,
        kind: GoalKind,  # Other kinds of the action share this object.
        on_feedback: Callable[[GoalAction, Any], None],
        on_status: Callable[[GoalAction, Any], None],
        watching: bool,
        since: float,  # When it is made, in Unix seconds.
        is_exempt: bool,  # No STOP cancels its goals.
    ) -> None:
        self._node, self.kind, self.since, self.is_exempt = node, kind, since, is_exempt
        self.name = str(node.resolve_service_name(kind.action))
        # The goals of the last status from a single server; None before the first. `Goals` sets it.
        self.reported: set[bytes] | None = None
        self.type = load_class(kind.type)  # None if it is not installed here: nothing is sent.
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
        require_all_answers(future, self._servers, lambda a: len(a.goals_canceling) > 0)
        return future

    def ask_result(self, goal_id: bytes) -> Any:
        """Ask for the result of a goal, which its server sends when the goal has ended."""
        request = self.type.Impl.GetResultService.Request(goal_id=_uuid(goal_id))
        future = self._results.call_async(request)
        known = lambda answer: answer.status != GoalStatus.STATUS_UNKNOWN  # noqa: E731
        require_all_answers(future, self._servers, known)
        return future


def _uuid(goal_id: bytes) -> UUID:
    return UUID(uuid=list(goal_id))


class _Record:
    """A goal's state in the machine, with what it takes to send to its server."""

    def __init__(
        self, state: TrackedGoal, goal_id: bytes, action: GoalAction, gate: Gate | None = None
    ) -> None:
        self.state, self.id, self.action = state, goal_id, action
        self.gate = gate  # Which it passed as it was sent from here; None if others sent it.
        self.question: Any = None  # The future of the last question for its result.
        self.cancel_outcome: Outcome | None = None  # Of its cancel as it was accepted too late.

    @property
    def is_void(self) -> bool:
        """True if a STOP came after it was typed here, and cancels it, wherever it is by then."""
        is_shut = self.gate is not None and self.gate.is_shut
        return is_shut and not self.action.is_exempt


class Goals:
    """The goals that run, and the last ones that ended."""

    def __init__(
        self,
        runtime: Runtime,
        on_change: Callable[[bool], None],  # With True for a new goal or phase.
        on_end: Callable[[Goal, str], None],  # Unless its verb reports the end.
        exempt: Collection[str],  # The actions whose goals no STOP cancels.
        watching: bool = False,
    ) -> None:
        self._node, self._clock = runtime.node, runtime.clock
        self._note = runtime.reporter.note  # Of what no verb reports any more.
        self._on_change, self._on_end = on_change, on_end
        self._watching = watching
        self.exempt = {str(self._node.resolve_service_name(name)) for name in exempt}
        self._actions: dict[tuple[str, str], GoalAction] = {}  # By name and type.
        self._numbers = itertools.count(1)
        self._coming: list[_Record] = []  # Of this console, about to be sent.
        self._running: dict[bytes, _Record] = {}  # In the order in which tracking began.
        self._gone: dict[bytes, _Record] = {}  # The last ones whose node left.
        self._ended_ids: deque[bytes] = deque(maxlen=_ENDED_IDS)
        self._refusals: deque[str] = deque(maxlen=5)  # Reasons in the log.
        self._pause = Pause()
        self.history: deque[Goal] = deque(maxlen=HISTORY)  # The newest first.
        self.sending_has_ended = False  # True to refuse every further goal: the console ends.

    @property
    def goal(self) -> Goal | None:
        """The goal to show: ours that runs, else another that runs, else the last that ended."""
        shown = self._shown
        return next(iter(self.history), None) if shown is None else shown.state.goal

    @property
    def running(self) -> int:
        """The number of goals that run, whoever sent them."""
        return len(self._running)

    @property
    def ours(self) -> TrackedGoal | None:
        """The first running goal that this console sent."""
        return None if self._ours is None else self._ours.state

    @property
    def _ours(self) -> _Record | None:
        return next((record for record in self._running.values() if record.state.goal.mine), None)

    @property
    def _shown(self) -> _Record | None:
        return self._ours or next(reversed(self._running.values()), None)

    def track(self, kind: GoalKind) -> GoalAction:
        """Track the goals of an action from the first call on; return the action."""
        key = (kind.action, kind.type)
        if key not in self._actions:
            made = GoalAction(
                *(self._node, kind, self._on_feedback, self._on_status, self._watching),
                since=self._clock.now(),
                is_exempt=str(self._node.resolve_service_name(kind.action)) in self.exempt,
            )
            self._actions[key] = made
        return self._actions[key]

    def close(self) -> None:
        """Destroy the clients: with one left, rclpy keeps the node on the graph."""
        for action in self._actions.values():
            action.close()

    # States.

    def _add(self, record: _Record, state: TrackedGoal) -> None:
        """Begin to track a goal."""
        goal = state.goal._replace(time=self._clock.now(), id=record.id.hex())
        record.state = state._replace(goal=goal)
        self._running[record.id] = record
        self._on_change(True)
        self._carry_out(record)

    def _become(self, record: _Record, after: TrackedGoal) -> None:
        """Take the next state of a goal, report the change, and send what is to be sent."""
        before, goal = record.state.goal, after.goal
        if goal.phase is not before.phase:
            after = after._replace(goal=goal._replace(time=self._clock.now()))
        record.state = after
        if before.is_running and not goal.is_running:
            self._end(record, before)
        if goal is not before:
            self._on_change(goal.phase is not before.phase)
        self._carry_out(record)

    def _end(self, record: _Record, before: Goal) -> None:
        self._running.pop(record.id, None)
        self._ended_ids.append(record.id)
        goal = record.state.goal
        if goal.phase is Phase.GONE:
            self._gone = {**dict([*self._gone.items()][-HISTORY:]), record.id: record}
        self.history.appendleft(goal)
        text = machine.end_text(before, goal)
        if text:
            self._on_end(goal, text)

    def _carry_out(self, record: _Record) -> None:
        todo, record.state = record.state.todo, record.state._replace(todo=())
        for what in todo:
            if what is GoalEffect.ASK:
                self._ask(record)
            elif what is GoalEffect.CANCEL:
                self._task(self._cancel_late, record)
            elif what is GoalEffect.CANCEL_UNASKED:
                self._task(self._cancel_unasked, record)
            else:
                name = record.state.goal.name
                self._note("WARN", f"{name} was accepted after its end: cancelling it")
                record.action.cancel(record.id)

    def _task(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return self._node.executor.create_task(function, *arguments)  # type: ignore[union-attr]

    def _ask(self, record: _Record) -> None:
        """Ask for the result, in place of an earlier question; the server answers at the end."""
        if record.question is not None:
            record.question.cancel()
        number, now = record.state.questions, self._clock.monotonic
        record.question = record.action.ask_result(record.id)

        def on_answer(done: Any) -> None:
            answer = done.result()
            if answer is not None:
                is_known = answer.status != GoalStatus.STATUS_UNKNOWN
                end = _ENDS.get(answer.status, Event.ABORTED) if is_known else None
                self._become(record, record.state.answered(number, end, answer.result, now()))

        record.question.add_done_callback(on_answer)

    # Sending.

    async def send(
        self, kind: GoalKind, values: Mapping[str, Any], length: float | None, gate: Gate
    ) -> Outcome:
        """Send a goal; return when it was accepted, refused, or not answered within DEADLINE.

        Raises Void if a STOP was read after the goal was typed; then nothing was sent.
        """
        is_known, action = (kind.action, kind.type) in self._actions, self.track(kind)
        if action.type is None:
            return Outcome(Code.REFUSED, check.not_installed(kind.action, kind.type))
        goal = Goal(kind, values, Phase.SENT, 0.0, 0.0, length=length)
        record = _Record(TrackedGoal(goal), os.urandom(16), action, gate)
        self._coming.append(record)  # From here on a cancel finds it.
        try:
            if not is_known:
                await self._wait_while(
                    lambda: not (action.is_served or record.state.is_cancelled or record.is_void)
                )
            ours = None if self.ours is None else self.ours.goal
            refusal = machine.refusal(
                record.state, ours, is_served=action.is_served, has_ended=self.sending_has_ended
            )
            request, misuse = _request(action, kind, values)
            gate()  # Nothing is awaited between here and the leaving of the request.
        finally:
            self._coming.remove(record)
        return refusal or misuse or await self._send(record, request)

    async def _wait_while(self, holds: Callable[[], bool]) -> None:
        end = self._clock.monotonic() + DEADLINE
        while holds() and self._clock.monotonic() < end:
            await self._node.pause(FIND_PERIOD)

    async def _send(self, record: _Record, request: Any) -> Outcome:
        now, turn = self._clock.monotonic, self._node.next_turn()
        self._refusals.clear()
        self._add(record, record.state.leaving(now(), turn, next(self._numbers)))

        def on_answer(_is_late: bool) -> None:
            handle = future.result()
            if handle is not None:
                self._on_answer(record, is_accepted=handle.accepted)

        try:
            future = record.action.send(record.id, request)
        except Exception as error:  # The request was not sent.
            reason = f"not sent: {in_one_line(error)}"
            self._become(record, record.state.fire(Event.REFUSED, now(), reason))
            return Outcome(Code.REFUSED, reason)
        if not await self._node.in_time(future, DEADLINE, on_answer):
            self._become(record, record.state.fire(Event.NO_ANSWER, now()))
            text = f"no answer in {DEADLINE:g} s: the goal may be running"
            return Outcome(Code.TIMEOUT, text)
        if record.state.goal.phase is Phase.SENT:
            reason = await self._reason()
            self._become(record, record.state.fire(Event.REFUSED, now(), reason))
            return Outcome(Code.REFUSED, reason)
        # A STOP may have come since it was accepted.
        self._become(record, record.state.cancelled_if_unwanted(is_void=record.is_void))
        if record.is_void:
            return Outcome(Code.CANCELLED, "accepted after a STOP: cancelling it")
        text = "accepted, and cancelled" if record.state.is_cancelled else "accepted"
        return Outcome(Code.ACCEPTED, text)

    def _on_answer(self, record: _Record, *, is_accepted: bool) -> None:
        """Take the answer to the request of a goal, in time or later."""
        state, now, is_void = record.state, self._clock.monotonic(), record.is_void
        if not is_accepted:
            self._become(record, state.refused_late(now))
            return
        self._become(record, state.accepted(now, is_void=is_void))
        if is_void and state.is_running:
            name = state.goal.name
            self._note("WARN", f"{name} was accepted after a STOP: cancelling it")

    async def _reason(self) -> str:
        """Return why a goal was refused, from the robot's log: an action's answer has no reason."""
        end = self._clock.monotonic() + _REASON_WAIT
        while not self._refusals and self._clock.monotonic() < end:
            await self._node.pause(0.02)
        return self._refusals[-1] if self._refusals else "refused, no reason given"

    def on_refusal_log(self, reason: str) -> None:
        """Keep a line of the robot's log as the reason of a refusal that is being waited for."""
        self._refusals.append(reason)

    # Cancelling.

    async def cancel(self, *, another: bool) -> Outcome:
        """Cancel this console's goal, or the shown one of another client; its end comes later."""
        if self._coming and not another:
            for coming in self._coming:
                coming.state = coming.state.called_off()
            return Outcome(Code.ACCEPTED, NEVER_LEFT)
        record = self._shown if another else self._ours
        if record is None or record.state.goal.mine == another:
            text = "no goal is running" if record is None else "another goal runs now"
            return Outcome(Code.REFUSED, text)
        self._become(record, record.state.called_off())
        if record.state.goal.phase is not Phase.SENT:
            return await self._cancel(record)
        await self._wait_while(lambda: record.state.goal.phase is Phase.SENT)
        if record.state.goal.phase in (Phase.SENT, Phase.UNKNOWN):
            return Outcome(Code.TIMEOUT, "the goal is not accepted yet: it is cancelled when it is")
        while record.cancel_outcome is None and record.state.is_running:
            await self._node.pause(FIND_PERIOD)
        if record.cancel_outcome is not None:
            return record.cancel_outcome
        text = f"the goal was not driven: {record.state.goal.message}".rstrip(": ")
        return Outcome(Code.DONE, text)

    async def _cancel(self, record: _Record) -> Outcome:
        """Request the cancel of a goal, and wait up to CANCEL_WAIT for the answer."""
        after, now = record.state.cancelling(self._clock.monotonic()), self._clock.monotonic
        if after is record.state:
            return Outcome(Code.REFUSED, "the goal has ended")
        self._become(record, after)
        answer = await self._in_time(record.action.cancel(record.id))
        if answer is not None and len(answer.goals_canceling):
            self._become(record, record.state.cancel_accepted())
            return Outcome(Code.ACCEPTED, "accepted")
        is_rejected = answer is not None
        self._become(record, record.state.cancel_failed(now(), is_rejected=is_rejected))
        if not is_rejected:
            return Outcome(Code.TIMEOUT, f"no answer to the cancel in {CANCEL_WAIT:g} s")
        text = "the robot rejected the cancel: the goal continues or has ended"
        return Outcome(Code.REFUSED, text)

    async def _cancel_late(self, record: _Record) -> None:
        record.cancel_outcome = await self._cancel(record)

    async def _cancel_unasked(self, record: _Record) -> None:
        answer = await self._in_time(record.action.cancel(record.id))
        if answer is not None and not len(answer.goals_canceling):
            self._become(record, record.state.ask(self._clock.monotonic()))

    async def _in_time(self, future: Any) -> Any:
        """Return the answer to a cancel; None after CANCEL_WAIT: a later rejection is an event."""

        def on_answer(is_late: bool) -> None:
            if is_late and not len(future.result().goals_canceling):
                self._note("WARN", "the robot rejected the cancel (its answer came late)")

        return future.result() if await self._node.in_time(future, CANCEL_WAIT, on_answer) else None

    def cancel_from_before(self, turn: int, *, mine: bool) -> None:
        """Cancel the goals from before a STOP: those of this console, or those of others."""
        now = self._clock.monotonic()
        for record in list(self._running.values()):
            if record.state.goal.mine is mine and not record.action.is_exempt:
                self._become(record, record.state.behind_stop(turn, now))

    def names_from_before(self, turn: int) -> tuple[str, ...]:
        """Return the names of all running goals that are tracked since before a STOP's turn."""
        return tuple(r.state.goal.name for r in self._running.values() if r.state.turn < turn)

    async def cancel_all(
        self, others: Iterable[str] = (), until: float = 0.0, *, for_stop: bool = False
    ) -> Outcome:
        """Cancel every goal of these and of other actions, and return what came of it."""
        cancelled = await self._cancel_every(others, until, for_stop=for_stop)
        if cancelled is None:
            return Outcome(Code.NOT_OFFERED, "no action is offered by any node")
        ids, silent = cancelled
        if silent:
            return Outcome(Code.TIMEOUT, silent)
        if not ids:
            return Outcome(Code.REFUSED, "none was cancelled")
        return Outcome(Code.ACCEPTED, f"cancelling {len(ids)} goal{'s' * (len(ids) > 1)}")

    async def _cancel_every(
        self, others: Iterable[str] = (), until: float = 0.0, *, for_stop: bool
    ) -> tuple[set[bytes], str] | None:
        """Cancel all goals at once; return their ids, and who is silent; None without an action."""
        exempt = self.exempt if for_stop else set()
        asked: dict[str, Any] = {}
        while True:
            known = [a for a in self._actions.values() if a.type and a.name not in exempt]
            served = [action.name for action in known if action.is_served]
            for name in {*others, *served} - exempt - asked.keys():
                asked[name] = self._task(self._cancel_goals_of, name)
            if len(served) == len(known) or self._clock.monotonic() >= until:
                break
            await self._node.pause(FIND_PERIOD)
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
        answers = await self._node.call_all(CancelGoal, name, request, servers, DEADLINE)
        ids = {bytes(g.goal_id.uuid) for answer in answers for g in answer.goals_canceling}
        return ids, len(answers) >= servers

    async def cancel_others(self) -> Outcome:
        """Cancel every goal of the tracked actions for a STOP; the text counts those of others."""
        ours, now = set[bytes](), self._clock.monotonic()
        for record in self._running.values():
            ours |= {record.id} if record.state.goal.mine else set()
            record.state = record.state.cancelled_with_all(now)
        ids, silent = await self._cancel_every(for_stop=True) or (set(), "")
        others = ids - ours
        count = "1 goal of another client" if len(others) == 1 else ""
        count = count or f"{len(others)} goals of other clients"
        found = f"cancelling {count}" if others else "no goal of another client was cancelled"
        text = "; ".join(filter(None, (found, silent)))
        if not others:
            return Outcome(Code.TIMEOUT if silent else Code.REFUSED, text)
        return Outcome(Code.ACCEPTED, text)

    # What is heard.

    def _on_status(self, action: GoalAction, message: Any) -> None:
        """Update the goals of an action by a status message, and track those that others sent."""
        reported = {bytes(s.goal_info.goal_id.uuid): s for s in message.status_list}
        is_alone, now = action.is_alone, self._clock.monotonic()
        for goal_id, status in reported.items():
            record, end = self._running.get(goal_id), _ENDS.get(status.status)
            is_canceling, stamp = status.status == _CANCELING, status.goal_info.stamp
            age = self._clock.now() - (stamp.sec + stamp.nanosec / 1e9)
            if record is None and (
                status.status in _RUNNING
                or (end is not None and is_alone and self._is_missed(action, goal_id, age))
            ):
                phase = Phase.CANCELLING if is_canceling else Phase.MOVING
                record = self._track(action, goal_id, phase, age)
            if record is not None:
                self._become(record, record.state.reported(end, now, is_canceling=is_canceling))
        if not is_alone:
            return
        action.reported = set(reported)
        for record in list(self._running.values()):
            is_others = record.action is action and not record.state.goal.mine
            if is_others and record.id not in reported:
                self._become(record, record.state.forgotten(now))

    def _is_missed(self, action: GoalAction, goal_id: bytes, age: float) -> bool:
        was_reported = None if action.reported is None else goal_id in action.reported
        tracked_for = self._clock.now() - action.since
        is_missed = machine.is_missed(age, tracked_for, was_reported)
        return is_missed and goal_id not in self._ended_ids

    def _track(self, action: GoalAction, goal_id: bytes, phase: Phase, age: float) -> _Record:
        """Track a goal that another client sent, or that was GONE, and report it as an event."""
        now, turn = self._clock.monotonic(), self._node.next_turn()
        state = machine.found(
            *(action.kind, phase, age, now, turn, next(self._numbers)),
            is_first=action.reported is None,
        )
        record, gone = _Record(state, goal_id, action), self._gone.pop(goal_id, None)
        text = f"another client sent a goal to {action.kind.action}"
        if gone is not None:
            record.gate = gone.gate
            state = gone.state.found_again(state, is_void=record.is_void)
            text = f"{state.goal.name} was not lost: its node is heard again"
        self._add(record, state)
        self._note("GOAL", text)
        return record

    def _on_feedback(self, action: GoalAction, message: Any) -> None:
        goal_id, now = bytes(message.goal_id.uuid), self._clock.monotonic()
        record, gone = self._running.get(goal_id), self._gone.get(goal_id)
        # Fast DDS does not send the status again to a console that lost sight of the node.
        if record is None and gone and gone.state.is_back(now, is_served=action.is_served):
            age = now - (gone.state.goal.started or now)
            record = self._track(action, goal_id, Phase.MOVING, age)
        if record is not None:
            is_void = record.is_void
            self._become(record, record.state.fed(message.feedback, now, is_void=is_void))

    def on_robot_message(self) -> None:
        """Record that the robot is heard: LOST goals that never sent feedback are asked about."""
        for record in list(self._running.values()):
            self._become(record, record.state.robot_heard(self._clock.monotonic()))

    def end_goals_of_node(self, served: Callable[[GoalKind], bool]) -> None:
        """End the running goals of a hosted node that stopped, restarted or crashed, as GONE."""
        for record in list(self._running.values()):
            if served(record.state.goal.kind):
                self._become(record, record.state.node_left(self._clock.monotonic()))

    def forget_periods(self, old: object, new: object, served: Callable[[GoalKind], bool]) -> None:
        """Measure the periods of feedback again: a node that serves some goals changed."""
        for record in self._running.values():
            is_its = served(record.state.goal.kind)
            record.state = record.state.period_changed(old if is_its else None, new)

    def check(
        self, now: float, motion: Motion, length_of: Callable[[GoalKind], float | None]
    ) -> None:
        """Let the time pass for every running goal; call this several times a second."""
        self._pause = self._pause.checked_at(now)
        for record in list(self._running.values()):
            state, is_served = record.state, record.action.is_served
            after = state.with_length(length_of(state.goal.kind))
            after = after.tick(now, motion, self._pause.resumed, is_served=is_served)
            self._become(record, after)


def _request(
    action: GoalAction, kind: GoalKind, values: Mapping[str, Any]
) -> tuple[Any, Outcome | None]:
    """Return the request that sends a goal, or why the values do not fit."""
    try:
        return goal_request(action.type, kind, values), None
    except ValueError as error:
        return None, Outcome(Code.MISUSE, str(error))
