"""Commands that the robot carries out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from archo_tui.commands.base import EVERYWHERE, Command
from archo_tui.robot.state import CHARGE, MOVE, RELEASE, RESET, STOP
from archo_tui.screens.confirm import Confirm

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp


class Go(Command):
    """Type a shelf number; enter sends the robot there."""

    id, key, footer = "go", "g", "Go"
    service = MOVE
    runs_blocked = True  # what is typed next is meant for the field, not for the panels

    def run(self, app: ArchoApp) -> None:
        app.main.focus_panel(3)


class Cancel(Command):
    """Cancel the running goal; with none running copy the selection."""

    id, key, footer = "cancel", "ctrl+c", "Cancel"
    where = EVERYWHERE

    async def run(self, app: ArchoApp) -> None:
        goal = app.view.snapshot.goal
        if goal is not None and goal.is_running:
            app.tell(await app.robot.cancel())
        elif not app.copy_selection():
            keys = f"{app.view.key('quit')} (or {app.view.key('quit_everywhere')})"
            app.notify(f"No goal is running. Press {keys} to quit.", markup=False)


class Stop(Command):
    """STOP: software stop, at once and latched; does not replace the hardware one."""

    id, key, footer = "stop", "ctrl+x", "STOP"
    where = EVERYWHERE
    service = STOP

    async def run(self, app: ArchoApp) -> None:
        app.tell(await app.robot.emergency_stop())


class Release(Command):
    """Release the stop (asks first); nothing resumes by itself."""

    id, key = "release", "R"
    service = RELEASE

    def blocked(self, app: ArchoApp) -> str:
        stopped = app.view.snapshot.motor.stopped
        return super().blocked(app) or ("" if stopped else "the robot is not stopped")

    async def run(self, app: ArchoApp) -> None:
        question = "Release the stop? Moves are allowed again; nothing resumes by itself."
        if await app.ask(Confirm("Release", question, "Stay stopped", "Release")) == "Release":
            app.tell(await app.robot.release_emergency_stop())


class Reset(Command):
    """Reset the encoder to zero; asks first while a goal runs."""

    id, key, footer = "reset", "r", "Reset"
    service = RESET

    async def run(self, app: ArchoApp) -> None:
        goal = app.view.snapshot.goal
        if goal is not None and goal.is_running:
            question = f"The robot is on its way to shelf {goal.shelf}. Reset the encoder now?"
            if await app.ask(Confirm("Reset encoder", question, "Leave it", "Reset")) != "Reset":
                return
        app.tell(await app.robot.reset_encoder())


class Charge(Command):
    """Charge the battery, or stop charging."""

    id, key = "charge", "c"
    service = CHARGE

    async def run(self, app: ArchoApp) -> None:
        app.tell(await app.robot.set_charging(not app.view.snapshot.battery.charging))
