"""The goals of a robot's actions: sent from here, and tracked whoever sent them. ROS thread only.

Their states come from the actions alone: from status, feedback and result.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot import messages, services
from archo_tui.robot.consoles import author, goals_of_others, new_goal_id
from archo_tui.robot.goal_action import GoalAction
from archo_tui.robot.goal_canceller import FIND_PERIOD, GoalCanceller
from archo_tui.robot.goal_finder import GoalFinder
from archo_tui.robot.goal_register import GoalRegister
from archo_tui.robot.listener import Listener
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.period import Pause
from archo_tui.robot.services import Services
from archo_tui.robot.state import Goal, Motion, Phase, not_offered
from archo_tui.robot.stop.gate import NEVER_LEFT, Gate
from archo_tui.robot.tracked_goal import TrackedGoal
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import GoalKind

_REASON_WAIT = 0.3  # Seconds to wait for the log line with the reason, after a refusal.


class Goals:
    """The goals that run, and the last ones that ended.

    Attributes:
        sending_has_ended: True to refuse every further goal: the console ends.
    """

    def __init__(
        self,
        node: Listener,
        clock: Clock,
        pending: Services,
        on_change: Callable[[bool], None],
        note: Callable[[str, str], None],
        on_end: Callable[[Goal, str], None],
        consoles: Callable[[], Collection[str]],
        exempt: Collection[str],
        watching: bool = False,
    ) -> None:
        """Create the table, without goals and actions.

        Args:
            node: The console's node.
            clock: The clock of all times.
            pending: Calls services, and watches deadlines.
            on_change: Called after each change; with True if a goal is new or has another phase.
            note: Called with level and text of an event that no verb reports any more.
            on_end: Called with a goal that has ended, whoever sent it, and a text about its end;
                not for a refusal that came in time.
            consoles: Returns the names of the other consoles.
            exempt: The actions whose goals no STOP cancels, as the robot file names them.
            watching: True for a console that sends nothing.
        """
        self._node, self._clock, self._services = node, clock, pending
        self._note, self._watching = note, watching
        self._consoles, self._exempt = consoles, exempt
        self._console = author(node.get_name())
        self._actions: dict[tuple[str, str], GoalAction] = {}  # By name and type.
        self._coming: list[TrackedGoal] = []  # Of this console, about to be sent.
        self._refusals: deque[str] = deque(maxlen=5)  # Reasons in the log.
        self._register = register = GoalRegister(clock, on_change, on_end)
        self._canceller = canceller = GoalCanceller(node, clock, pending, note)
        self._finder = GoalFinder(node, clock, pending, register, canceller, note, watching)
        self.sending_has_ended = False
        self._pause = Pause()

    @property
    def goal(self) -> Goal | None:
        """The goal to show: ours that runs, else another that runs, else the last that ended.

        None before the first goal.
        """
        return self._register.goal

    @property
    def history(self) -> Iterable[Goal]:
        """The last 20 goals that ended, the newest first."""
        return self._register.history

    @property
    def running(self) -> int:
        """The number of goals that run, whoever sent them."""
        return len(self._register.running)

    def track_action(self, kind: GoalKind) -> GoalAction:
        """Track the goals of an action from the first call on, and return the tracked action.

        The first call subscribes to status and feedback, if the type is installed here; later calls
        with the same action and type return the same object, which keeps the first `kind`.
        """
        key = (kind.action, kind.type)
        if key not in self._actions:
            callbacks = self._finder.on_feedback, self._finder.on_status
            made = GoalAction(self._node, kind, *callbacks, self._watching, self._clock.now())
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
        """Send a goal; return when it was accepted, refused, or not answered within DEADLINE.

        For an action that is not tracked yet, its server is waited for first, for up to DEADLINE.
        If a STOP or a cancel comes after the goal was sent and before it is accepted, the goal is
        cancelled as soon as it is accepted.

        Args:
            kind: The kind of goal.
            values: The typed values by dotted path.
            length: The length of the way, in the unit of the remainder; None if not known.
            gate: The last check before the request is sent.

        Returns:
            ACCEPTED or REFUSED. REFUSED, too, if a goal of this console runs already or the type is
            not installed here; NOT_OFFERED without a server; MISUSE if the values do not fit;
            CANCELLED if the goal was cancelled before it was sent, was accepted after a STOP, or
            the console ends. TIMEOUT: the goal may be running, and is tracked on.

        Raises:
            Void: A STOP was read after the goal was typed; nothing was sent.
        """
        known = (kind.action, kind.type) in self._actions
        action = self.track_action(kind)
        if action.type is None:
            return Outcome(Code.REFUSED, mismatch.not_installed(kind.action, kind.type))
        goal = Goal(kind, values, Phase.SENT, 0.0, 0.0, length=length)
        tracked = self._register.prepare(goal, new_goal_id(self._console), action)
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
        """Return the request that sends a goal, or an Outcome that says why it may not be sent."""
        action, kind = tracked.action, tracked.goal.kind
        if tracked.is_cancelled:
            return Outcome(Code.CANCELLED, NEVER_LEFT)
        ours = self._register.ours
        if ours is not None and ours.goal.phase in (Phase.UNKNOWN, Phase.LOST):
            doubt = f"nothing is heard of the goal to {ours.goal.name}"
            return Outcome(Code.REFUSED, f"{doubt}: cancel it, or wait until the robot is heard")
        if ours is not None:
            return Outcome(Code.REFUSED, "a goal is already running: cancel it first")
        if not action.is_served:
            return Outcome(Code.NOT_OFFERED, not_offered(kind.action))
        if self.sending_has_ended:
            return Outcome(Code.CANCELLED, "not sent: the console ends")
        try:
            return messages.goal_request(action.type, kind, tracked.goal.fields)
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))

    async def _send(self, tracked: TrackedGoal, request: Any) -> Outcome:
        """Send the request of a goal, track the goal, and return the outcome, as `send` does."""
        now, time = self._clock.monotonic(), self._clock.now()
        tracked.goal = tracked.goal._replace(
            sent=now, time=time, number=self._register.next_number()
        )
        tracked.turn = self._services.next_turn()
        self._refusals.clear()
        self._register.add(tracked)
        answered: Future[bool] = Future(executor=self._node.executor)

        def on_answer(done: Any) -> None:
            handle = done.result()
            if handle is not None and tracked.goal.is_running:
                self._answered(tracked, handle)
            elif (
                handle is not None
                and handle.accepted
                and (tracked.is_unwanted or not tracked.is_accepted)
            ):
                self._note("WARN", f"{tracked.goal.name} was accepted after its end: cancelling it")
                handle.cancel_goal_async()
            answered.set_result(True)
            services.wake(self._node)

        try:
            goal_id = UUID(uuid=list(tracked.id))
            future = tracked.action.client.send_goal_async(request, goal_uuid=goal_id)
        except Exception as error:  # The request was not sent.
            reason = f"not sent: {in_one_line(error)}"
            tracked.end(Phase.REFUSED, reason)
            return Outcome(Code.REFUSED, reason)
        future.add_done_callback(on_answer)
        self._services.cancel_at_deadline(answered)
        if await answered is None:
            tracked.assume_accepted()
            tracked.update(phase=Phase.UNKNOWN)
            return Outcome(
                Code.TIMEOUT, f"no answer in {services.DEADLINE:g} s: the goal may be running"
            )
        if tracked.goal.phase == Phase.SENT:
            reason = await self._reason()
            tracked.end(Phase.REFUSED, reason)
            return Outcome(Code.REFUSED, reason)
        self._canceller.cancel_if_unwanted(tracked)  # A STOP may have come since it was accepted.
        if tracked.is_void:
            return Outcome(Code.CANCELLED, "accepted after a STOP: cancelling it")
        return Outcome(
            Code.ACCEPTED, "accepted, and cancelled" if tracked.is_cancelled else "accepted"
        )

    def _answered(self, tracked: TrackedGoal, handle: Any) -> None:
        """Record the answer of a server that accepts or refuses a goal, in time or later.

        A goal that was voided by a STOP or a cancel is cancelled now.
        """
        if handle.accepted:
            tracked.on_accepted(handle)
            if tracked.is_void:
                self._note("WARN", f"{tracked.goal.name} was accepted after a STOP: cancelling it")
            self._canceller.cancel_if_unwanted(tracked)
        elif tracked.goal.phase == Phase.UNKNOWN:
            tracked.end(Phase.REFUSED, "refused (the answer came late)")

    async def _wait_for_server(self, tracked: TrackedGoal) -> None:
        """Wait up to DEADLINE until a new client has found a server, or its goal is unwanted."""
        end = self._clock.monotonic() + services.DEADLINE
        while (
            not (tracked.action.is_served or tracked.is_unwanted) and self._clock.monotonic() < end
        ):
            await self._services.pause(FIND_PERIOD)

    async def cancel(self, *, another: bool) -> Outcome:
        """Request the cancel of a goal, and return the answer; the goal's end comes later.

        A goal that is about to be sent is not sent (ACCEPTED). A goal that is not accepted yet is
        cancelled when it is accepted, for which this waits up to DEADLINE.

        Args:
            another: True to cancel the shown goal of another client, False for the goal of this
                console.

        Returns:
            The outcome, as of `GoalCanceller.cancel` or `cancel_at_acceptance`; REFUSED if no such
            goal runs, or if `another` is True while a goal of this console runs.
        """
        if self._coming and not another:
            for coming in self._coming:
                coming.is_cancelled = True
            return Outcome(Code.ACCEPTED, NEVER_LEFT)
        tracked = self._register.shown if another else self._register.ours
        if tracked is None or tracked.goal.mine == another:
            return Outcome(
                Code.REFUSED, "no goal is running" if tracked is None else "another goal runs now"
            )
        if tracked.goal.phase in (Phase.SENT, Phase.UNKNOWN):  # The server may accept it later.
            tracked.is_cancelled = True
        if tracked.goal.phase == Phase.SENT:
            return await self._canceller.cancel_at_acceptance(tracked)
        return await self._canceller.cancel(tracked)

    async def cancel_all(
        self, others: Iterable[str] = (), until: float = 0.0, *, for_stop: bool = False
    ) -> Outcome:
        """Request every tracked action to cancel all its goals, whoever sent them.

        Args:
            others: The full names of further actions, whose servers are not waited for.
            until: The monotonic time in seconds until which missing servers of tracked actions are
                waited for.
            for_stop: True to leave actions alone that the robot file exempts.

        Returns:
            The outcome, as of `GoalCanceller.cancel_all`.
        """
        left_out = self._exempt if for_stop else ()
        full = {str(self._node.resolve_service_name(name)) for name in left_out}

        def known() -> list[GoalAction]:
            actions = self._actions.values()
            return [a for a in actions if a.type is not None and a.name not in full]

        return await self._canceller.cancel_all(known, {*others} - full, until)

    def update_lengths(self, length_of: Callable[[GoalKind], float | None]) -> None:
        """Set the lengths of ways of running goals that had none, or a guessed one.

        Args:
            length_of: Returns the length for a kind of goal; None if it is not known.
        """
        for tracked in list(self._register.running.values()):
            if tracked.goal.length is not None and not tracked.goal.length_is_guessed:
                continue
            length = length_of(tracked.goal.kind)
            if length is not None:
                tracked.update(length=length, length_is_guessed=False)

    def on_refusal_log(self, reason: str) -> None:
        """Record a line of the robot's log as the reason of a refusal that is being waited for.

        Args:
            reason: The reason in the line.
        """
        self._refusals.append(reason)

    def cancel_from_before(self, turn: int, *, mine: bool) -> None:
        """Cancel the running goals from before a STOP, each again after DEADLINE, until they end.

        No phase changes by that. Actions that the robot file exempts are left alone.

        Args:
            turn: The turn of the STOP.
            mine: True for the goals of this console, False for those of other clients.
        """
        now = self._clock.monotonic()
        for tracked in self._from_before(turn):
            is_due = now - tracked.tried_to_cancel > services.DEADLINE
            if tracked.goal.mine is mine and is_due and self._stop_cancels(tracked.action):
                tracked.tried_to_cancel = now
                self._canceller.begin_cancel(tracked)

    def names_from_before(self, turn: int) -> tuple[str, ...]:
        """Return the names of all running goals that are tracked since before a STOP's turn."""
        return tuple(tracked.goal.name for tracked in self._from_before(turn))

    def _from_before(self, turn: int) -> list[TrackedGoal]:
        return [goal for goal in self._register.running.values() if goal.turn < turn]

    def _stop_cancels(self, action: GoalAction) -> bool:
        return action.kind.action not in self._exempt

    async def cancel_others(self) -> Outcome:
        """Cancel every goal of the tracked actions, whoever sent it, but exempt ones.

        The text of the outcome counts the goals of others by their ids.
        """
        ours = {id_ for id_, tracked in self._register.running.items() if tracked.goal.mine}
        for tracked in self._register.running.values():
            tracked.tried_to_cancel = self._clock.monotonic()
        names = [a.name for a in self._actions.values() if a.is_served and self._stop_cancels(a)]
        cancelled, silent = await self._canceller.cancel_every(names)
        others = cancelled - ours
        text = goals_of_others(others, self._consoles())
        if silent:
            text += f"; no answer to the cancel in {services.DEADLINE:g} s: {', '.join(silent)}"
        if not others:
            return Outcome(Code.TIMEOUT if silent else Code.REFUSED, text)
        return Outcome(Code.ACCEPTED, text)

    def forget_periods(self, old: object, new: object, served: Callable[[GoalKind], bool]) -> None:
        """Measure the period of each running goal's feedback again: a parameter has changed.

        Args:
            old: The value of the parameter before.
            new: Its present value.
            served: Returns True if the node with the parameter serves that kind of goal.
        """
        for tracked in list(self._register.running.values()):
            tracked.forget_period(old if served(tracked.goal.kind) else None, new)

    def on_robot_message(self) -> None:
        """Record that the robot is heard: LOST goals that never sent feedback become UNKNOWN.

        Their servers are asked about them at the next `check`. Goals that sent feedback stay LOST.
        """
        for tracked in list(self._register.running.values()):
            tracked.on_robot_message()

    def end_goals_of_node(self, served: Callable[[GoalKind], bool]) -> None:
        """End the running goals of a hosted node that stopped, restarted or crashed, as GONE.

        Args:
            served: Returns True if that node served the kind of goal.
        """
        for tracked in list(self._register.running.values()):
            if served(tracked.goal.kind):
                tracked.end_as_gone()

    def check(self, now: float, motion: Motion) -> None:
        """Check every running goal as `TrackedGoal.check` does; call this at least each second.

        After a gap of more than 2.5 s between two calls, silence counts from the end of the gap:
        this process may have been suspended.

        Args:
            now: Monotonic time in seconds.
            motion: The last message about the robot's motion.
        """
        self._pause = self._pause.checked_at(now)
        for tracked in list(self._register.running.values()):
            tracked.check(now, motion, self._pause.resumed)

    async def _reason(self) -> str:
        """Return why a goal was refused, from the robot's log, as an action's answer has no reason.

        Waits up to 0.3 s for the log line; without one, the text says that no reason was given.
        """
        end = self._clock.monotonic() + _REASON_WAIT
        while not self._refusals and self._clock.monotonic() < end:
            await self._services.pause(0.02)
        return self._refusals[-1] if self._refusals else "refused, no reason given"
