"""The Textual app, which shows the station on the screen and runs commands."""

from __future__ import annotations

import sys
from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from textual.screen import Screen

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import Command, Work
from archo_tui.screen.dialog import ShowText
from archo_tui.screen.keyed_app import KeyedApp
from archo_tui.screen.main import MainScreen
from archo_tui.screen.terminal.app import COMMANDS, start_worker
from archo_tui.station.shutdown import RESTART
from archo_tui.station.station import Station
from archo_tui.user_code.output import NodeOutput
from archo_tui.verbs.goals import GOALS
from archo_tui.verbs.verb import Verb

if TYPE_CHECKING:
    from archo_tui.recordings.replay.player import Player

TICK = 1.0  # Seconds between two updates of ages and the time of day.


class ArchoApp(KeyedApp):
    """The operator's console: the main screen, its dialogs, and the commands that keys run."""

    CSS_PATH = "style.tcss"

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
        commands: Callable[[Mapping[str, Verb]], Sequence[Command]]
        if player is None:
            commands = partial(registry, snapshot.file)
            in_field = not station.robot.watching
            main = MainScreen(snapshot, self.size, starts_in_field=in_field)
        else:
            from archo_tui.screen.commands.replay import TimeLine, replay_commands

            commands = partial(replay_commands, player)
            main = MainScreen(snapshot, self.size, TimeLine(snapshot, player))
        self.set_up(commands, keys or {}, main)
        main.goal.send, main.on_broken = self._send_goals, self._tell_broken
        self.stop_key = self.keys["stop"]
        self.bind_commands()

    def get_default_screen(self) -> Screen[None]:
        return self.main

    def on_mount(self) -> None:
        # Inside of Textual's redirection, which captures all that is printed.
        sys.stdout = NodeOutput(sys.stdout, self.station.robot.note)
        self.station.attach(self)
        self.station.robot.subscribe(self._on_snapshot)
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

    def action_command_palette(self) -> None:
        self.action_command("palette")

    # What the panels call.

    def _tell_broken(self, text: str) -> None:
        if self._player is not None:  # A replay has no events for it.
            self.notify(text, severity="error", markup=False)
        else:
            self.station.robot.note("ERROR", "console", text)

    def _send_goals(self, goals: Sequence[Mapping[str, Any]]) -> None:
        go, values = self.verbs["go"], {GOALS: goals}

        def send() -> Work:
            answer = go.run(self.station, values)  # At once: goals keep their order.
            self.show_view()
            return self._show_refusal(answer)

        question = go.question(self.station, values)
        if question is None:
            self.run_worker(send(), group=COMMANDS)
        else:
            self.confirm(question.title, question.text, question.safe, {question.go: send})

    async def _show_refusal(self, answer: Awaitable[Outcome]) -> None:
        """Wait for the answer to a goal, and show or remove a refusal in the goal's form."""
        outcome = await answer
        self.main.goal.show_refusal("" if outcome.ok else outcome.text)

    # The methods of the station's Frontend.

    @property
    def has_person(self) -> bool:
        """Return True while the screen is shown: a person is taken to look at it."""
        return self.is_running and not (self.terminal is not None and self.terminal.is_lent)

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
