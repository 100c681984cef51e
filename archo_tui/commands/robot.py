"""Commands that the robot carries out."""

from __future__ import annotations

from archo_tui.commands.base import EVERYWHERE, Command, Console, Work
from archo_tui.robot.state import CHARGE, MOVE, RELEASE, RESET, RUNNING, STOP, Phase
from archo_tui.screens.confirm import Confirm

# a cancel was asked for, or there is nothing to cancel any more
_CANCELLED = {Phase.CANCELLING} | (set(Phase) - set(RUNNING))


class Go(Command):
    id, key, footer = "go", "g", "Go"
    help = "Type a shelf number; enter sends the robot there"
    service = MOVE
    runs_blocked = True  # what is typed next is meant for the field, not for the panels

    def run(self, console: Console) -> None:
        console.main.focus_panel(3)


class Cancel(Command):
    id, key, footer = "cancel", "ctrl+c", "Cancel"
    help = "Cancel the running goal; if none is running, copy the selection"
    where = EVERYWHERE
    every = 0.5

    def run(self, console: Console) -> Work | None:
        goal = console.view.snapshot.goal
        if console.repeated and (goal is None or goal.phase in _CANCELLED):
            return None
        return self._run(console)

    async def _run(self, console: Console) -> None:
        goal = console.view.snapshot.goal
        if goal is not None and goal.is_running:
            console.tell(await console.station.robot.cancel())
        elif not console.copy_selection():
            keys = f"{console.view.key('quit')} (or {console.view.key('quit_everywhere')})"
            console.say(f"No goal is running. Press {keys} to quit.")


class Stop(Command):
    id, key, footer = "stop", "ctrl+x", "STOP"
    help = "STOP: software stop, at once and latched; does not replace the hardware one"
    where = EVERYWHERE
    service = STOP
    insists = True  # never dropped: the robot may only just have been found
    every = 0.5

    def run(self, console: Console) -> Work | None:
        if console.repeated and console.view.snapshot.motor.stopped:
            return None  # the key is held, and the robot has stopped
        return self._run(console)

    async def _run(self, console: Console) -> None:
        console.tell(await console.station.robot.emergency_stop())


class Release(Command):
    id, key = "release", "R"
    help = "Release the stop (asks first); nothing resumes by itself"
    service = RELEASE
    once = True

    def blocked(self, console: Console) -> str:
        stopped = console.view.snapshot.motor.stopped
        return super().blocked(console) or ("" if stopped else "the robot is not stopped")

    def run(self, console: Console) -> None:
        question = "Release the stop? Moves are allowed again; nothing resumes by itself."

        def then(answer: str) -> Work | None:
            return release() if answer == "Release" else None

        async def release() -> None:
            console.tell(await console.station.robot.release_emergency_stop())

        console.ask(Confirm("Release", question, "Stay stopped", "Release"), then)


class Reset(Command):
    id, key, footer = "reset", "r", "Reset"
    help = "Reset the encoder to zero; asks first while a goal runs"
    service = RESET
    once = True

    def run(self, console: Console) -> Work | None:
        async def reset() -> None:
            console.tell(await console.station.robot.reset_encoder())

        def then(answer: str) -> Work | None:
            return reset() if answer == "Reset" else None

        goal = console.view.snapshot.goal
        if goal is None or not goal.is_running:
            return reset()
        question = f"The robot is on its way to shelf {goal.shelf}. Reset the encoder now?"
        console.ask(Confirm("Reset encoder", question, "Leave it", "Reset"), then)
        return None


class Charge(Command):
    id, key = "charge", "c"
    help = "Charge the battery, or stop charging"
    service = CHARGE
    once = True

    async def run(self, console: Console) -> None:
        charging = console.view.snapshot.battery.charging
        console.tell(await console.station.robot.set_charging(not charging))
