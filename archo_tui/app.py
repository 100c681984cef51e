"""The Textual app, which shows the station on the screen and runs commands."""

from __future__ import annotations

import sys
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from textual.content import Content
from textual.notifications import SeverityLevel
from textual.screen import Screen
from textual.widgets import Input

from archo_tui.commands import registry
from archo_tui.commands.base import Answers, Command, Work
from archo_tui.daemon_threads import in_daemon
from archo_tui.keyed_app import KeyedApp
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import WATCHING, Code, Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.screens.base import Dismissable
from archo_tui.screens.dialog import Confirm, ShowText
from archo_tui.screens.main import MainScreen
from archo_tui.shutdown import RESTART
from archo_tui.station import form_history
from archo_tui.station.station import Station
from archo_tui.terminal.app import COMMANDS, start_worker
from archo_tui.terminal.stop_marks import now
from archo_tui.user_code.output import NodeOutput
from archo_tui.verbs.goals import GOALS
from archo_tui.verbs.verb import Values, Verb
from archo_tui.widgets.bars import DURATIONS, Notice, NoticeLine, with_newest

if TYPE_CHECKING:
    from archo_tui.recordings.replay.player import Player

TICK = 1.0  # Seconds between two updates of ages and the time of day.
LONGEST = 30.0  # Seconds that the end waits for answers: longer than any request takes.


class _Sent(NamedTuple):
    at: float  # Monotonic time, in s.
    stops: int  # The count of STOPs read by then.


