"""The base of commands, and the part of the app that they use."""

from __future__ import annotations

import os.path
import re
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from textual.screen import Screen
from textual.theme import Theme

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.parameters import save_load
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot_file.model import RobotFile
from archo_tui.screens.main import MainScreen
from archo_tui.station.station import Station
from archo_tui.terminal.stop_marks import InputTime
from archo_tui.verbs.verb import Question, Values, Verb
from archo_tui.widgets.screen_state import ScreenState

if TYPE_CHECKING:
    from archo_tui.recordings.replay.player import Player

Work = Coroutine[Any, Any, None]  # May wait for the robot.
Answers = Mapping[str, Callable[[], Work | None]]  # What each answer does, by its words.
EVERYWHERE, NOT_TYPING, IN_PANEL = "everywhere", "not while typing", "in the panel"
_AGREE_AFTER = 0.7  # Seconds: a key that is held down agrees to nothing.
PARAMETERS, NODES, EVENTS, GRAPH, TIME = 4, 5, 6, 8, 9
_PANELS = {  # The panels with commands of their own.
    PARAMETERS: "Parameters",
    NODES: "Nodes",
    EVENTS: "Events",
    GRAPH: "Graph",
    TIME: "the time line",
}


class Console(Protocol):
    """The app, as far as commands use it. Event loop only."""

    station: Station
    verbs: Mapping[str, Verb]
    view: ScreenState  # Shown now.
    theme: str  # Setting it changes the colours.
    typed: dict[str, dict[str, str]]  # The last texts, by form and by the path of the field.
    used: RobotFile  # With the other goals and services that were used besides.

    @property
    def main(self) -> MainScreen:
        """The main screen beneath the dialogs; in a replay that of the recording."""

    @property
    def repeated(self) -> bool:
        """True if the key that is being handled is held down, and so came before."""

    @property
    def input(self) -> InputTime | None:
        """The time of the present key or click, and the pause before it, in s; None for neither."""

    @property
    def registry(self) -> Sequence[Command]:
        """All commands."""

    @property
    def screen(self) -> Screen[Any]:
        """The screen in front: a dialog, or the main screen."""

    @property
    def is_stuck(self) -> bool:
        """True while the terminal has not read what was drawn last."""

    def disabled_reason(self, command: Command) -> str:
        """Return why a command cannot run now, or ""."""

    def update_screen(self) -> None:
        """Show the station's present state at once, not only with the next message of the robot."""

    def open(self, dialog: Screen[Any]) -> None:
        """Show a dialog, to which the following keys go.

        A dialog that a STOP closes is not shown, which is said, if a STOP was read since the key.
        """

    def begin_replay(self, player: Player) -> None:
        """Show a recording over the live console; keys act on it from then on, except STOP."""

    def end_replay(self) -> None:
        """Close the replay, if there is one, with its dialogs, and show the live console again."""

    def opening(self) -> AbstractContextManager[None]:
        """Return a context in which keys wait for a dialog, except those that work everywhere."""

    def run_verb(self, verb: Verb, values: Values) -> Work | None:
        """Return a coroutine that runs a verb, or show the verb's question and return None.

        The verb is not checked for a refusal first. A failure is shown.
        """

    def confirm(self, title: str, question: str, safe: str, answers: Answers) -> None:
        """Show a question at once; the following keys answer it, and a coroutine is run.

        While another one is open, or if a STOP was read since the key, a message says that nothing
        is asked.
        """

    def report_failure(self, outcome: Outcome) -> None:
        """Show the outcome of a command that failed; do nothing for one that succeeded."""

    def drop_following_keys(self, why: str) -> None:
        """Drop the keys that follow at once: they were typed for a dialog that closed by itself."""

    def show_message(self, text: str, title: str = "") -> None:
        """Show a notification, as `title: text`."""

    def copy(self, text: str) -> None:
        """Put a text on the clipboard of the terminal."""

    def copy_selection(self) -> bool:
        """Copy the text selected in a field or on the screen; return False if none is selected."""

    @property
    def screens(self) -> Sequence[Screen[Any]]:
        """All screens, from the main screen to the one in front."""

    @property
    def available_themes(self) -> Mapping[str, Theme]:
        """All themes by name."""

    def write_screenshot(self) -> None:
        """Save the screen as SVG, once the palette that asked for it has gone."""

    def action_command(self, name: str) -> None:
        """Run a command by its id, or show why it cannot run.

        One that still waits for its answer does not run again; an unknown id does nothing.
        """

    def action_suspend_process(self) -> None:
        """Suspend the console's process until the shell continues it, as ctrl+z does."""

    def leave(self) -> None:
        """End the console when every command has its answer, after 30 s at the latest.

        In a replay inside of a live console, only the replay ends.
        """


