"""Commands of the console itself."""

from __future__ import annotations

from functools import partial

from archo_tui.commands.base import EVERYWHERE, Answers, Command, Console, Work
from archo_tui.goal_text import way
from archo_tui.screens.alarms import AlarmList
from archo_tui.screens.help import Entry, Help
from archo_tui.shutdown import CANCEL, LEAVE, let_go
from archo_tui.system import CAN_SUSPEND


class Acknowledge(Command):
    id, key = "acknowledge", "a"
    help = "Acknowledge the alarm in the banner"

    def blocked(self, console: Console) -> str:
        unseen = any(not alarm.acknowledged for alarm in console.view.alarms)
        return "" if unseen else "no alarm to acknowledge"

    def run(self, console: Console) -> None:
        console.station.acknowledge(console.view.alarms[:1])
        console.look()


class ShowAlarms(Command):
    id, key = "alarms", "A"
    help = "List the alarms: acknowledge one or all, shelve one for a while"

    def run(self, console: Console) -> None:
        station = console.station
        console.open(AlarmList(console.view, station.acknowledge, station.shelve, console.look))


class Panel(Command):
    def __init__(self, number: int, title: str) -> None:
        self.number = number
        self.id, self.key = f"panel_{number}", str(number)
        self.help = f"Go to panel {number}, {title}"
        if number == 1:
            self.footer, self.footer_key = "Panels", "1-7"

    def run(self, console: Console) -> None:
        console.main.focus_panel(self.number)


class ShowHelp(Command):
    id, key, footer = "help", "question_mark", "Help"
    help = "Show all keys"

    def run(self, console: Console) -> None:
        if isinstance(console.screen, Help):
            console.screen.action_close()
            return
        entries = [
            Entry(
                command.place[0].upper() + command.place[1:]
                if console.view.key(command.id)
                else "In the palette only",
                console.view.key(command.id),
                command.help,
                console.blocked(command),
            )
            for command in console.registry
        ]
        console.open(Help(entries))


class ShowHelpEverywhere(ShowHelp):
    id, key, footer = "help_everywhere", "f1", ""
    help = "Show all keys, in dialogs and while typing, too"
    where = EVERYWHERE


class Palette(Command):
    id, key = "palette", "ctrl+p"
    help = "Open the command palette: every command, and the themes"
    where = EVERYWHERE

    def run(self, console: Console) -> None:
        console.action_command_palette()


class Quiet(Command):
    id = "quiet_alarms"
    help = "Silence the bell and the desktop's notice of new alarms, or turn them on again"

    def run(self, console: Console) -> None:
        station = console.station
        station.quiet = not station.quiet
        console.say(f"New alarms are {'silent' if station.quiet else 'rung again'}.")


class Suspend(Command):
    id, key = "suspend", "ctrl+z"
    help = "Suspend to the shell (fg brings it back); the nodes of this process pause meanwhile"
    where = EVERYWHERE

    def blocked(self, console: Console) -> str:
        return "" if CAN_SUSPEND else "this system cannot suspend a program"

    def run(self, console: Console) -> None:
        goal = console.view.snapshot.running_goal
        if goal is None or console.station.attached:
            console.action_suspend_process()
            return
        question = f"The robot is {way(goal)}; its nodes would pause."
        console.confirm("Suspend", question, "Stay", {"Suspend": console.action_suspend_process})


class Quit(Command):
    id, key, footer = "quit", "q", "Quit"
    help = "Quit; while a goal runs asks, and cancels it first"

    def run(self, console: Console) -> Work | None:
        goal, station = console.view.snapshot.running_goal, console.station
        if goal is None:
            return self._end(console, station.on_disconnect)  # one may be on its way to the robot
        if not goal.mine:
            self._leave_another(console)
            return None
        answers: Answers = {"Cancel it and quit": partial(self._end, console, CANCEL)}
        if station.attached:
            answers = {**answers, "Leave it running and quit": partial(self._end, console, LEAVE)}
        console.confirm("Quit", f"The robot is {way(goal)}.", "Stay", answers)
        return None

    async def _end(self, console: Console, choice: str) -> None:
        station = console.station
        await let_go(station.robot, station.clock, choice, "quit")
        console.leave()

    def _leave_another(self, console: Console) -> None:
        """Another client's goal is not ours to end, but our nodes may be driving it."""
        station = console.station
        nodes = "the nodes of this console would end with it"
        what = "it keeps running" if station.attached else nodes
        question = f"Another client's goal is running: {what}."
        end = partial(self._end, console, station.on_disconnect)
        console.confirm("Quit", question, "Stay", {"Quit": end})


class QuitEverywhere(Quit):
    id, key, footer = "quit_everywhere", "ctrl+q", ""
    help = "Quit, also while typing"
    where = EVERYWHERE
