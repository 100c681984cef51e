"""The console's own commands: alarms, panels, help, quitting."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from archo_tui.base.system import CAN_SUSPEND
from archo_tui.screen.commands.base import (
    EVERYWHERE,
    Command,
    Desk,
    VerbCommand,
    Work,
)
from archo_tui.station.shutdown import CANCEL, LEAVE, let_go
from archo_tui.text.goal import activity


class KeepKey(VerbCommand):
    def run(self, desk: Desk) -> None:
        desk.show_message(f"{desk.station.recorder.keep().text.capitalize()}.")


class ToggleQuiet(Command):
    id = "quiet_alarms"
    help = "Turn the bell of new alarms off or on"

    def run(self, desk: Desk) -> None:
        station = desk.station
        station.quiet = not station.quiet
        desk.show_message(f"New alarms are {'silent' if station.quiet else 'rung again'}.")


class Suspend(Command):
    in_replay = True
    id, key = "suspend", "ctrl+z"
    help = "Suspend to the shell (fg brings it back); nodes started here pause meanwhile"
    where = EVERYWHERE

    def disabled_reason(self, desk: Desk) -> str:
        return "" if CAN_SUSPEND else "this system cannot suspend a program"

    def run(self, desk: Desk) -> None:
        goal = desk.station.running_goal
        if goal is None or desk.station.attached:
            desk.action_suspend_process()
            return
        question = f"The robot is {activity(goal)}; its nodes would pause."
        desk.confirm("Suspend", question, "Stay", {"Suspend": desk.action_suspend_process})


# Of a robot that runs elsewhere; nodes of this process end, and with them the STOP that they hold.
_STAYS_STOPPED = (
    "The robot is stopped, and stays so: the STOP holds on until R in a console, or archo-tui "
    "release, releases it."
)
_STAYS_OPEN = "The STOP is not confirmed, and once this console has ended nobody repeats it."


class Quit(Command):
    id, key, footer = "quit", "q", "Quit"
    help = "Quit; asks before it ends a goal or what is published"

    def run(self, desk: Desk) -> Work | None:
        goal, station, told = desk.station.running_goal, desk.station, []
        # Without a goal, too: one may be on its way to the robot.
        end = partial(self._end, desk, station.on_disconnect)
        answers: dict[str, Callable[[], Work]] = {"Quit": end}
        if goal is None:
            snapshot = station.robot.snapshot
            if station.attached and snapshot.is_stopped:
                told.append(_STAYS_OPEN if snapshot.open_stop is not None else _STAYS_STOPPED)
        elif not goal.mine:  # Nodes of this process may be driving it, and would end.
            nodes = "the nodes of this console would end with it"
            what = "it keeps running" if station.attached else nodes
            told.append(f"Another client's goal is running: {what}.")
        else:
            told.append(f"The robot is {activity(goal)}.")
            answers = {"Cancel goal and quit": partial(self._end, desk, CANCEL)}
            if station.attached:
                answers["Leave it running and quit"] = partial(self._end, desk, LEAVE)
        active = station.robot.publications.active
        told += [f"{publication.text}, ends with this console." for publication in active]
        if not told:
            return end()
        desk.confirm("Quit", " ".join(told), "Stay", answers)
        return None

    @staticmethod
    async def _end(desk: Desk, choice: str) -> None:
        station = desk.station
        await let_go(station.robot, station.clock, choice, "quit")
        desk.leave()
