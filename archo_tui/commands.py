"""The one registry of commands: keys, footer, `?`, palette and buttons all come from it."""

from __future__ import annotations

from collections.abc import Coroutine
from typing import TYPE_CHECKING, Any, ClassVar

from archo_tui.robot.state import CHARGE, MOVE, RELEASE, RESET, STOP
from archo_tui.screens.confirm import Confirm
from archo_tui.screens.help import Help

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp

EVERYWHERE, NOT_TYPING = "everywhere", "not while typing"


class Command:
    """One thing the operator can do. A command's docstring is its help."""

    id: ClassVar[str]
    key: ClassVar[str]  # Textual's name of the key
    shown_key: ClassVar[str]  # as a person reads it
    footer: ClassVar[str] = ""  # one word; empty: not in the footer
    footer_key: ClassVar[str] = ""  # the key in the footer where it stands for several
    where: ClassVar[str] = NOT_TYPING
    service: ClassVar[str] = ""  # what somebody must offer

    @property
    def help(self) -> str:
        """One sentence for `?` and the palette."""
        return (self.__doc__ or "").rstrip(".")

    def blocked(self, app: ArchoApp) -> str:
        """Why the command cannot run now, or an empty string."""
        if self.service and self.service not in app.view.snapshot.offered:
            return f"{self.service} is not offered by any node"
        return ""

    def run(self, app: ArchoApp) -> Coroutine[Any, Any, None] | None:
        """Do it at once, or return a coroutine that may wait for the robot."""
        raise NotImplementedError


class Go(Command):
    """Type a shelf number; enter sends the robot there."""

    id, key, shown_key, footer = "go", "g", "g", "Go"
    service = MOVE

    def run(self, app: ArchoApp) -> None:
        app.main.focus_panel(3)


class Cancel(Command):
    """Cancel the running goal; with none running copy the selection."""

    id, key, shown_key, footer = "cancel", "ctrl+c", "^c", "Cancel"
    where = EVERYWHERE

    async def run(self, app: ArchoApp) -> None:
        goal = app.view.snapshot.goal
        if goal is not None and goal.is_running:
            app.tell(await app.robot.cancel())
        elif not app.copy_selection():
            app.notify("No goal is running. Press q (or ctrl+q) to quit.")


class Stop(Command):
    """Software stop, at once and latched; does not replace the hardware one."""

    id, key, shown_key, footer = "stop", "ctrl+x", "^x", "STOP"
    where = EVERYWHERE
    service = STOP

    async def run(self, app: ArchoApp) -> None:
        app.tell(await app.robot.emergency_stop())


class Release(Command):
    """Release the stop (asks first); nothing resumes by itself."""

    id, key, shown_key = "release", "R", "R"
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

    id, key, shown_key, footer = "reset", "r", "r", "Reset"
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

    id, key, shown_key = "charge", "c", "c"
    service = CHARGE

    async def run(self, app: ArchoApp) -> None:
        app.tell(await app.robot.set_charging(not app.view.snapshot.battery.charging))


class Acknowledge(Command):
    """Acknowledge the alarm in the banner."""

    id, key, shown_key = "acknowledge", "a", "a"

    def blocked(self, app: ArchoApp) -> str:
        unseen = any(not alarm.acknowledged for alarm in app.view.alarms)
        return "" if unseen else "no alarm to acknowledge"

    def run(self, app: ArchoApp) -> None:
        app.acknowledge()


class Level(Command):
    """Show events of more or fewer levels."""

    id, key, shown_key = "level", "l", "l"

    def run(self, app: ArchoApp) -> None:
        app.main.events.next_level()


class ShowHelp(Command):
    """Show all keys."""

    id, key, shown_key, footer = "help", "question_mark", "?", "Help"

    def run(self, app: ArchoApp) -> None:
        if not isinstance(app.screen, Help):
            app.push_screen(Help(app.registry, app.blocked))


class Quit(Command):
    """Quit (also ctrl+q, everywhere); with a goal running asks."""

    id, key, shown_key, footer = "quit", "q", "q", "Quit"

    async def run(self, app: ArchoApp) -> None:
        await app.leave()


class QuitEverywhere(Quit):
    """Quit, also while typing."""

    id, key, shown_key, footer = "quit_everywhere", "ctrl+q", "^q", ""
    where = EVERYWHERE


class Panel(Command):
    """Focus one of the numbered panels."""

    def __init__(self, number: int, title: str) -> None:
        self.number = number
        self.id = f"panel_{number}"  # type: ignore[misc]
        self.key = self.shown_key = str(number)  # type: ignore[misc]
        self.title = title
        if number == 1:
            self.footer, self.footer_key = "Panels", "1-6"  # type: ignore[misc]

    @property
    def help(self) -> str:
        return f"Go to panel {self.number}, {self.title}"

    def run(self, app: ArchoApp) -> None:
        app.main.focus_panel(self.number)


PANELS = ("Battery", "Motor", "Go to shelf", "Parameters", "Nodes", "Events")

COMMANDS: tuple[Command, ...] = (
    Go(),
    Cancel(),
    Stop(),
    Release(),
    Reset(),
    Charge(),
    Acknowledge(),
    *(Panel(number, title) for number, title in enumerate(PANELS, 1)),
    Level(),
    ShowHelp(),
    Quit(),
    QuitEverywhere(),
)
