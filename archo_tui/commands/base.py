"""The base of commands, and the desks that they act on."""

from __future__ import annotations

import os.path
import re
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Any

from textual.keys import format_key
from textual.screen import Screen

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.parameters import save_load
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot_file.model import RobotFile
from archo_tui.screens.base import Dismissable
from archo_tui.screens.main import PANELS, MainScreen
from archo_tui.terminal.app import TerminalApp
from archo_tui.terminal.stop_marks import InputTime
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import Question, Values, Verb
from archo_tui.widgets.bars import FooterKey
from archo_tui.widgets.panel import Panel, ScreenState

Work = Coroutine[Any, Any, None]  # May wait for the robot.
Answers = Mapping[str, Callable[[], Work | None]]  # What each answer does, by its words.
EVERYWHERE, NOT_TYPING, IN_PANEL = "everywhere", "not while typing", "in the panel"
_AGREE_AFTER = 0.7  # Seconds: a key that is held down agrees to nothing.


def readable_key(key: str) -> str:
    """Return a key as a person reads it: `^x` for `ctrl+x`, `?`, `enter`; "" for none."""
    return key if key in ("", "enter") else format_key(key).replace("ctrl+", "^")


class Desk(TerminalApp):
    """The app, as far as commands use it: a station on the screen. Event loop only."""

    main: MainScreen  # Beneath the dialogs.
    view: ScreenState  # Shown now.
    repeated = False  # True while the key that is being handled is held down.
    # The time of the present key or click, and the pause before it, in s; None for neither.
    input: InputTime | None = None

    def set_up(
        self,
        commands: Callable[[Mapping[str, Verb]], Sequence[Command]],
        keys: Mapping[str, str],  # By the command's id; of the others, the default ones hold.
        main: MainScreen,
    ) -> None:
        """Make the commands of the station's robot; must be called before all else."""
        snapshot, self.main = self.station.robot.snapshot, main
        self.verbs: Mapping[str, Verb] = verbs(snapshot.file, snapshot.forms)
        self.registry = commands(self.verbs)
        self.keys = {c.id: keys.get(c.id, c.key) for c in self.registry}  # As Textual names them.
        # As people read them.
        self.shown_keys = {name: readable_key(key) for name, key in self.keys.items()}
        self._listed_keys = {c.id: self.shown_keys[c.id] for c in self.registry if c.is_listed}
        # The last texts, by form and by the path of the field.
        self.typed: dict[str, dict[str, str]] = {}
        self.view = self._state()

    def _state(self) -> ScreenState:
        return ScreenState(**vars(self.station.view), keys=self._listed_keys)

    def update_screen(self) -> None:
        """Show the station's present state at once, not only with the next message of the robot."""
        self.station.refresh()
        self.show_view()

    def show_view(self) -> None:
        """Show the station's view on the main screen, and in the dialogs over it."""
        self.view = self._state()
        if not self.is_shown:
            return
        self.view = replace(
            self.view, blocked=frozenset(c.id for c in self.registry if c.disabled_reason(self))
        )
        self.main.show(self.view, self._footer_keys())
        for dialog in self._dialogs:
            if dialog.is_mounted:
                dialog.update_view(self.view)

    @property
    def is_shown(self) -> bool:
        """True during the life of the main screen, also behind dialogs."""
        return self.is_running and self.main in self.screen_stack and self.main.is_mounted

    def _footer_keys(self) -> list[FooterKey]:
        """Return the commands with a footer word and a key, also disabled, in their order."""
        view = self.view
        keys = ((c, c.footer_key or view.key(c.id)) for c in self.registry if c.footer)
        return [
            FooterKey(c.id, key, c.footer, c.id in view.blocked, c.where == EVERYWHERE)
            for c, key in keys
            if key
        ]

    @property
    def _dialogs(self) -> Iterator[Dismissable[Any]]:
        """Yield the dialogs over the main screen."""
        yield from (screen for screen in self.screen_stack if isinstance(screen, Dismissable))

    def run_verb(self, verb: Verb, values: Values) -> Work | None:
        """Return a coroutine that runs a verb, or show the verb's question and return None.

        The verb is not checked for a refusal first. A failure is shown.
        """
        raise NotImplementedError

    def report_failure(self, outcome: Outcome) -> None:
        """Show the outcome of a command that failed; do nothing for one that succeeded."""
        raise NotImplementedError

    def show_message(self, text: str, title: str = "") -> None:
        """Show a message in the second row, as `title: text`; its text is taken as it is."""
        self.notify(text, title=title, markup=False)

    def open(self, dialog: Screen[Any]) -> None:
        """Show a dialog, or a message if a STOP read since the key would have closed the dialog."""
        raise NotImplementedError

    def confirm(self, title: str, question: str, safe: str, answers: Answers) -> None:
        """Show a question at once, whose answer may be a coroutine to run; or why it is not asked.

        It is not while another one is open, or if a STOP was read since the key.
        """
        raise NotImplementedError

    def opening(self) -> AbstractContextManager[None]:
        """Return a context in which keys wait for a dialog, except those that work everywhere."""
        raise NotImplementedError

    def drop_following_keys(self, why: str) -> None:
        """Drop the keys that follow at once: they were typed for a dialog that closed by itself."""
        raise NotImplementedError

    def copy_selection(self) -> bool:
        """Copy the text selected in a field or on the screen; return False if none is selected."""
        raise NotImplementedError

    def action_command(self, name: str, counted: bool = False) -> None:
        """Run a command by its id, or show why it cannot run; nothing for an unknown id.

        One that still waits for its answer does not run again. `counted` is True if the STOP was
        counted as its key was read.
        """
        raise NotImplementedError

    def leave(self) -> None:
        """Begin to end the app when every command has its answer, in 30 s at most."""
        raise NotImplementedError


