"""What the console knows of ARCHO, and the goals that can be given to it."""

from __future__ import annotations

from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.robot import Robot
from archo_tui.robot_file.load import default_path, load

ARCHO = load(default_path())
SHELF = ARCHO.goals[0]
FORMS = {SHELF.id: (TypedField("shelf_number", "int32", 0),)}


async def go(robot: Robot, shelf: int) -> Outcome:
    """Send it to a shelf."""
    return await robot.send(SHELF, {"shelf_number": shelf})


async def reset(robot: Robot) -> Outcome:
    """Set its encoder to zero."""
    return await robot.command(ARCHO.commands[1])


async def charge(robot: Robot, on: bool = True) -> Outcome:
    """Begin or end charging."""
    return await robot.command(ARCHO.commands[0], on)
