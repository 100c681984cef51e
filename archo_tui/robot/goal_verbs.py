"""The verbs that send and cancel goals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.robot import ros2_command
from archo_tui.robot.calls import Services
from archo_tui.robot.goal_guard import GoalGuard
from archo_tui.robot.goal_watcher import GoalWatcher
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.graph.lifecycle import Lifecycles
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import ACTION, values_text
from archo_tui.robot.stop.gate import NOT_SENT, Gate, Void
from archo_tui.robot.stop_sender import StopSender
from archo_tui.robot.verb_runner import VerbRunner
from archo_tui.robot_file.model import GoalKind, RobotFile


class GoalVerbs:
    """The verbs that send and cancel goals. Called on the event loop."""

    def __init__(
        self,
        file: RobotFile,
        runner: VerbRunner,
        pending: Services,
        graph: Graph,
        checks: InterfaceChecks,
        goals: Goals,
        guard: GoalGuard,
        watcher: GoalWatcher,
        stop: StopSender,
        lifecycles: Lifecycles,
    ) -> None:
        self._file, self._runner, self._services = file, runner, pending
        self._graph, self._checks, self._goals = graph, checks, goals
        self._goal_guard, self._goal_watcher = guard, watcher
        self._stop_sender, self._lifecycles = stop, lifecycles

    async def send(
        self, kind: GoalKind, values: Mapping[str, Any], *, queued: bool = False
    ) -> Outcome:
        """Send a goal; return when the robot has accepted or refused it, or has not answered.

        An accepted goal ends a STOP that left before it. The outcome is reported as an event, in
        the ROS log, and to the other consoles.
        """
        length = self._goal_watcher.way_length(kind)
        title = " ".join(filter(None, (kind.title.lower(), values_text(kind, values))))

        async def go(gate: Gate) -> Outcome:
            turn = self._services.next_turn()
            refusal = self._goal_guard.refusal(kind, gate, queued=queued)
            if refusal is not None:
                return refusal
            try:
                outcome = await self._goals.send(kind, values, length, gate)
            except Void:
                return Outcome(Code.HELD if queued else Code.CANCELLED, NOT_SENT)
            if outcome.ok:
                self._stop_sender.on_goal_accepted(turn)
            return self._with_inactive_server(kind.action, outcome)

        ros2 = self._checks.goal_command(kind, values)
        verb = verb_of(self._file, self._checks, kind, values)
        return await self._runner.run(*verb, title, ros2, go)

    def _with_inactive_server(self, action: str, outcome: Outcome) -> Outcome:
        """Add the managed servers that are not active to the text of a refusal."""
        full = self._checks.full(action)
        nodes = [
            n for r in self._graph.resources if (r.kind, r.name) == (ACTION, full) for n in r.nodes
        ]
        states = {node: self._lifecycles.word(node) for node in nodes}
        idle = [f"{node} is {word}" for node, word in states.items() if word not in ("", "active")]
        if outcome.code is not Code.REFUSED or not idle:
            return outcome
        return outcome._replace(text=f"{outcome.text}: {', '.join(idle)}")

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Request the cancel of the running goal; return when the robot has answered."""
        goal, command = self._goals.goal, ""
        if goal is not None:
            command = ros2_command.cancel(self._checks.full(goal.kind.action))
        return await self._runner.run(
            "cancel", {}, "cancel", command, lambda _: self._goals.cancel(another=another)
        )

    async def cancel_all(self) -> Outcome:
        """Request the cancel of every goal of the actions that are tracked here, whoever sent it.

        The outcome is that of `Goals.cancel_all`.
        """
        return await self._runner.run(
            "cancel",
            {"all": True},
            "cancel every goal",
            self._checks.cancel_commands(),
            lambda _: self._goals.cancel_all(),
        )


def verb_of(
    file: RobotFile, checks: InterfaceChecks, kind: GoalKind, values: Mapping[str, Any]
) -> tuple[str, Mapping[str, Any]]:
    """Return the id of the verb that sends a goal, and its arguments, for the audit record."""
    if kind not in file.goals:
        return "send_goal", {"action": checks.full(kind.action), "values": values}
    return "go" if kind == file.goals[0] else kind.id, values
