"""The base of commands, and the desks that they act on."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from textual.content import Content
from textual.keys import format_key
from textual.notifications import SeverityLevel
from textual.screen import Screen
from textual.widgets import Input

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.robot.outcome import WATCHING, Code, Outcome
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.robot_file.model import RobotFile
from archo_tui.screen.dialog import Confirm, Dialog
from archo_tui.screen.main import PANELS, MainScreen
from archo_tui.screen.terminal.app import COMMANDS, TerminalApp, start_worker
from archo_tui.screen.widgets.bars import DURATIONS, FooterKey, Notice, with_newest
from archo_tui.screen.widgets.panel import Panel, ScreenState
from archo_tui.station import save_load
from archo_tui.station.station import Station
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import GOAL_ENDED, Question, Values, Verb

Work = Coroutine[Any, Any, None]  # May wait for the robot.
Answers = Mapping[str, Callable[[], Work | None]]  # What each answer does, by its words.
EVERYWHERE, NOT_TYPING, IN_PANEL = "everywhere", "not while typing", "in the panel"
LONGEST = 30.0  # Seconds that the end waits for answers: longer than any request takes.
_AGREE_AFTER = 0.7  # Seconds: a key that is held down agrees to nothing.


def readable_key(key: str) -> str:
    """Return a key as a person reads it: `^x` for `ctrl+x`, `?`, `enter`; "" for none."""
    return key if key in ("", "enter") else format_key(key).replace("ctrl+", "^")


class InputTime(NamedTuple):
    """The earliest time at which a key or a click can have been typed."""

    at: float  # s, on the clock of `Message.time`
    pause: float  # s since the input before was read


class _Sent(NamedTuple):
    at: float  # Monotonic time, in s.
    stops: int  # The count of STOPs read by then.


class Desk(TerminalApp):
    """The app, as far as commands use it: a station on the screen. Event loop only."""

    main: MainScreen  # Beneath the dialogs.
    view: ScreenState  # Shown now.
    repeated = False  # True while the key that is being handled is held down.
    # The time of the present key or click, and the pause before it, in s; None for neither.
    input: InputTime | None = None
    _leaves = False
    _opening = 0  # The number of dialogs that are being opened.
    _shut_since: float | None = None  # When a STOP closed the dialog that keys were for.
    _shut_said = False  # True once a message told of dropped keys.
    _shut_by = ""  # What closed it.
    _answers_void = 0  # Keys with a lower count were for a question that is not shown.

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
        self._sent: dict[str, _Sent] = {}  # Each command without an answer, by its id.
        self._notices: list[Notice] = []  # The newest first.
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
    def _dialogs(self) -> Iterator[Dialog]:
        """Yield the dialogs over the main screen."""
        yield from (screen for screen in self.screen_stack if isinstance(screen, Dialog))

    def notify(
        self,
        message: str,
        *,
        title: str = "",
        severity: SeverityLevel = "information",
        timeout: float | None = None,  # Seconds; None means that of its severity.
        markup: bool = True,
        still_holds: Callable[[], object] = lambda: True,  # A refusal goes with its cause.
    ) -> None:
        """Show a message in the second row, without markup, in place of Textual's box."""
        text = Content.from_markup(message).plain if markup else message
        text = " ".join(f"{title}: {text}".split() if title else text.split())
        until = self.station.clock.monotonic() + (timeout or DURATIONS[severity])
        self._notices = with_newest(self._notices, Notice(text, severity, until, still_holds))
        self._show_notices()

    def clear_notifications(self) -> None:
        self._notices = []
        self._show_notices()

    def _show_notices(self) -> None:
        time = self.station.clock.monotonic()
        self._notices = [n for n in self._notices if time < n.until and n.still_holds()]
        if self.main.is_mounted:
            self.main.show_notices(self._notices)

    def show_message(self, text: str, title: str = "") -> None:
        """Show a message in the second row, as `title: text`; its text is taken as it is."""
        self.notify(text, title=title, markup=False)

    def _find_command(self, name: str) -> Command | None:
        return next((command for command in self.registry if command.id == name), None)

    def action_command(self, name: str, counted: bool = False) -> None:
        """Run a command by its id, or show why it cannot run; nothing for an unknown id.

        One that still waits for its answer does not run again. `counted` is True if the STOP was
        counted as its key was read.
        """
        command, number = self._find_command(name), 0
        if command is None:
            return
        if name == "stop":
            number = self.stops.count_when_typed if counted else self.stops.register()
            self.close_questions()
        work = self._run_command(command)
        if work is not None:
            self.run_worker(self._await_command(name, work), group=COMMANDS)
        elif name == "stop":
            self.stops.is_not_sent(number)

    def _run_command(self, command: Command) -> Work | None:
        """Run a command, and return what is to be awaited, if anything; or show why it cannot."""
        name = command.id
        if command.waits_for_answer and (self.repeated or self._waits(name)):
            return None
        given = self._sent.get(name)
        held = (
            given is not None and self.station.clock.monotonic() - given.at < command.resend_after
        )
        # A key that is pressed again runs again: something may have happened in between.
        if held and self.repeated and not (command.always_tried and self.stops.superseded):
            return None
        reason = command.disabled_reason(self)
        if reason:
            if not command.always_tried or reason == WATCHING:
                holds = partial(command.disabled_reason, self)
                self.notify(reason, severity="warning", markup=False, still_holds=holds)
            if reason == WATCHING or not (command.runs_disabled or command.always_tried):
                return None
        return command.run(self)  # At once: the next key may be for what this one focuses.

    def close_questions(self) -> None:
        """Close the dialogs that a STOP makes invalid, and drop the keys typed for them."""
        for screen in self.screen_stack:
            if isinstance(screen, Dialog) and screen.closes_at_stop:
                screen.dismiss()
                self.closed_by_stop("STOP closed the dialog")

    def _waits(self, name: str) -> bool:
        """Return True, with a message, if a command waits for an answer that no STOP voided."""
        given = self._sent.get(name)
        waits = given is not None and not self.stops.is_void(given.stops)
        if waits and not self.repeated:
            self.notify("still waiting for the robot's answer", severity="warning", markup=False)
        return waits

    async def _await_command(self, name: str, work: Work) -> None:
        sent = self._sent[name] = _Sent(self.station.clock.monotonic(), self.stops.count_when_typed)
        try:
            await work
        finally:
            if self._sent.get(name) is sent:
                del self._sent[name]

    def run_verb(self, verb: Verb, values: Values) -> Work | None:
        """Return a coroutine that runs a verb, or show the verb's question and return None.

        The verb is not checked for a refusal first. A failure is shown.
        """

        async def now() -> None:
            outcome = await verb.run(self.station, values)
            self.update_screen()
            if verb.id != "stop" or self.view.snapshot.open_stop is None:  # Else the banner does.
                self.report_failure(outcome)

        question = verb.question(self.station, values)
        if question is None:
            return now()
        answers: Answers = {question.go: now} if question.go else {}
        self.confirm(question.title, question.text, question.safe, answers, question.is_over)
        return None

    def open(self, dialog: Screen[Any]) -> None:
        """Show a dialog, or a message if a STOP read since the key would have closed the dialog."""
        closes = isinstance(dialog, Dialog) and dialog.closes_at_stop
        if not (closes and self._is_void(str(dialog.title or "a dialog"))):
            self.show_dialog(dialog)

    @contextmanager
    def opening(self) -> Iterator[None]:
        """Return a context in which keys wait for a dialog, except those that work everywhere."""
        self._opening += 1
        try:
            yield
        finally:
            self._opening -= 1  # The end of the worker hands the keys on.

    def _is_void(self, title: str) -> bool:
        """Return True if a STOP was read after the current input, so that its dialog must not open.

        If so, a message and an event say so, and the keys that follow at once are dropped.
        """
        shut = self.stops.gate().is_shut
        if shut:
            self.closed_by_stop("STOP kept the dialog from opening")
            self.station.robot.note("YOU", "console", f"{title.lower()}: {NOT_SENT}")
            self.report_failure(Outcome(Code.CANCELLED, NOT_SENT))
        return shut

    def confirm(
        self,
        title: str,
        question: str,
        safe: str,
        answers: Answers,
        is_over: Callable[[Goal | None], bool] = lambda _: False,
    ) -> None:
        """Show a question at once, whose answer may be a coroutine to run; or why it is not asked.

        It is not while another one is open, or if a STOP was read since the key. It closes, with a
        message, once the goal that it is about has ended: `is_over`.
        """
        if isinstance(self.screen, Confirm):
            said = f"{title}: answer the question that is asked already first."
            self.notify(said, severity="warning", markup=False)
            return
        if self._is_void(title):
            return
        # The answer counts from here too: a STOP in between closes the question.
        typed = self.stops.count_when_typed

        def answered(answer: str) -> None:
            act = answers.get(answer)
            with self.stops.typed_at(typed):
                work = None if act is None else act()
                if work is not None:
                    self.run_worker(work, group=COMMANDS)

        def close_if_over() -> bool:
            over = is_over(self.station.running_goal)
            if over:
                self.drop_following_keys("The question closed")
                self.report_failure(Outcome(Code.REFUSED, f"{title}: {GOAL_ENDED}"))
            return over

        self.show_dialog(Confirm(title, question, (safe, *answers), answered, close_if_over))

    def report_failure(self, outcome: Outcome) -> None:
        """Show the outcome of a command that failed; do nothing for one that succeeded."""
        if not outcome.ok:
            self.notify(outcome.text, severity="error", markup=False)

    def copy_selection(self) -> bool:
        """Copy the text selected in a field or on the screen; return False if none is selected."""
        focused = self.focused
        text = focused.selected_text if isinstance(focused, Input) else None
        text = text or self.screen.get_selected_text()
        if text:
            self.copy_to_clipboard(text)
        return bool(text)

    @property
    def is_ending(self) -> bool:
        """True once the end has begun, also by a key."""
        return self._leaves or super().is_ending

    def leave(self) -> None:
        """Begin to end the app when every command has its answer, in 30 s at most."""
        if not self._leaves:
            self._leaves = True
            start_worker(self, self._exit_when_answered, "leave")

    async def _exit_when_answered(self) -> None:
        """End the app once every command has its answer, or LONGEST seconds have passed."""
        if self.unanswered:
            self.show_message("Ending, as soon as the robot has answered.")
        try:
            await self.station.clock.wait_for(self.wait_for_answers(), LONGEST)
        except TimeoutError:  # A disk hangs; requests to a robot end by themselves.
            self.station.robot.note("ERROR", "console", f"ended: not all answered in {LONGEST:g} s")
        self.exit()

    def closed_by_stop(self, why: str) -> None:
        """Drop the keys typed for a dialog that a STOP closed, or kept from opening.

        Those are the keys read before that STOP, and those that follow at once; not those that work
        everywhere. `why` is shown if a key is dropped.
        """
        self._answers_void = self.stops.count
        self.drop_following_keys(why)

    def drop_following_keys(self, why: str) -> None:
        """Drop the keys that follow at once, typed for a dialog that closed by itself.

        Keys follow at once if less than HELD passes between them. Escape and those that work
        everywhere still act. `why` is shown if a key is dropped.
        """
        self._shut_by, self._shut_said = why, False
        self._shut_since = self.station.clock.monotonic()

    def show_dialog(self, dialog: Screen[Any]) -> None:
        """Show a dialog, to which all following keys go; none is dropped any more."""
        self._shut_since = None
        self.push_screen(dialog)


