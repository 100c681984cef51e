"""The requests that call a service: STOP and its release, a command of the file, or any other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from archo_tui.robot import calls
from archo_tui.robot.clients import current_requester
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
from archo_tui.robot.stop.sender import FIRST_FOUND
from archo_tui.robot_file import check
from archo_tui.robot_file.model import NO_STOP, CommandService


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

        slow = robot.node.create_timer(SLOW_CALL, on_timer, clock=robot.services.steady)
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


# STOP.

# The outcome of a release for which there is no server, and no need.
HELD_BY_NOBODY = "every node that held the STOP has ended here; nothing was sent"
REACHED_NOBODY = "no node has got the STOP, which is given up; nothing was sent"


async def emergency_stop(robot: Parts) -> Outcome:
    """Send STOP; return when every server has answered, or has not in time.

    A robot whose file names no STOP has every goal cancelled instead; the code is NOT_OFFERED then.
    """
    stop, stops = robot.file.stop, robot.stops
    stops.superseded = False
    answered = stops.count  # If this is cancelled, those read meanwhile have to be sent.
    try:
        if stop is None:
            outcome = await _cancel_instead_of_stop(robot)
        else:
            command = robot.checks.call_command(stop.service, stop.request)
            send = robot.stop_sender.send
            outcome = await run(robot, "stop", {}, "STOP", command, lambda _: send())
        answered = stops.count
        return outcome
    finally:
        stops.answered = max(stops.answered, answered)


async def _cancel_instead_of_stop(robot: Parts) -> Outcome:
    async def cancel(_: Gate) -> Outcome:
        outcome = await robot.goals.cancel_all(
            robot.graph.actions, robot.begun + FIRST_FOUND, for_stop=True
        )
        reason = f"{robot.file.name} {NO_STOP}"
        return Outcome(Code.NOT_OFFERED, f"{reason} (this is not a STOP: {outcome.text})")

    commands = robot.checks.cancel_commands()
    return await run(robot, "stop", {}, "cancel every goal", commands, cancel)


async def release_emergency_stop(robot: Parts) -> Outcome:
    """Release the STOP: the robot may move, but continues no goal by itself.

    Only an answer that says yes, in time or later, ends the STOP here, and only if no STOP was sent
    behind the release. What no node holds any more is forgotten here, and nothing is sent.
    """
    stop, sender = robot.file.stop, robot.stop_sender
    if stop is None or not stop.release:
        return Outcome(Code.NOT_OFFERED, f"{robot.file.name} has no service to release a stop")
    name, request = stop.release, stop.release_request

    async def call(gate: Gate) -> Outcome:
        turn = robot.services.next_turn()
        sender.check_holders()
        is_offered = name in robot.graph.offered
        if sender.stop.is_held_by_nobody and not is_offered:
            gate()
            sender.on_release_accepted(turn)
            return Outcome(Code.DONE, HELD_BY_NOBODY)
        if sender.stop.has_reached_nobody and not is_offered:
            gate()
            sender.give_up()
            return Outcome(Code.DONE, REACHED_NOBODY)

        def on_late_answer(outcome: Outcome) -> None:
            if outcome.ok:
                sender.on_release_accepted(turn)
            report_late(outcome)

        outcome = await call_named(robot, name, request, gate, on_late_answer)
        if outcome.ok:
            sender.on_release_accepted(turn)
        return outcome

    command = robot.checks.call_command(name, request)
    report_late = late_report(robot, "release stop", "release")
    return await run(robot, "release", {}, "release stop", command, call)


async def give_up_stop(robot: Parts) -> Outcome:
    """Send the open STOP no more, though it is not confirmed; a confirmed one still holds."""

    async def call(gate: Gate) -> Outcome:
        gate()
        robot.stop_sender.give_up()
        return Outcome(Code.DONE, "given up; the robot has not confirmed it")

    return await run(robot, "give_up_stop", {}, "give up STOP", "", call)


def early_stop_request(robot: Parts) -> tuple[str, Mapping[str, Any]]:
    """Return service and request of the call that a starting node makes before it spins.

    They are "" and {} if no STOP holds, is open or is on its way. Any thread.
    """
    stop, may_start = robot.file.stop, robot.stop_sender.stop.may_start
    if stop is None or (may_start and robot.stops.are_answered):
        return "", {}
    return robot.checks.full(stop.service), stop.request


def on_early_stop(robot: Parts, node: str) -> None:
    """Record that a starting hosted node has carried the STOP out, and now holds it. Any thread."""
    robot.thread.submit(lambda: robot.stop_sender.on_early_stop(node))