def file_writer(
    desk: Desk, text: str | Callable[[], Awaitable[str]], what: str
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
        desk.station.robot.note("YOU", "console", f"{what}: saved to {path}")
        desk.show_message(f"Saved to {path}.")
        return ""

    return write


class Command:
    """An action of the operator with a key, a word in the footer, or a line in the palette."""

    id: str  # Unique, as in keymaps.
    key: str = ""  # Textual's name of the default key.
    help: str  # One sentence for `?`, the palette and docs/keys.md.
    footer: str = ""
    footer_key: str = ""  # Shown if it stands for several commands, as `←→`.
    where: str = NOT_TYPING  # EVERYWHERE, NOT_TYPING or IN_PANEL.
    panel: type[Panel] | None = None  # For IN_PANEL.
    runs_disabled: bool = False  # Run after the reason was shown; not if watching.
    always_tried: bool = False  # Run although the last snapshot disables it; not if watching.
    waits_for_answer: bool = False  # Not run before its answer, or for a held key.
    resend_after: float = 0.0  # Seconds until a held key runs it again.
    verbs: tuple[str, ...] = ()  # Those that it runs, or that print what it shows.
    is_listed: bool = True  # On the panels, in `?` and in the palette.
    gives_way: bool = False  # A robot file or a keymap may take its key.
    from_file: str = ""  # `FILE:LINE` of the robot file that defines it.

    @property
    def where_text(self) -> str:
        """The place where the key works, in words: `in Nodes`, `not while typing`, `everywhere`."""
        return self.where if self.panel is None else f"in {self.panel.title_text}"

    @property
    def title(self) -> str:
        """The help up to the first `:` or `;`, with a capital, as a title in lists."""
        words = re.split("[:;]", self.help)[0]
        return f"{words[0].upper()}{words[1:]}"

    def disabled_reason(self, desk: Desk) -> str:
        """Return why the command cannot run now, or "" if it can, as by default."""
        return ""

    def run(self, desk: Desk) -> Work | None:
        """Act at once, or return a coroutine if the robot or a disk must be waited for."""
        raise NotImplementedError


def asking_first(
    desk: Desk,
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
        question, now = ask(values), desk.station.clock.monotonic()
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

    def disabled_reason(self, desk: Desk) -> str:
        return self.verb.refusal(desk.station)

    def run(self, desk: Desk) -> Work | None:
        return desk.run_verb(self.verb, {})


class PanelKey(Command):
    def __init__(self, panel: type[Panel], robot: RobotFile) -> None:
        self._number, self.key = panel.number, str(panel.number)
        self.id = f"panel_{panel.number}"
        self.help = f"Go to panel {panel.number}, {panel.title_for(robot)}"
        self.verbs, self.gives_way = tuple(panel.verbs), panel.gives_way
        if panel is PANELS[0]:
            self.footer, self.footer_key = "Panels", f"1-{len(PANELS)}"

    def run(self, desk: Desk) -> None:
        desk.main.focus_panel(self._number)
