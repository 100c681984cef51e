"""The requests that operate the robot: goals, services, STOP."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping, Sequence
from typing import Any

from archo_tui.base.errors import in_one_line
from archo_tui.base.safe_text import harmless
from archo_tui.robot.clients import current_requester
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.text import one_line
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.messages.values import filled
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.outcome import (
    CALL_WAIT,
    SLOW_CALL,
    WATCHING,
    Answer,
    Code,
    Outcome,
    answer_of,
    outcome_of,
    says_more,
)
from archo_tui.robot.parts import Parts
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import values_text
from archo_tui.robot.state.graph import ACTION, not_offered
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.robot.stop.gate import HELD, HOLDS, NOT_SENT, OPEN_STOP, UNCERTAIN, Gate, Void
from archo_tui.robot.stop.sender import ALL_ANSWERS, FIRST_FOUND
from archo_tui.robot_file import check
from archo_tui.robot_file.model import NO_STOP, CommandService, GoalKind

# Seconds: more than any verb takes that can still end. STOP waits for a server, and then for all.
_DEADLINE = FIRST_FOUND + ALL_ANSWERS + 1.0


async def run(
    robot: Parts,
    verb: str,
    arguments: Mapping[str, Any],
    title: str,
    command: str,
    work: Callable[[Gate], Coroutine[Any, Any, Outcome]],
    wait: float = 0.0,
) -> Outcome:
    """Run `work` on the ROS thread, report how it ended, and return its outcome; it never raises.

    The report is an event, a line of the ROS log and an audit record for other consoles. `work`
    passes the gate just before its request is sent, and may take `wait` seconds more than others.
    """
    if robot.watching:
        return Outcome(Code.WATCHING, WATCHING)
    robot.stops.superseded |= verb != "stop"
    gate, requester = robot.stops.gate(), current_requester()

    def report(outcome: Outcome) -> Outcome:
        answer, outcome = answer_of(outcome), Outcome(outcome.code, harmless(outcome.text))
        record = AuditRecord(verb, arguments, outcome.code)
        robot.reporter.report_done(f"{title}: {outcome.text}", record, command, requester)
        robot.snapshots.send()
        return outcome if answer is None else Answer.of(outcome, answer)

    async def there() -> Outcome:
        try:
            return report(await work(gate))
        except Void:
            return report(Outcome(Code.CANCELLED, NOT_SENT))
        except Exception as error:
            return report(Outcome(Code.REFUSED, in_one_line(error)))

    deadline = _DEADLINE + wait
    try:
        return await robot.thread.run(there, deadline)
    except TimeoutError:
        outcome = Outcome(Code.TIMEOUT, f"no answer in {deadline:g} s from the console's own node")
        event = Event(
            *(robot.clock.now(), requester.level, requester.source, f"{title}: {outcome.text}"),
            command,
            audit_record=AuditRecord(verb, arguments, outcome.code),
        )
        robot.thread.submit(lambda: robot.reporter.add(event))
        return outcome


def late_report(
    robot: Parts, title: str, verb: str, arguments: Mapping[str, Any] | None = None
) -> Callable[[Outcome], None]:
    """Return a function that reports an answer for which nobody waits any more."""
    requester = current_requester()

    def report(outcome: Outcome) -> None:
        record = AuditRecord(verb, arguments or {}, outcome.code)
        text = f"{title}, answered late: {harmless(outcome.text)}"
        robot.reporter.report_done(text, record, requester=requester)

    return report


# Goals.


async def send(
    robot: Parts, kind: GoalKind, values: Mapping[str, Any], *, queued: bool = False
) -> Outcome:
    """Send a goal; return when the robot has accepted or refused it, or has not answered.

    A queued goal is HELD, not refused, while a STOP is open, holds or is uncertain.
    """
    length = robot.way_length(kind)
    title = " ".join(filter(None, (kind.title.lower(), values_text(kind, values))))

    async def go(gate: Gate) -> Outcome:
        turn = robot.node.next_turn()
        refusal = _refusal(robot, kind, gate, queued=queued)
        if refusal is not None:
            return refusal
        try:
            outcome = await robot.goals.send(kind, values, length, gate)
        except Void:
            return Outcome(Code.HELD if queued else Code.CANCELLED, NOT_SENT)
        if outcome.ok:
            robot.stop_sender.on_goal_accepted(turn)
        return _with_inactive_server(robot, kind.action, outcome)

    ros2 = robot.checks.goal_command(kind, values)
    return await run(robot, *robot.verb_of(kind, values), title, ros2, go)


def _refusal(robot: Parts, kind: GoalKind, gate: Gate, *, queued: bool) -> Outcome | None:
    """Return why a goal may not be sent now: STOP, several servers, or a fault; None if it may be.

    If the gate is shut, no STOP is a reason here: sending the goal raises Void, which names it.
    """
    sender = robot.stop_sender
    known = Snapshot(
        file=robot.file,
        motion=robot.telemetry.motion,
        latch=sender.stop.latch,
        released=sender.stop.released,
    )
    if queued and (sender.stop.open is not None or known.says_stopped or known.stop_holds):
        return Outcome(Code.HELD, HELD)
    # The STOP may not have reached the robot, and would not be sent again behind a goal.
    if sender.stop.open is not None and not gate.is_shut:
        return Outcome(Code.REFUSED, OPEN_STOP)
    sender.check_holders()  # Its node may have been restarted since the last poll.
    if sender.stop.latch is Latch.UNCERTAIN and not gate.is_shut:
        return Outcome(Code.HELD, HELD) if queued else Outcome(Code.REFUSED, UNCERTAIN)
    if known.stop_holds and not gate.is_shut:
        return Outcome(Code.REFUSED, HOLDS)
    servers = robot.graph.duplicate_servers(kind.action)
    if servers:  # Also of an action that is not in the robot file.
        return Outcome(Code.REFUSED, check.duplicate_servers(kind.action, servers))
    fault = robot.faults.get(kind.action)
    return None if fault is None else Outcome(Code.REFUSED, fault)


def _with_inactive_server(robot: Parts, action: str, outcome: Outcome) -> Outcome:
    """Add the managed servers that are not active to the text of a refusal."""
    full = robot.checks.full(action)
    found = (r.nodes for r in robot.graph.listed.all if (r.kind, r.name) == (ACTION, full))
    states = {node: robot.lifecycles.word(node) for nodes in found for node in nodes}
    idle = [f"{node} is {word}" for node, word in states.items() if word not in ("", "active")]
    if outcome.code is not Code.REFUSED or not idle:
        return outcome
    return outcome._replace(text=f"{outcome.text}: {', '.join(idle)}")


async def cancel(robot: Parts, *, another: bool = False) -> Outcome:
    """Request the cancel of this console's running goal, or of another client's."""
    goal, command = robot.goals.goal, ""
    if goal is not None:
        command = ros2_command.cancel(robot.checks.full(goal.kind.action))
    return await run(
        robot, "cancel", {}, "cancel", command, lambda _: robot.goals.cancel(another=another)
    )


async def cancel_all(robot: Parts) -> Outcome:
    """Request the cancel of every goal of the actions known here, whoever sent it."""
    commands = robot.checks.cancel_commands()
    return await run(
        *(robot, "cancel", {"all": True}, "cancel every goal", commands),
        lambda _: robot.goals.cancel_all(),
    )


async def stop_sending_goals(robot: Parts) -> None:
    """Refuse every further goal, also one that was typed before; running goals go on."""

    async def there() -> None:
        robot.goals.sending_has_ended = True
        robot.publications.end_all("the end of the console")

    await robot.thread.run(there, DEADLINE)


def allow_sending_goals(robot: Parts) -> None:
    """Undo `stop_sending_goals`: the console does not end after all."""
    robot.goals.sending_has_ended = False


def end_goals_of_node(robot: Parts, served: Sequence[str]) -> None:
    """End the goals of the actions (full names) that a hosted node served, as GONE. Any thread."""
    robot.thread.submit(
        lambda: robot.goals.end_goals_of_node(lambda k: robot.checks.full(k.action) in served)
    )


# Services.


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
    """Call any service by its full name; the outcome holds the answer."""
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

        slow = robot.node.create_steady_timer(SLOW_CALL, on_timer)
        try:
            answer = await robot.node.call(
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
    """Call a service of the robot file with the type of its server, if the request fits it."""
    if name not in robot.graph.offered:
        return Outcome(Code.NOT_OFFERED, not_offered(robot.checks.full(name)))
    srv_type, request, reason = robot.checks.request(name, fields)
    if srv_type is None:
        return Outcome(Code.REFUSED, reason)
    answer = await robot.node.call(
        srv_type, name, request, gate=gate, late=lambda answer: late(_outcome_of(answer))
    )
    if answer is None:
        text = f"no answer in {DEADLINE:g} s: the robot may still do it"
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
            robot.graph.listed.actions, robot.begun + FIRST_FOUND, for_stop=True
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
        turn = robot.node.next_turn()
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
    """Return service and request for a starting node; "" and {} if no STOP is open or holds."""
    stop, may_start = robot.file.stop, robot.stop_sender.stop.may_start
    if stop is None or (may_start and robot.stops.are_answered):
        return "", {}
    return robot.checks.full(stop.service), stop.request


def on_early_stop(robot: Parts, node: str) -> None:
    """Record that a starting hosted node has carried the STOP out, and now holds it. Any thread."""
    robot.thread.submit(lambda: robot.stop_sender.on_early_stop(node))