def file_writer(
    console: Console, text: str | Callable[[], Awaitable[str]], what: str
) -> Callable[[Path], Awaitable[str]]:
    """Return a function that writes a text to a path, for a file dialog, and names it `what`.

    It returns "" if the file was written, else an error, or a warning that the file exists: called
    again with that path, it replaces the file. An ArchoError of `text` is shown.
    """
    warned: set[Path] = set()  # Existing files that the operator was warned about.

    async def write(path: Path) -> str:
        if path not in warned and await in_daemon(os.path.exists, path):
            warned.add(path)
            return f"{path} already exists: press enter again to overwrite"
        try:
            content = text if isinstance(text, str) else await text()
            await in_daemon(save_load.write_atomically, path, content)
        except ArchoError as error:
            return str(error)
        console.station.robot.note("YOU", "console", f"{what}: saved to {path}")
        console.show_message(f"Saved to {path}.")
        return ""

    return write


class Command:
    """An action of the operator with a key, a word in the footer, or a line in the palette."""

    id: str  # Unique, as in keymaps.
    key: str = ""  # Textual's name of the default key.
    help: str  # One sentence for `?`, the palette and docs/keys.md.
    footer: str = ""
    footer_key: str = ""  # Shown if it stands for several commands, as `1-8`.
    where: str = NOT_TYPING  # EVERYWHERE, NOT_TYPING or IN_PANEL.
    panel: int = 0  # For IN_PANEL.
    runs_disabled: bool = False  # Run after the reason was shown; not if watching.
    always_tried: bool = False  # Run although the last snapshot disables it; not if watching.
    waits_for_answer: bool = False  # Not run before its answer, or for a held key.
    resend_after: float = 0.0  # Seconds until a held key runs it again.
    verbs: tuple[str, ...] = ()  # Those that it runs, or that print what it shows.
    gives_way: bool = False  # A robot file or a keymap may take its key.
    from_file: str = ""  # `FILE:LINE` of the robot file that defines it.

    @property
    def where_text(self) -> str:
        """The place where the key works, in words: `in Nodes`, `not while typing`, `everywhere`."""
        return f"in {_PANELS[self.panel]}" if self.where == IN_PANEL else self.where

    @property
    def title(self) -> str:
        """The help up to the first `:` or `;`, with a capital, as a title in lists."""
        words = re.split("[:;]", self.help)[0]
        return f"{words[0].upper()}{words[1:]}"

    def disabled_reason(self, console: Console) -> str:
        """Return why the command cannot run now, or "" if it can, as by default."""
        return ""

    def run(self, console: Console) -> Work | None:
        """Act at once, or return a coroutine if the robot or a disk must be waited for."""
        raise NotImplementedError


def asking_first(
    console: Console,
    ask: Callable[[Mapping[str, Any]], Question | None],
    send: Callable[[Mapping[str, Any]], Awaitable[Outcome]],
) -> Callable[[Mapping[str, Any]], Awaitable[Outcome]]:
    """Return the `send` of a form, which at first returns what `ask` asks, if anything.

    Called again with the same values, it sends; not before _AGREE_AFTER seconds: a key may be held
    down.
    """
    asked: tuple[float, Mapping[str, Any]] | None = None

    async def ask_or_send(values: Mapping[str, Any]) -> Outcome:
        nonlocal asked
        question, now = ask(values), console.station.clock.monotonic()
        is_same = asked is not None and asked[1] == values
        if question is not None and (asked is None or not is_same or now - asked[0] < _AGREE_AFTER):
            asked = asked if is_same else (now, values)
            return Outcome(Code.REFUSED, f"{question.text} Then send it again.")
        return await send(values)

    return ask_or_send


class VerbCommand(Command):
    """The base of commands that run a verb, by default without values."""

    def __init__(self, verb: Verb) -> None:
        self.verb = verb
        self.id, self.verbs = verb.id, (verb.id,)
        self.help = verb.help

    def disabled_reason(self, console: Console) -> str:
        return self.verb.refusal(console.station)

    def run(self, console: Console) -> Work | None:
        return console.run_verb(self.verb, {})
