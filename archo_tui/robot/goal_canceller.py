"""Requests to cancel goals, and their answers. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.clock import Clock
from archo_tui.robot import services
from archo_tui.robot.goal_action import GoalAction
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.services import Services
from archo_tui.robot.state import Phase
from archo_tui.robot.tracked_goal import TrackedGoal

FIND_PERIOD = 0.05  # Seconds between two looks for a server, or for an answer.


class GoalCanceller:
    """The sender of requests to cancel goals."""

    def __init__(
        self, node: Node, clock: Clock, pending: Services, note: Callable[[str, str], None]
    ) -> None:
        """Create the canceller.

        Args:
            node: The console's node.
            clock: The clock of all times.
            pending: Calls services, and watches deadlines.
            note: Called with level and text of an event: a rejection that came after its deadline.
        """
        self._node, self._clock, self._services, self._note = node, clock, pending, note

    async def cancel(self, tracked: TrackedGoal, *, is_shown: bool = True) -> Outcome:
        """Request the cancel of a goal, and wait up to DEADLINE for the answer.

        The goal is CANCELLING from the request on. If the server rejects the cancel or does not
        answer in time, the goal's former phase returns; after a rejection its result is requested,
        as the server may not know the goal. A rejection that comes later becomes an event. With
        `is_shown` False the phase stays as it is.

        Returns:
            ACCEPTED, REFUSED or TIMEOUT; REFUSED at once if the goal has no handle: it has ended,
            or is not accepted.
        """
        if tracked.handle is None:
            return Outcome(Code.REFUSED, "the goal has ended")
        before = tracked.goal.phase
        if is_shown:
            tracked.update(phase=Phase.CANCELLING, cancel_asked=self._clock.monotonic())
        future = tracked.handle.cancel_goal_async()
        services.require_all_answers(
            future, tracked.action.servers, lambda a: len(a.goals_canceling) > 0
        )
        answer = await self._in_time(future)
        if answer is not None and len(answer.goals_canceling):
            return Outcome(Code.ACCEPTED, "accepted")
        if is_shown and tracked.goal.phase == Phase.CANCELLING:
            tracked.update(phase=before, cancel_asked=None)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer to the cancel in {services.DEADLINE:g} s")
        if (
            tracked.goal.is_running
        ):  # Its answer shows if a restarted server does not know the goal.
            tracked.ask_result()
        return Outcome(
            Code.REFUSED, "the robot rejected the cancel: the goal continues or has ended"
        )

    def begin_cancel(self, tracked: TrackedGoal) -> None:
        """Request the cancel of a goal that nobody asked for: no phase and no outcome tells it."""
        self._task(partial(self.cancel, tracked, is_shown=False))

    async def cancel_at_acceptance(self, tracked: TrackedGoal) -> Outcome:
        """Wait until a sent goal is accepted and cancelled, and return the outcome of that cancel.

        The cancel itself is not sent from here: `cancel_if_unwanted` sends it.

        Returns:
            The outcome of the cancel; TIMEOUT if the goal is not accepted within DEADLINE; DONE if
            the goal ended without that outcome, as when it was refused.
        """
        end = self._clock.monotonic() + services.DEADLINE
        while tracked.goal.phase == Phase.SENT and self._clock.monotonic() < end:
            await self._services.pause(FIND_PERIOD)
        if tracked.goal.phase in (Phase.SENT, Phase.UNKNOWN):
            return Outcome(Code.TIMEOUT, "the goal is not accepted yet: it is cancelled when it is")
        while tracked.cancel_outcome is None and tracked.goal.is_running:
            await self._services.pause(FIND_PERIOD)
        if tracked.cancel_outcome is not None:
            return tracked.cancel_outcome
        return Outcome(Code.DONE, f"the goal was not driven: {tracked.goal.message}".rstrip(": "))

    def cancel_if_unwanted(self, tracked: TrackedGoal) -> None:
        """Begin to cancel a goal that `is_unwanted`, if it is MOVING and this was not done before.

        Nothing is done for any other goal. The outcome is stored later, as its `cancel_outcome`.
        """

        async def cancel() -> None:
            tracked.cancel_outcome = await self.cancel(tracked)

        if tracked.is_unwanted and tracked.goal.phase == Phase.MOVING and not tracked.cancel_began:
            tracked.cancel_began = True
            self._task(cancel)

    async def cancel_all(
        self, actions: Callable[[], Collection[GoalAction]], others: Iterable[str], until: float
    ) -> Outcome:
        """Request actions to cancel all their goals, whoever sent them, and wait for the answers.

        All requests leave at once: an action that does not answer delays no other.

        Args:
            actions: Returns the actions that the console knows; their servers are waited for.
            others: The full names of further actions, which are asked without waiting for a server.
            until: The monotonic time in seconds until which missing servers are waited for.

        Returns:
            TIMEOUT with the names of the actions that did not answer in DEADLINE, whatever the
            others answered; else ACCEPTED with the number of goals, or REFUSED if no goal was
            cancelled. NOT_OFFERED if no known action has a server and there are no `others`.
        """
        asked: dict[str, Any] = {}
        while True:
            for name in (*others, *(action.name for action in actions() if action.is_served)):
                if name not in asked:
                    asked[name] = self._task(self._cancel_goals_of, name)
            is_found = all(action.is_served for action in actions())
            if is_found or self._clock.monotonic() >= until:
                break
            await self._services.pause(FIND_PERIOD)
        if not asked:
            return Outcome(Code.NOT_OFFERED, "no action is offered by any node")
        taken, silent = await self._gather(asked)
        if silent:
            waited = f"{services.DEADLINE:g} s"
            return Outcome(
                Code.TIMEOUT, f"no answer to the cancel in {waited}: {', '.join(silent)}"
            )
        if not taken:
            return Outcome(Code.REFUSED, "none was cancelled")
        return Outcome(
            Code.ACCEPTED, f"cancelling {len(taken)} {'goal' if len(taken) == 1 else 'goals'}"
        )

    async def cancel_every(self, actions: Iterable[str]) -> tuple[set[bytes], list[str]]:
        """Request actions, by full name, to cancel all their goals, whoever sent them.

        Returns:
            The ids of the goals that are cancelled, and the actions that did not all answer.
        """
        return await self._gather(
            {name: self._task(self._cancel_goals_of, name) for name in actions}
        )

    @staticmethod
    async def _gather(asked: Mapping[str, Any]) -> tuple[set[bytes], list[str]]:
        ids: set[bytes] = set()
        silent = []
        for name, task in asked.items():
            cancelling, is_answered = await task
            ids |= cancelling
            if not is_answered:
                silent.append(name)
        return ids, silent

    async def _cancel_goals_of(self, action: str) -> tuple[set[bytes], bool]:
        """Request an action to cancel all its goals, and wait up to DEADLINE for its servers.

        Args:
            action: The full name of the action.

        Returns:
            The ids of the goals that it cancels, and True if all its servers have answered.
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
        ids = {bytes(g.goal_id.uuid) for answer in answers for g in answer.goals_canceling}
        return ids, len(answers) >= servers

    async def _in_time(self, future: Any) -> Any:
        """Return the answer to a cancel; None after DEADLINE.

        A rejection that comes later is reported as an event.

        Args:
            future: The future of the answer.
        """
        in_time: Future[bool] = Future(executor=self._node.executor)

        def on_answer(done: Any) -> None:
            if in_time.cancelled() and not len(done.result().goals_canceling):
                self._note("WARN", "the robot rejected the cancel (its answer came late)")
            in_time.set_result(True)
            services.wake(self._node)

        future.add_done_callback(on_answer)
        self._services.cancel_at_deadline(in_time)
        return future.result() if await in_time else None

    def _task(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Start a coroutine function as a task of the node's executor, and return the task."""
        return self._node.executor.create_task(function, *arguments)  # type: ignore[union-attr]