def file_writer(
    desk: Desk, text: str | Callable[[], Awaitable[str]], what: str
) -> Callable[[Path], Awaitable[str]]:
    """Return a function that writes a text to a path, for a file dialog, and names it `what`.

    It returns "" if the file was written, else an error, also one of `text`.
    """

    async def write(path: Path) -> str:
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
    in_replay: bool = False  # It changes nothing of a robot, so a replay has it, too.
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

    Called again with the same values, about the same goal, it sends; not before _AGREE_AFTER
    seconds: a key may be held down.
    """
    asked: tuple[float, Mapping[str, Any], Question] | None = None

    async def ask_or_send(values: Mapping[str, Any]) -> Outcome:
        nonlocal asked
        question, now = ask(values), desk.station.clock.monotonic()
        if question is None:
            return await send(values)
        is_same = (
            asked is not None
            and asked[1] == values
            and (asked[2].goal is None) == (question.goal is None)
            and not asked[2].is_over(desk.station.running_goal)
        )
        if asked is None or not is_same:
            asked = now, values, question
        elif now - asked[0] >= _AGREE_AFTER:
            return await send(values)
        return Outcome(Code.REFUSED, f"{question.text} Then send it again.")

    return ask_or_send


class VerbCommand(Command):
    """The base of commands that run a verb, by default without values."""

    def __init__(
        self, verb: Verb, values: Callable[[Station], Values] = lambda _: {}, **others: Any
    ) -> None:
        """Create the command; `others` are its attributes, in place of the verb's id and help."""
        self.verb, self._values = verb, values
        self.id, self.verbs = verb.id, (verb.id,)
        self.help = verb.help
        vars(self).update(others)

    def disabled_reason(self, desk: Desk) -> str:
        return self.verb.refusal(desk.station)

    def run(self, desk: Desk) -> Work | None:
        return desk.run_verb(self.verb, self._values(desk.station))


def everywhere(command: Command, id: str, key: str, help: str) -> Command:
    """Return a command with another key that works everywhere; it has no place in the footer."""
    second = copy(command)
    second.id, second.key, second.help, second.footer = id, key, help, ""
    second.where = EVERYWHERE
    return second


class PanelKey(Command):
    in_replay = True

    def __init__(self, panel: type[Panel], robot: RobotFile) -> None:
        self._number, self.key = panel.number, str(panel.number)
        self.id = f"panel_{panel.number}"
        self.help = f"Go to panel {panel.number}, {panel.title_for(robot)}"
        self.verbs, self.gives_way = tuple(panel.verbs), panel.gives_way
        if panel is PANELS[0]:
            self.footer, self.footer_key = "Panels", f"1-{len(PANELS)}"

    def run(self, desk: Desk) -> None:
        desk.main.focus_panel(self._number)
