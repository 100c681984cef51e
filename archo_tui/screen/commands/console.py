"""The console's own commands: alarms, panels, help, quitting."""

from __future__ import annotations

from functools import partial

from archo_tui.base.system import CAN_SUSPEND
from archo_tui.screen.commands.base import (
    EVERYWHERE,
    Answers,
    Command,
    Desk,
    VerbCommand,
    Work,
)
from archo_tui.station.shutdown import CANCEL, LEAVE, let_go
from archo_tui.station.station import Station
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


def _ends_of_publications(station: Station) -> list[str]:
    """Return a sentence for each message that this console publishes at a rate."""
    active = station.robot.publications.active
    return [f"{publication.text}, ends with this console." for publication in active]


class Quit(Command):
    id, key, footer = "quit", "q", "Quit"
    help = "Quit; asks before it ends a goal or what is published"

    def run(self, desk: Desk) -> Work | None:
        goal, station = desk.station.running_goal, desk.station
        published = _ends_of_publications(station)
        if goal is None:
            # A goal may be on its way to the robot, so the choice still matters.
            end = partial(self._end, desk, station.on_disconnect)
            snapshot, told = station.robot.snapshot, published
            if station.attached and snapshot.is_stopped:
                stays = _STAYS_OPEN if snapshot.open_stop is not None else _STAYS_STOPPED
                told = [stays, *published]
            if not told:
                return end()
            desk.confirm("Quit", " ".join(told), "Stay", {"Quit": end})
            return None
        if not goal.mine:
            self._leave_another(desk)
            return None
        answers: Answers = {"Cancel goal and quit": partial(self._end, desk, CANCEL)}
        if station.attached:
            answers = {**answers, "Leave it running and quit": partial(self._end, desk, LEAVE)}
        text = " ".join((f"The robot is {activity(goal)}.", *published))
        desk.confirm("Quit", text, "Stay", answers)
        return None

    async def _end(self, desk: Desk, choice: str) -> None:
        station = desk.station
        await let_go(station.robot, station.clock, choice, "quit")
        desk.leave()

    def _leave_another(self, desk: Desk) -> None:
        """Ask before quitting while another client's goal runs.

        Nodes of this process may be driving that goal, and would end.
        """
        station = desk.station
        nodes = "the nodes of this console would end with it"
        what = "it keeps running" if station.attached else nodes
        running = f"Another client's goal is running: {what}."
        question = " ".join((running, *_ends_of_publications(station)))
        end = partial(self._end, desk, station.on_disconnect)
        desk.confirm("Quit", question, "Stay", {"Quit": end})


class QuitEverywhere(Quit):
    id, key, footer = "quit_everywhere", "ctrl+q", ""
    help = "Quit, also while typing"
    where = EVERYWHERE
