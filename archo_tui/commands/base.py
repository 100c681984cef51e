"""What a command is, and the few things that it may do with the console."""

from __future__ import annotations

import os.path
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Protocol

from textual.screen import Screen
from textual.theme import Theme

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.parameters import save_load
from archo_tui.robot.outcome import Outcome
from archo_tui.robot_file.model import RobotFile
from archo_tui.screens.main import MainScreen
from archo_tui.station.station import Station
from archo_tui.terminal.stop_marks import InputTime
from archo_tui.verbs.base import Values, Verb
from archo_tui.widgets.screen_state import ScreenState

Work = Coroutine[Any, Any, None]  # what may wait for the robot
Answers = Mapping[str, Callable[[], Work | None]]  # what each answer does, by its words
EVERYWHERE, NOT_TYPING, IN_PANEL = "everywhere", "not while typing", "in the panel"
PARAMETERS, NODES, EVENTS, GRAPH, TIME = 4, 5, 6, 8, 9
_PANELS = {  # that have own commands
    PARAMETERS: "Parameters",
    NODES: "Nodes",
    EVENTS: "Events",
    GRAPH: "Graph",
    TIME: "the time line",
}


class Console(Protocol):
    """The console, as its commands see it; the app is one."""

    station: Station
    verbs: Mapping[str, Verb]
    view: ScreenState  # what is shown now
    main: MainScreen
    theme: str  # its name
    repeated: bool  # the key of the command is being held down
    input: InputTime | None  # when the key or click that is being done was read
    typed: dict[str, dict[str, str]]  # what was last typed into each form, by path
    used: RobotFile  # the robot's file, with what was sent and called without it

    @property
    def registry(self) -> Sequence[Command]:
        """Every command."""

    @property
    def screen(self) -> Screen[Any]:
        """The dialog in front, or the main screen."""

    @property
    def is_stuck(self) -> bool:
        """True while the terminal does not show what was drawn."""

    def blocked(self, command: Command) -> str:
        """Why a command cannot run now, or an empty string."""

    def look(self) -> None:
        """Something changed in this process: show it."""

    def open(self, dialog: Screen[Any]) -> None:
        """Show a dialog."""

    def opening(self) -> AbstractContextManager[None]:
        """Hold the keys meanwhile: they are for what is about to be opened."""

    def speak(self, verb: Verb, values: Values) -> Work | None:
        """Ask what the verb asks, then do it."""

    def confirm(self, title: str, question: str, safe: str, answers: Answers) -> None:
        """Put a question now; `safe` is the answer that changes nothing."""

    def tell(self, outcome: Outcome) -> None:
        """Say it when a command failed."""

    def dialog_gone(self, why: str) -> None:
        """A dialog went by itself: the keys that were for it act nowhere else."""

    def say(self, text: str, title: str = "") -> None:
        """Say something that is not visible otherwise."""

    def copy(self, text: str) -> None:
        """Put a text on the clipboard."""

    def copy_selection(self) -> bool:
        """Copy what is selected; False when nothing is."""

    @property
    def screens(self) -> Sequence[Screen[Any]]:
        """The main screen and the dialogs over it."""

    @property
    def available_themes(self) -> Mapping[str, Theme]:
        """Textual's and ours, by name."""

    def picture(self) -> None:
        """Save the screen as SVG."""

    def action_command(self, name: str) -> None:
        """Run a command of the registry, or say why it cannot run."""

    def action_suspend_process(self) -> None:
        """Suspend to the shell."""

    def leave(self) -> None:
        """End the console, when every command that was given has its answer."""


def write_file(console: Console, text: str, what: str) -> Callable[[Path], Awaitable[str]]:
    """What a file dialog does to save a text: asks before it replaces a file, and says `what`."""
    warned: set[Path] = set()  # existing files that the operator was warned about

    async def write(path: Path) -> str:
        if path not in warned and await in_daemon(os.path.exists, path):
            warned.add(path)
            return f"{path} already exists: press enter again to overwrite"
        try:
            await in_daemon(save_load.write, path, text)
        except ArchoError as error:
            return str(error)
        console.station.robot.note("YOU", "console", f"{what}: saved to {path}")
        console.say(f"Saved to {path}.")
        return ""

    return write


class Command:
    """One thing the operator can do."""

    id: str
    key: str = ""  # Textual's name of the key, when the keymap names no other; empty: none
    help: str  # one sentence for `?`, the palette and docs/keys.md
    footer: str = ""  # one word; empty: not in the footer
    footer_key: str = ""  # the key in the footer where it stands for several
    where: str = NOT_TYPING
    panel: int = 0  # the panel's number, for IN_PANEL
    runs_blocked: bool = False  # says why, and does its harmless part all the same
    insists: bool = False  # tried in any case: what is in the way may be over
    once: bool = False  # a held key gives it once; not again before the answer
    every: float = 0.0  # s until it is sent again while there is no answer
    verbs: tuple[str, ...] = ()  # that it speaks
    yields: bool = False  # its key is newer than 0.1.0: a robot file or a keymap may take it
    from_file: str = ""  # file and line of the robot file that it comes from

    @property
    def place(self) -> str:
        """Where the key works, in words."""
        return f"in {_PANELS[self.panel]}" if self.where == IN_PANEL else self.where

    def blocked(self, console: Console) -> str:
        """Why the command cannot run now, or an empty string."""
        return ""

    def run(self, console: Console) -> Work | None:
        """Do it or ask at once, or return a coroutine that may wait for the robot."""
        raise NotImplementedError


class Speak(Command):
    """A verb with a key."""

    def __init__(self, verb: Verb) -> None:
        self.verb = verb
        self.id, self.verbs = verb.id, (verb.id,)
        self.help = verb.help

    def blocked(self, console: Console) -> str:
        return self.verb.refusal(console.station)

    def run(self, console: Console) -> Work | None:
        return console.speak(self.verb, {})
