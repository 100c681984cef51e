"""Commands of the console itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from archo_tui.commands.base import EVERYWHERE, PANELS, Command
from archo_tui.leaving import CANCEL, LEAVE, let_go
from archo_tui.screens.alarms import AlarmList
from archo_tui.screens.confirm import Confirm
from archo_tui.screens.help import Help

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp


class Acknowledge(Command):
    """Acknowledge the alarm in the banner."""

    id, key = "acknowledge", "a"

    def blocked(self, app: ArchoApp) -> str:
        unseen = any(not alarm.acknowledged for alarm in app.view.alarms)
        return "" if unseen else "no alarm to acknowledge"

    def run(self, app: ArchoApp) -> None:
        app.acknowledge(list(app.view.alarms[:1]))


class ShowAlarms(Command):
    """List the alarms: acknowledge one or all, shelve one for a while."""

    id, key = "alarms", "A"

    def run(self, app: ArchoApp) -> None:
        app.push_screen(AlarmList(app.view, app.acknowledge, app.shelve))


class Panel(Command):
    """Focus one of the numbered panels."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.id = f"panel_{number}"  # type: ignore[misc]
        self.key = str(number)  # type: ignore[misc]
        if number == 1:
            self.footer, self.footer_key = "Panels", "1-6"  # type: ignore[misc]

    @property
    def help(self) -> str:
        return f"Go to panel {self.number}, {PANELS[self.number - 1]}"

    def run(self, app: ArchoApp) -> None:
        app.main.focus_panel(self.number)


class ShowHelp(Command):
    """Show all keys."""

    id, key, footer = "help", "question_mark", "Help"

    def run(self, app: ArchoApp) -> None:
        if not isinstance(app.screen, Help):
            app.push_screen(Help(app.registry, app.blocked, app.view.key))


class Palette(Command):
    """Open the command palette: every command, and the themes."""

    id, key = "palette", "ctrl+p"
    where = EVERYWHERE

    def run(self, app: ArchoApp) -> None:
        app.action_command_palette()


class Suspend(Command):
    """Suspend to the shell (fg comes back); nodes of this process stand still meanwhile."""

    id, key = "suspend", "ctrl+z"
    where = EVERYWHERE

    async def run(self, app: ArchoApp) -> None:
        goal = app.view.snapshot.goal
        if goal is not None and goal.is_running and not app.attached:
            question = (
                f"The robot is on its way to shelf {goal.shelf}; its nodes would stand still."
            )
            if await app.ask(Confirm("Suspend", question, "Stay", "Suspend")) != "Suspend":
                return
        app.action_suspend_process()


class Quit(Command):
    """Quit; with a goal running asks, and cancels it first."""

    id, key, footer = "quit", "q", "Quit"

    async def run(self, app: ArchoApp) -> None:
        goal = app.view.snapshot.goal
        if goal is not None and goal.is_running:
            question = f"The robot is on its way to shelf {goal.shelf}."
            answers = ["Stay", "Cancel it and quit"]
            if app.attached:
                answers.append("Leave it running and quit")
            answer = await app.ask(Confirm("Quit", question, *answers))
            if answer == answers[0]:
                return
            await let_go(app.robot, CANCEL if answer == answers[1] else LEAVE, "quit")
        app.exit()


class QuitEverywhere(Quit):
    """Quit, also while typing."""

    id, key, footer = "quit_everywhere", "ctrl+q", ""
    where = EVERYWHERE
