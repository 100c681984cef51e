"""The requests about STOP: send it, release it, give it up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.run import late_report, run
from archo_tui.robot.requests.services import call_named
from archo_tui.robot.stop.gate import Gate
from archo_tui.robot.stop.sender import FIRST_FOUND
from archo_tui.robot_file.model import NO_STOP

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
