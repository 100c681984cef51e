"""The console's own commands: alarms, panels, help, quitting."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from archo_tui.commands.base import (
    EVERYWHERE,
    GRAPH,
    NOT_TYPING,
    Answers,
    Command,
    Console,
    VerbCommand,
    Work,
)
from archo_tui.robot.state.readings import Diagnostic
from archo_tui.shutdown import CANCEL, LEAVE, let_go
from archo_tui.station.alarms import any_urgent
from archo_tui.station.station import Station
from archo_tui.system import CAN_SUSPEND
from archo_tui.text.goal import activity
from archo_tui.verbs.show import ShowDiagnostics, forget
from archo_tui.verbs.verb import Verb

if TYPE_CHECKING:
    from archo_tui.screens.help import Entry
    from archo_tui.widgets.panel import Panel


class AcknowledgeKey(VerbCommand):
    key = "a"

    def __init__(self, verb: Verb) -> None:
        super().__init__(verb)
        self.help = "Acknowledge the alarm in the banner"


class ShowAlarms(Command):
    id, key, verbs = "alarms", "A", ("alarms", "shelve")
    help = "List the alarms: acknowledge one or all, shelve one; or answer what an assistant asks"

    def run(self, console: Console) -> None:
        from archo_tui.screens.lists import AlarmList
        from archo_tui.screens.request import AnswerRequest

        station, waiting = console.station, console.station.approvals.waiting
        if waiting and not any_urgent(console.view.alarms):  # Alarms of high priority come first.
            on_end = partial(_answer, console), console.drop_following_keys
            seen = (lambda: console.is_stuck), (lambda: console.input)
            console.open(AnswerRequest(waiting[0], console.view, *seen, *on_end))
            return
        forget_part = partial(_forget, console)
        changes = station.acknowledge, station.shelve, console.update_screen, forget_part
        console.open(AlarmList(console.view, *changes))


class ListDiagnostics(Command):
    id, verbs = "diagnostics", ("diagnostics", "forget")
    help = ShowDiagnostics.help

    def run(self, console: Console) -> None:
        from archo_tui.screens.lists import DiagnosticList

        console.open(DiagnosticList(console.view, partial(_forget, console)))


def _forget(console: Console, part: Diagnostic) -> None:
    console.report_failure(forget(console.station, part))


class OperateOtherRobot(Command):
    """The command that restarts the console for the robot of another namespace, chosen in a list.

    Only with `--attach`, and not while a goal runs or waits or a STOP is not released.
    """

    id = "other_robot"
    help = "Operate another robot: one in another namespace (the console restarts)"

    def disabled_reason(self, console: Console) -> str:
        station, snapshot = console.station, console.station.robot.snapshot
        if not station.attached:
            return "only a console with --attach changes robots"
        if station.restart_blocker:
            return station.restart_blocker
        if station.running_goal is not None:
            return "a goal runs: cancel it first"
        if station.queue.waiting or station.queue.is_going:
            return "a goal waits or is being sent: cancel it first"
        return "" if snapshot.other_namespaces else "no other namespace has nodes"

    def run(self, console: Console) -> None:
        from archo_tui.screens.choose import Choice, Choose

        names = console.station.robot.snapshot.other_namespaces
        choices = [Choice(name, partial(self._operate, console, name)) for name in names]
        console.open(Choose("Operate another robot", choices))

    def _operate(self, console: Console, namespace: str) -> None:
        """Restart the console for a namespace; show why not if the command is disabled by now."""
        reason = self.disabled_reason(console)
        if reason:
            console.show_message(reason)
            return
        console.station.operate(namespace)


def _answer(console: Console, number: int, allowed: bool) -> None:
    console.report_failure(console.station.approvals.answer(number, allowed=allowed))
    console.update_screen()


# The verbs that print what a panel shows, by its number.
_SHOWN = {
    1: ("status",),
    4: ("params", "get"),
    5: ("nodes",),
    6: ("events",),
    8: ("topics",),
}


_NOW = "Now"
_FOR_A_STATE = ("release", "continue", "skip", "ack")  # Each can run in one state only.


class PanelKey(Command):
    def __init__(self, number: int, title: str) -> None:
        self.number = number
        self.id, self.key = f"panel_{number}", str(number)
        self.help = f"Go to panel {number}, {title}"
        self.verbs = _SHOWN.get(number, ())
        if number == 1:
            self.footer, self.footer_key = "Panels", "1-8"
        self.gives_way = number == GRAPH

    def run(self, console: Console) -> None:
        console.main.focus_panel(self.number)


class ShowHelp(Command):
    id, key, footer = "help", "question_mark", "Help"
    help = "Show the keys of the panel with the focus, and below them all others"

    def run(self, console: Console) -> None:
        from archo_tui.screens.help import Help

        front = console.screen
        if isinstance(front, Help):
            front.dismiss()
            return
        panel = console.main.panel_with_focus if front is console.main else None
        console.open(Help(partial(_help_entries, console, panel)))


class ShowHelpEverywhere(ShowHelp):
    id, key, footer, where = "help_everywhere", "f1", "", EVERYWHERE
    help = "Show all keys; works in dialogs and while typing, too"


def _help_entries(console: Console, panel: Panel | None) -> list[Entry]:
    """Return all keys: first those for the state, those of the focus, and those of everywhere."""
    from archo_tui.screens.help import Entry

    here = f"Here, in {panel.title_text}" if panel is not None else ""
    taken = panel.field_keys if panel is not None else ()
    entries = [Entry(here, key, word, True) for key, word in taken]
    for command in console.registry:
        if isinstance(command, PanelKey):
            continue
        entry = _help_entry(console, command)
        if entry.key and entry.works and command.id in _FOR_A_STATE:
            entry = entry._replace(section=_NOW)
        elif panel is not None and entry.key and command.where != EVERYWHERE:
            key = panel.other_keys.get(command.id, entry.key)
            if any(key == other for other, _ in taken):
                continue
            if command.panel == panel.number or command.id in dict(panel.keys):
                entry = entry._replace(section=here, key=key)
        if command.id == "release":  # While stopped, that is what is asked for first.
            entries.insert(0, entry)
        else:
            entries.append(entry)
    panels = sum(isinstance(command, PanelKey) for command in console.registry)
    entries.append(Entry(NOT_TYPING.capitalize(), f"1-{panels}", "Go to a panel", True))
    first = {_NOW: 0, here: 1, EVERYWHERE.capitalize(): 2}
    return sorted(entries, key=lambda entry: (first.get(entry.section, 3), not entry.key))


def _help_entry(console: Console, command: Command) -> Entry:
    from archo_tui.screens.help import Entry

    key = console.view.key(command.id)
    place = (
        f"{command.where_text[0].upper()}{command.where_text[1:]}" if key else "In the palette only"
    )
    return Entry(place, key, command.help, not console.disabled_reason(command))


class KeepKey(VerbCommand):
    def run(self, console: Console) -> None:
        console.show_message(f"{console.station.recorder.keep().text.capitalize()}.")


class ToggleQuiet(Command):
    id = "quiet_alarms"
    help = "Turn the bell and the desktop notification of new alarms off or on"

    def run(self, console: Console) -> None:
        station = console.station
        station.quiet = not station.quiet
        console.show_message(f"New alarms are {'silent' if station.quiet else 'rung again'}.")


class Suspend(Command):
    id, key = "suspend", "ctrl+z"
    help = "Suspend to the shell (fg brings it back); nodes started here pause meanwhile"
    where = EVERYWHERE

    def disabled_reason(self, console: Console) -> str:
        return "" if CAN_SUSPEND else "this system cannot suspend a program"

    def run(self, console: Console) -> None:
        goal = console.station.running_goal
        if goal is None or console.station.attached:
            console.action_suspend_process()
            return
        question = f"The robot is {activity(goal)}; its nodes would pause."
        console.confirm("Suspend", question, "Stay", {"Suspend": console.action_suspend_process})


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
    help = "Quit; if a goal runs, asks first and cancels it"

    def run(self, console: Console) -> Work | None:
        goal, station = console.station.running_goal, console.station
        published = _ends_of_publications(station)
        if goal is None:
            # A goal may be on its way to the robot, so the choice still matters.
            end = partial(self._end, console, station.on_disconnect)
            snapshot, told = station.robot.snapshot, published
            if station.attached and snapshot.is_stopped:
                stays = _STAYS_OPEN if snapshot.open_stop is not None else _STAYS_STOPPED
                told = [stays, *published]
            if not told:
                return end()
            console.confirm("Quit", " ".join(told), "Stay", {"Quit": end})
            return None
        if not goal.mine:
            self._leave_another(console)
            return None
        answers: Answers = {"Cancel goal and quit": partial(self._end, console, CANCEL)}
        if station.attached:
            answers = {**answers, "Leave it running and quit": partial(self._end, console, LEAVE)}
        text = " ".join((f"The robot is {activity(goal)}.", *published))
        console.confirm("Quit", text, "Stay", answers)
        return None

    async def _end(self, console: Console, choice: str) -> None:
        station = console.station
        await let_go(station.robot, station.clock, choice, "quit")
        console.leave()

    def _leave_another(self, console: Console) -> None:
        """Ask before quitting while another client's goal runs.

        Nodes of this process may be driving that goal, and would end.
        """
        station = console.station
        nodes = "the nodes of this console would end with it"
        what = "it keeps running" if station.attached else nodes
        running = f"Another client's goal is running: {what}."
        question = " ".join((running, *_ends_of_publications(station)))
        end = partial(self._end, console, station.on_disconnect)
        console.confirm("Quit", question, "Stay", {"Quit": end})


class QuitEverywhere(Quit):
    id, key, footer = "quit_everywhere", "ctrl+q", ""
    help = "Quit, also while typing"
    where = EVERYWHERE