class ArchoApp(KeyedApp):
    """The operator's console: the main screen, its dialogs, and the commands that keys run."""

    CSS_PATH = "screens/style.tcss"

    def __init__(
        self,
        station: Station,
        keys: Mapping[str, str] | None = None,  # By the command's id; None means the default ones.
        theme: str = "",  # "" means the one that suits the terminal.
        failed: str = "",  # The traceback that ended the screen before this one; it is shown.
        player: Player | None = None,  # Of a station that is recorded: the screen acts on no robot.
    ) -> None:
        super().__init__(station, theme)
        snapshot = station.robot.snapshot
        self.title = snapshot.file.name
        self._player, self._failed_before = player, failed
        self._leaves = False
        self._notices: list[Notice] = []  # The newest first.
        self._shown_notices: list[Notice] = []
        self._sent: dict[str, _Sent] = {}  # Each command without an answer, by its id.
        commands: Callable[[Mapping[str, Verb]], Sequence[Command]]
        if player is None:
            commands = partial(registry, snapshot.file)
            in_field = not station.robot.watching
            main = MainScreen(snapshot, self.size, starts_in_field=in_field)
        else:
            from archo_tui.commands.replay import TimeLine, replay_commands

            commands = partial(replay_commands, player)
            main = MainScreen(snapshot, self.size, TimeLine(snapshot, player))
        self.set_up(commands, keys or {}, main)
        main.goal.send = self._send_goals
        self.stop_key = self.keys["stop"]
        self.bind_commands()

    def get_default_screen(self) -> Screen[None]:
        return self.main

    def on_mount(self) -> None:
        # Inside of Textual's redirection, which captures all that is printed.
        sys.stdout = NodeOutput(sys.stdout, self.station.robot.note)
        self.station.attach(self)
        self.station.robot.subscribe(self._on_snapshot)
        start_worker(self, self._recall, "recall")
        start_worker(self, self._tick_for_ever, "tick")
        if self._player is not None:
            start_worker(self, partial(self._player.follow, self.update_screen), "play")
        if self._failed_before:
            said = "The screen crashed and was restarted; the nodes kept running."
            text = f"{said}\n\n{self._failed_before}"
            self.push_screen(ShowText("An error of the console", text))
            self.drop_following_keys("The screen crashed")

    def on_unmount(self) -> None:
        self.station.detach()

    def on_resize(self) -> None:
        self.call_after_refresh(self.tick)

    def _on_snapshot(self, snapshot: Snapshot) -> None:
        self.station.on_snapshot(snapshot)
        try:
            self.show_view()
        except Exception as error:  # Called by the event loop, outside of Textual's error handling.
            self._handle_exception(error)

    async def _tick_for_ever(self) -> None:
        while True:
            clock = self.station.clock
            # On the second, so that the clock skips none.
            await clock.sleep(TICK - clock.now() % TICK)
            self.tick()

    def tick(self) -> None:
        """Tick the station and show the new view; called on each full second."""
        self.station.tick()
        self.show_view()

    def show_view(self) -> None:
        super().show_view()
        if self.is_shown:
            self._show_notices()
            self.ring(self.view.alarms)

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
        time, before = self.station.clock.monotonic(), self._shown_notices
        self._notices = [n for n in self._notices if time < n.until and n.still_holds()]
        self._shown_notices = [*self._notices]
        if not {*before} <= {*self._notices}:
            for line in self.screen.query(NoticeLine):
                self._gone_notice = line.region, now()
        if self.main.is_mounted:
            self.main.show_notices(self._shown_notices)

    def action_command(self, name: str, counted: bool = False) -> None:
        command, number = self._find_command(name), 0
        if command is None:
            return
        if name == "stop":
            number = self.stops.count_when_typed if counted else self.stops.register()
            self.close_questions()
        work = self._work_of(command)
        if work is not None:
            self.run_worker(self._await_command(name, work), group=COMMANDS)
        elif name == "stop":
            self.stops.is_not_sent(number)

    def _work_of(self, command: Command) -> Work | None:
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
            if isinstance(screen, Dismissable) and screen.closes_at_stop:
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

    def action_command_palette(self) -> None:
        self.action_command("palette")

    # What commands use.

    def run_verb(self, verb: Verb, values: Values) -> Work | None:
        async def now() -> None:
            outcome = await verb.run(self.station, values)
            self.update_screen()
            is_in_banner = verb.id == "stop" and self.view.snapshot.open_stop is not None
            if not is_in_banner:
                self.report_failure(outcome)

        question = verb.question(self.station, values)
        if question is None:
            return now()
        answers: Answers = {question.go: now} if question.go else {}
        self.confirm(question.title, question.text, question.safe, answers)
        return None

    def open(self, dialog: Screen[Any]) -> None:
        closes = isinstance(dialog, Dismissable) and dialog.closes_at_stop
        if not (closes and self._is_void(str(dialog.title or "a dialog"))):
            self.show_dialog(dialog)

    @contextmanager
    def opening(self) -> Iterator[None]:
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

    def confirm(self, title: str, question: str, safe: str, answers: Answers) -> None:
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

        self.show_dialog(Confirm(title, question, (safe, *answers), answered))

    def report_failure(self, outcome: Outcome) -> None:
        if not outcome.ok:
            self.notify(outcome.text, severity="error", markup=False)

    def copy_selection(self) -> bool:
        focused = self.focused
        text = focused.selected_text if isinstance(focused, Input) else None
        text = text or self.screen.get_selected_text()
        if text:
            self.copy_to_clipboard(text)
        return bool(text)

    def leave(self) -> None:
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

    # What the panels call.

    def on_main_screen_broken(self, message: MainScreen.Broken) -> None:
        if self._player is not None:  # A replay has no events for it.
            self.notify(message.text, severity="error", markup=False)
            return
        self.station.robot.note("ERROR", "console", message.text)

    def _send_goals(self, goals: Sequence[Mapping[str, Any]], typed: list[str]) -> None:
        self._remember_typed(typed)
        go, values = self.verbs["go"], {GOALS: goals}

        def send() -> Callable[[], Work]:
            answer = go.run(self.station, values)
            self.show_view()
            return partial(self._show_refusal, answer)

        question = go.question(self.station, values)
        if question is None:
            start_worker(self, send(), COMMANDS)
        else:
            answers: Answers = {question.go: lambda: send()()}
            self.confirm(question.title, question.text, question.safe, answers)

    async def _show_refusal(self, answer: Awaitable[Outcome]) -> None:
        """Wait for the answer to a goal, and show or remove a refusal in the goal's form."""
        outcome = await answer
        self.main.goal.show_refusal("" if outcome.ok else outcome.text)

    def _remember_typed(self, typed: list[str]) -> None:
        """Offer to the arrow keys what was typed into the goal's form, also after a restart."""
        kind, panel = self.view.snapshot.file.goals[0], self.main.goal
        others = [old for old in panel.typed if old != typed]
        panel.set_typed([*others, typed][-form_history.MAX_ENTRIES :])
        start_worker(self, partial(in_daemon, form_history.add, kind.id, typed), COMMANDS)

    async def _recall(self) -> None:
        goals = self.view.snapshot.file.goals
        if goals:
            before = await in_daemon(form_history.load, goals[0].id)
            since = self.main.goal.typed  # Sent while a slow disk was read; it comes last.
            earlier = [old for old in before if old not in since]
            self.main.goal.set_typed([*earlier, *since][-form_history.MAX_ENTRIES :])

    # The methods of the station's Frontend.

    @property
    def has_person(self) -> bool:
        """Return True while the screen runs: a person is taken to look at it."""
        return self.is_running

    def carry_out(self, work: Callable[[], Work]) -> None:
        """Begin work as a command, whose answer `leave` waits for."""
        start_worker(self, work, COMMANDS)

    def run_in_background(self, work: Callable[[], Work]) -> None:
        """Begin work of another program, for whose answer `leave` does not wait."""
        start_worker(self, work, "beside")

    def restart(self, why: str) -> None:
        """End the process and start it again with the same options, with an event that says why.

        While a STOP is not released, the restart waits for a key instead. Any thread, once mounted.
        """
        self._main_loop.call_soon_threadsafe(self._restart, why)

    def _restart(self, why: str) -> None:
        station = self.station
        if station.restart_blocker:
            self._let_restart_wait(why)
            return
        what = "the console restarts" if station.attached else "all nodes restart"
        station.robot.note("YOU", "console", f"{why}: {what}")
        station.waiting_restart, station.is_restarting = why, True
        self._ending.begin(RESTART)
        self.update_screen()

    def _let_restart_wait(self, why: str) -> None:
        station, key = self.station, self.shown_keys["restart"] or "the palette"
        text = f"the restart waits: release the STOP, then press {key} in Nodes"
        station.waiting_restart, station.is_restarting = why, False
        station.robot.note("WARN", "console", f"{why}: {text}")
        self.update_screen()

    def end(self, code: int) -> None:
        """Exit, unless a STOP came since a restart began, which then waits."""
        if code == RESTART and self.station.restart_blocker:
            self._ending.call_off()
            self._let_restart_wait(self.station.waiting_restart)
            return
        if code == RESTART:
            self.keep_keys()
            self.station.stops_before_restart = self.stops.count
        super().end(code)

    def on_goal_answered(self, wanted: QueuedGoal, outcome: Outcome) -> None:
        """Show in the goal's form why the robot refused a goal; clear that text if it did not."""
        self.main.goal.show_refusal("" if outcome.ok else outcome.text)
