"""The requests that send and cancel goals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from archo_tui.robot import calls
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.run import run
from archo_tui.robot.state.goal import values_text
from archo_tui.robot.state.graph import ACTION
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.robot.stop.gate import HELD, HOLDS, NOT_SENT, OPEN_STOP, UNCERTAIN, Gate, Void
from archo_tui.robot_file import check
from archo_tui.robot_file.model import GoalKind


async def send(
    robot: Parts, kind: GoalKind, values: Mapping[str, Any], *, queued: bool = False
) -> Outcome:
    """Send a goal; return when the robot has accepted or refused it, or has not answered.

    A queued goal is HELD, not refused, while a STOP is open, holds or is uncertain.
    """
    length = robot.way_length(kind)
    title = " ".join(filter(None, (kind.title.lower(), values_text(kind, values))))

    async def go(gate: Gate) -> Outcome:
        turn = robot.services.next_turn()
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
    found = (r.nodes for r in robot.graph.resources if (r.kind, r.name) == (ACTION, full))
    states = {node: robot.lifecycles.word(node) for nodes in found for node in nodes}
    idle = [f"{node} is {word}" for node, word in states.items() if word not in ("", "active")]
    if outcome.code is not Code.REFUSED or not idle:
        return outcome
    return outcome._replace(text=f"{outcome.text}: {', '.join(idle)}")


async def cancel(robot: Parts, *, another: bool = False) -> Outcome:
    """Request the cancel of this console's running goal, or of another client's.

    ACCEPTED means that the goal's end is reported later.
    """
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
    """Refuse every further goal, also one that was typed before: the console ends.

    Running goals go on.

    Raises:
        TimeoutError: The ROS thread does not answer.
    """

    async def there() -> None:
        robot.goals.sending_has_ended = True
        robot.publications.end_all("the end of the console")

    await robot.thread.run(there, calls.DEADLINE)


def allow_sending_goals(robot: Parts) -> None:
    """Undo `stop_sending_goals`: the console does not end after all."""
    robot.goals.sending_has_ended = False


def end_goals_of_node(robot: Parts, served: Sequence[str]) -> None:
    """End the goals of the actions (full names) that a hosted node served, as GONE. Any thread."""
    robot.thread.submit(
        lambda: robot.goals.end_goals_of_node(lambda k: robot.checks.full(k.action) in served)
    )
