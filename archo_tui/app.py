"""The Textual app: takes snapshots from the Robot, shows views, runs commands."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Iterable
from typing import TYPE_CHECKING

from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.screen import Screen
from textual.widgets import Input

from archo_tui.alarms import AlarmBoard, conditions
from archo_tui.clock import Clock
from archo_tui.commands import COMMANDS, EVERYWHERE, Command
from archo_tui.robot.state import Outcome, Snapshot
from archo_tui.screens.confirm import Confirm
from archo_tui.screens.edit_parameter import EditParameter
from archo_tui.screens.main import MainScreen
from archo_tui.widgets.goal_panel import GoalPanel
from archo_tui.widgets.parameters_panel import ParametersPanel
from archo_tui.widgets.view import View

if TYPE_CHECKING:
    from archo_tui.session import Session

_CANCEL_WAIT = 2.5  # s that quitting waits for the goal's end


class ArchoApp(App[None]):
    """The operator's console."""

    TITLE = "ARCHO"
    CSS_PATH = ["screens/main.tcss", "screens/dialog.tcss"]
    # All have priority, so that a key acts before the next one is routed to whatever it focused:
    # over a slow line several arrive at once. check_action takes the letters back while typing.
    BINDINGS = [
        *(Binding(c.key, f"command('{c.id}')", c.help, id=c.id, priority=True) for c in COMMANDS),
        Binding("escape", "leave_field", "Out of the field", show=False, priority=True),
    ]

    def __init__(self, session: Session, clock: Clock | None = None) -> None:
        super().__init__()
        self.robot = session.robot
        self.registry = COMMANDS
        self._clock = clock or Clock()
        self._session = session
        self._alarms = AlarmBoard()
        self._snapshot = Snapshot()
        self._second = self._clock.monotonic()
        self.main = MainScreen()
        self.view = self._view()

    def get_default_screen(self) -> Screen[None]:
        return self.main

    def on_mount(self) -> None:
        if not self.is_headless:
            self._leave_on_signals()
        self.robot.subscribe(self._take)
        self.set_interval(1.0, self.tick)

    def on_resize(self) -> None:
        self.call_after_refresh(self.tick)

    def _take(self, snapshot: Snapshot) -> None:
        self._snapshot = snapshot
        self.show()

    def tick(self) -> None:
        """A second has passed: show ages and the time anew."""
        self._second = self._clock.monotonic()
        self.show()

    def show(self) -> None:
        """Show the newest snapshot at the time it is now."""
        found = conditions(self._snapshot, self._clock.monotonic())
        self._alarms.update(found, self._clock.monotonic(), self._clock.now())
        self.view = self._view()
        if self.is_running and self.main.is_mounted:  # neither before nor behind the screen's life
            footer = [
                (c.id, c.footer_key or c.shown_key, c.footer, bool(self.blocked(c)))
                for c in self.registry
                if c.footer
            ]
            self.main.show(self.view, footer)

    def _view(self) -> View:
        return View(
            self._snapshot,
            self._clock.monotonic(),
            self._second,
            self._clock.now(),
            self._session.engine,
            self._session.options.namespace,
            self._alarms.all(),
        )

    # commands

    def blocked(self, command: Command) -> str:
        """Why a command cannot run now, or an empty string."""
        return command.blocked(self)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """False leaves the key to the field or dialog that has the focus."""
        typing = isinstance(self.focused, Input)
        if action == "leave_field":
            return typing and self.screen is self.main
        if action != "command":
            return super().check_action(action, parameters)
        return (self.screen is self.main and not typing) or self._command(
            str(parameters[0])
        ).where == EVERYWHERE

    def _command(self, name: str) -> Command:
        return next(c for c in self.registry if c.id == name)

    def action_command(self, name: str) -> None:
        """Run a command of the registry, or say why it cannot run."""
        command = self._command(name)
        reason = self.blocked(command)
        if reason:
            self.notify(reason, severity="warning", markup=False)
            return
        work = command.run(self)  # at once: the next key may be for what this one focused
        if work is not None:
            self.run_worker(work, group=name)

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """The palette: the registry, and what Textual brings."""
        for command in self.registry:
            title = f"{command.help.partition(';')[0]} ({command.shown_key})"
            yield SystemCommand(
                title,
                self.blocked(command) or command.help,
                lambda name=command.id: self.action_command(name),
            )
        yield from (c for c in super().get_system_commands(screen) if c.title == "Theme")

    def tell(self, outcome: Outcome) -> None:
        """Say it when a command failed; what it did is seen on the screen."""
        if not outcome.ok:
            self.notify(outcome.text, severity="error", markup=False)

    async def ask(self, question: Confirm) -> str:
        """Put a question and wait for the answer, the safe one if another is being asked."""
        if isinstance(self.screen, Confirm):
            return question.safe
        return str(await self.push_screen_wait(question))  # type: ignore[arg-type]

    def acknowledge(self) -> None:
        """Acknowledge the alarm in the banner."""
        self._alarms.acknowledge()
        self.show()

    def copy_selection(self) -> bool:
        """Copy what is selected; False when nothing is."""
        focused = self.focused
        text = focused.selected_text if isinstance(focused, Input) else None
        text = text or self.screen.get_selected_text()
        if text:
            self.copy_to_clipboard(text)
        return bool(text)

    def action_leave_field(self) -> None:
        """Out of a field, to where the focus was."""
        self.main.focus_back()

    # what the panels ask for

    def on_goal_panel_send(self, message: GoalPanel.Send) -> None:
        self.run_worker(self._send(message.shelf), group="send")

    async def _send(self, shelf: int) -> None:
        outcome = await self.robot.go_to_shelf(shelf)
        if outcome.ok:
            self.main.goal.query_one(Input).clear()
        self.main.goal.hint("" if outcome.ok else outcome.text)

    def on_parameters_panel_edit(self, message: ParametersPanel.Edit) -> None:
        parameter = message.parameter
        self.push_screen(
            EditParameter(
                parameter,
                lambda value: self.robot.set_parameter(parameter.node, parameter.name, value),
            )
        )

    # the end

    async def leave(self) -> None:
        """Quit; with a goal running ask, cancel it, and wait for its end first."""
        goal = self.view.snapshot.goal
        if goal is not None and goal.is_running:
            question = f"The robot is on its way to shelf {goal.shelf}."
            answers = ["Stay", "Cancel it and quit"]
            if self._session.options.attach:
                answers.append("Leave it running and quit")
            answer = await self.ask(Confirm("Quit", question, *answers))
            if answer == "Cancel it and quit":
                outcome = await self.robot.cancel()
                if outcome.ok:
                    await self._goal_ended()
            elif answer != "Leave it running and quit":
                return
        self.exit()

    def _leave_on_signals(self) -> None:
        """End as usual on a signal, so that the terminal and ROS are put in order: 128 + n."""
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            loop.add_signal_handler(number, self._leave_with, 128 + number)

    def _leave_with(self, code: int) -> None:
        self.exit(return_code=code)

    async def _goal_ended(self) -> None:
        loop = asyncio.get_running_loop()
        end = loop.time() + _CANCEL_WAIT
        while loop.time() < end:
            goal = self._snapshot.goal
            if goal is None or not goal.is_running:
                return
            await asyncio.sleep(0.02)
