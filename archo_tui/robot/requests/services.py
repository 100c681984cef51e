"""The requests that call a service: a command of the robot file, or any other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from archo_tui.robot import calls
from archo_tui.robot.clients.requester import current_requester
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.text import one_line
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.messages.values import filled
from archo_tui.robot.outcome import (
    CALL_WAIT,
    SLOW_CALL,
    Answer,
    Code,
    Outcome,
    outcome_of,
    says_more,
)
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.run import late_report, run
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.graph import not_offered
from archo_tui.robot.stop.gate import Gate
from archo_tui.robot_file import check
from archo_tui.robot_file.model import CommandService


async def command(robot: Parts, command: CommandService, on: bool = True) -> Outcome:
    """Call the service of a command in the robot file; `on` is the value for a toggle."""
    title = command.title.lower() if on else command.off or f"{command.title.lower()} off"
    verb = command.id if on else command.off_word
    name, fields = command.service, dict.fromkeys(command.toggle, on)
    late = late_report(robot, title, verb)
    ros2 = robot.checks.call_command(name, fields)
    return await run(
        robot, verb, {}, title, ros2, lambda gate: call_named(robot, name, fields, gate, late)
    )


async def call(
    robot: Parts,
    service: str,
    type_name: str,
    values: Mapping[str, Any],
    wait: float = CALL_WAIT,
) -> Outcome:
    """Call any service by its full name; the outcome holds the answer.

    `values` are by dotted path, and other fields keep their defaults. An event tells that the call
    is still running after SLOW_CALL.
    """
    srv_type = load_class(type_name)
    if srv_type is None:
        return Outcome(Code.REFUSED, check.not_installed(service, type_name))
    try:
        request = filled(srv_type.Request(), values)
    except ValueError as error:
        return Outcome(Code.MISUSE, str(error))
    requester, title = current_requester(), f"call {service.lstrip('/')}"

    async def work(gate: Gate) -> Outcome:
        def on_timer() -> None:
            slow.cancel()  # Once.
            text = f"{title}: running, no answer yet (waited for up to {wait:g} s)"
            source = requester.level, requester.source
            robot.reporter.add(Event(robot.clock.now(), *source, text))

        slow = robot.node.create_timer(SLOW_CALL, on_timer, clock=robot.timer_clock)
        try:
            answer = await robot.services.call(
                *(srv_type, service, request),
                gate=gate,
                wait=wait,
                late=lambda answer: late(_outcome_with_all_fields(answer)),
            )
        finally:
            robot.node.destroy_timer(slow)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {wait:g} s: the robot may still do it")
        return _outcome_with_all_fields(answer)

    arguments = {"service": service, "values": values}
    ros2 = ros2_command.service_call(service, type_name, request)
    late = late_report(robot, title, "call", arguments)
    return await run(robot, "call", arguments, title, ros2, work, wait)


async def call_named(
    robot: Parts,
    name: str,
    fields: Mapping[str, Any],
    gate: Gate,
    late: Callable[[Outcome], None],
) -> Outcome:
    """Call a service of the robot file with the type of its server, if the request fits it.

    `late` gets the outcome of an answer that comes after 2 s. ROS thread only.

    Raises:
        Void: A STOP was read in the meantime.
    """
    if name not in robot.graph.offered:
        return Outcome(Code.NOT_OFFERED, not_offered(robot.checks.full(name)))
    srv_type, reason = robot.checks.fitting_class(name, fields)
    if srv_type is None:
        return Outcome(Code.REFUSED, reason)
    try:
        request = filled(srv_type.Request(), fields)
    except ValueError as error:
        return Outcome(Code.MISUSE, str(error))
    answer = await robot.services.call(
        srv_type, name, request, gate=gate, late=lambda answer: late(_outcome_of(answer))
    )
    if answer is None:
        text = f"no answer in {calls.DEADLINE:g} s: the robot may still do it"
        return Outcome(Code.TIMEOUT, text)
    return _outcome_of(answer)


def _outcome_of(answer: Any) -> Answer:
    """Return what an answer means, with all its fields if they say more than yes or no, and why."""
    outcome = outcome_of(answer)
    more = one_line(answer) if says_more(answer) else ""
    if more and outcome.code is Code.NOT_CONFIRMED:
        more = f"{outcome.text}: {more}"
    return Answer.of(outcome._replace(text=more or outcome.text), answer)


def _outcome_with_all_fields(answer: Any) -> Answer:
    """Return the outcome of an answer: REFUSED only if a field `success` is false."""
    text = one_line(answer) or outcome_of(answer).text
    code = Code.DONE if getattr(answer, "success", True) else Code.REFUSED
    return Answer.of(Outcome(code, text), answer)
