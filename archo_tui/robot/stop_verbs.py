"""The verbs about STOP: send it, release it, give it up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.clock import Clock
from archo_tui.robot.calls import Services
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.service_caller import ServiceCaller
from archo_tui.robot.state import Latch
from archo_tui.robot.stop.gate import Gate, Stops
from archo_tui.robot.stop_sender import FIRST_FOUND, StopSender
from archo_tui.robot.verb_runner import VerbRunner
from archo_tui.robot_file.model import NO_STOP, RobotFile

# The outcome of a release for which there is no server, and no need.
HELD_BY_NOBODY = "every node that held the STOP has ended here; nothing was sent"
REACHED_NOBODY = "no node has got the STOP, which is given up; nothing was sent"


class StopVerbs:
    """The verbs about STOP. All but `early_stop_request` are called on the event loop."""

    def __init__(
        self,
        file: RobotFile,
        clock: Clock,
        runner: VerbRunner,
        caller: ServiceCaller,
        pending: Services,
        graph: Graph,
        checks: InterfaceChecks,
        goals: Goals,
        stops: Stops,
        stop: StopSender,
    ) -> None:
        self._file, self._runner, self._caller, self._services = file, runner, caller, pending
        self._graph, self._checks, self._goals = graph, checks, goals
        self._stops, self._stop_sender = stops, stop
        self._begun = clock.monotonic()

    async def emergency_stop(self) -> Outcome:
        """Send STOP, wait for the answers, report the outcome, and return it.

        For a robot without STOP, every goal of every action is cancelled instead. That is no STOP,
        so the code of its outcome is NOT_OFFERED.
        """
        stop = self._file.stop
        self._stops.superseded = False
        try:
            if stop is None:
                return await self._cancel_instead_of_stop()
            command = self._checks.call_command(stop.service, stop.request)
            return await self._runner.run(
                "stop", {}, "STOP", command, lambda _: self._stop_sender.send()
            )
        finally:
            self._stops.answered = self._stops.count

    async def _cancel_instead_of_stop(self) -> Outcome:
        """Cancel every goal of every action, for a robot without STOP, and report it."""

        async def cancel(_: Gate) -> Outcome:
            outcome = await self._goals.cancel_all(
                self._graph.actions, self._begun + FIRST_FOUND, for_stop=True
            )
            reason = f"{self._file.name} {NO_STOP}"
            return Outcome(Code.NOT_OFFERED, f"{reason} (this is not a STOP: {outcome.text})")

        return await self._runner.run(
            "stop", {}, "cancel every goal", self._checks.cancel_commands(), cancel
        )

    async def release_emergency_stop(self) -> Outcome:
        """Release the STOP, and report it: the robot may move, but continues no goal by itself.

        Only an answer that says yes, in time or later, ends the STOP here, and only if no STOP was
        sent behind the release.
        """
        stop = self._file.stop
        if stop is None or not stop.release:
            return Outcome(Code.NOT_OFFERED, f"{self._file.name} has no service to release a stop")
        name, request = stop.release, stop.release_request

        async def call(gate: Gate) -> Outcome:
            turn = self._services.next_turn()
            if self._is_held_by_nobody(name):
                gate()
                self._stop_sender.on_release_accepted(turn)
                return Outcome(Code.DONE, HELD_BY_NOBODY)
            if self._stop_sender.stop.has_reached_nobody and name not in self._graph.offered:
                gate()
                self._stop_sender.give_up()
                return Outcome(Code.DONE, REACHED_NOBODY)

            def on_late_answer(outcome: Outcome) -> None:
                if outcome.ok:
                    self._stop_sender.on_release_accepted(turn)
                report_late(outcome)

            outcome = await self._caller.call_named(name, request, gate, on_late_answer)
            if outcome.ok:
                self._stop_sender.on_release_accepted(turn)
            return outcome

        ros2 = self._checks.call_command(name, request)
        report_late = self._runner.late_report("release stop", "release")
        return await self._runner.run("release", {}, "release stop", ros2, call)

    def _is_held_by_nobody(self, release: str) -> bool:
        """Return True if the STOP can only be forgotten: all nodes that held it have ended here.

        That is looked up anew. It is False while a node offers the release.
        """
        self._stop_sender.check_holders()
        return self._stop_sender.stop.is_held_by_nobody and release not in self._graph.offered

    async def give_up_stop(self) -> Outcome:
        """Give up the open STOP, which is not sent again though not confirmed, and report it.

        The outcome is DONE also if no STOP is open; a confirmed STOP still holds. An answer that
        comes later counts.
        """

        async def call(gate: Gate) -> Outcome:
            gate()
            self._stop_sender.give_up()
            return Outcome(Code.DONE, "given up; the robot has not confirmed it")

        return await self._runner.run("give_up_stop", {}, "give up STOP", "", call)

    def early_stop_request(self) -> tuple[str, Mapping[str, Any]]:
        """Return the call with which a starting node carries out an earlier STOP. Any thread."""
        stop, known = self._file.stop, self._stop_sender.stop
        holds = known.open is not None or known.latch is not Latch.NONE
        if stop is None or (not holds and self._stops.are_answered):
            return "", {}
        return self._checks.full(stop.service), stop.request
