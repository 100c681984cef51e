"""The verbs that call a service: a command of the robot file, or any other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.clock import Clock
from archo_tui.robot import ros2_command
from archo_tui.robot.events import Reporter
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.messages.values import filled
from archo_tui.robot.outcome import CALL_WAIT, Code, Outcome
from archo_tui.robot.requester import current_requester
from archo_tui.robot.service_caller import ServiceCaller
from archo_tui.robot.state import Event
from archo_tui.robot.stop.gate import Gate
from archo_tui.robot.verb_runner import VerbRunner
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import CommandService


class ServiceVerbs:
    """The verbs that call a service: a command of the robot file, or any service.

    Called on the event loop.
    """

    def __init__(
        self,
        clock: Clock,
        runner: VerbRunner,
        caller: ServiceCaller,
        checks: InterfaceChecks,
        reporter: Reporter,
    ) -> None:
        self._clock, self._runner, self._caller = clock, runner, caller
        self._checks, self._reporter = checks, reporter

    async def command(self, command: CommandService, on: bool = True) -> Outcome:
        """Call the service of a command in the robot file, and report it.

        The outcome is that of `ServiceCaller.call_named`. An answer that comes too late is reported
        as an event of its own.
        """
        title = command.title.lower() if on else command.off or f"{command.title.lower()} off"
        verb = command.id if on else command.off_word
        name, fields = command.service, dict.fromkeys(command.toggle, on)
        ros2 = self._checks.call_command(name, fields)
        late = self._runner.late_report(title, verb)
        return await self._runner.run(
            verb, {}, title, ros2, lambda gate: self._caller.call_named(name, fields, gate, late)
        )

    async def call(
        self,
        service: str,
        type_name: str,
        values: Mapping[str, Any],
        wait: float = CALL_WAIT,
    ) -> Outcome:
        """Call any service and report it; the outcome holds the answer.

        Without an answer after SLOW_CALL, an event tells that the call is still running.
        """
        srv_type = load_class(type_name)
        if srv_type is None:
            return Outcome(Code.REFUSED, mismatch.not_installed(service, type_name))
        try:
            request = filled(srv_type.Request(), values)
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))

        requester = current_requester()

        def on_slow() -> None:
            text = f"{title}: running, no answer yet (waited for up to {wait:g} s)"
            self._reporter.add(Event(self._clock.now(), requester.level, requester.source, text))

        async def work(gate: Gate) -> Outcome:
            return await self._caller.call_any(
                srv_type, service, request, gate, wait, on_slow, late
            )

        arguments = {"service": service, "values": values}
        command = ros2_command.service_call(service, type_name, request)
        title = f"call {service.lstrip('/')}"
        late = self._runner.late_report(title, "call", arguments)
        return await self._runner.run("call", arguments, title, command, work, wait)
