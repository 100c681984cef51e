"""What becomes of a running goal when the console has to go: chosen and told beforehand."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from archo_tui.robot.client import Robot

CANCEL, LEAVE = "cancel", "leave"
ON_DISCONNECT = (CANCEL, LEAVE)
WAIT = 2.0  # s for the robot's answer; the process goes then in any case


async def let_go(robot: Robot, on_disconnect: str, why: str) -> None:
    """Cancel the running goal and wait for its end, or leave it running; the events say which."""
    goal = robot.snapshot.goal
    if goal is None or not goal.is_running:
        return
    if on_disconnect == LEAVE:
        robot.note("WARN", "console", f"{why}: the goal to shelf {goal.shelf} is left running")
        return
    robot.note("WARN", "console", f"{why}: cancelling the goal to shelf {goal.shelf}")
    try:
        await asyncio.wait_for(_cancel(robot), WAIT)
    except asyncio.TimeoutError:
        robot.note("ERROR", "console", f"no answer in {WAIT:g} s: the goal may be running")


async def _cancel(robot: Robot) -> None:
    outcome = await robot.cancel()
    while outcome.ok and robot.snapshot.goal is not None and robot.snapshot.goal.is_running:
        await asyncio.sleep(0.02)
