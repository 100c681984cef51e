"""The Textual app: takes snapshots from the Robot, shows views, runs commands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from textual.app import SystemCommand
from textual.binding import Binding
from textual.screen import Screen
from textual.widgets import Input

from archo_tui.alarms import Alarm, conditions
from archo_tui.clock import Clock
from archo_tui.commands import COMMANDS
from archo_tui.commands.base import EVERYWHERE, Command
from archo_tui.edits import Edits
from archo_tui.keymap import shown_keys
from archo_tui.robot.state import Outcome, Snapshot
from archo_tui.screens.alarms import AlarmList
from archo_tui.screens.confirm import Confirm
from archo_tui.screens.edit_parameter import EditParameter
from archo_tui.screens.main import MainScreen
from archo_tui.screens.text import ShowText
from archo_tui.terminal_app import TerminalApp
from archo_tui.widgets.goal_panel import GoalPanel
from archo_tui.widgets.parameters_panel import ParametersPanel
from archo_tui.widgets.rows import Rows
from archo_tui.widgets.view import View

if TYPE_CHECKING:
    from archo_tui.session import Session


class ArchoApp(TerminalApp):
    """The operator's console."""

    TITLE = "ARCHO"
    CSS_PATH = ["screens/main.tcss", "screens/dialog.tcss"]
    BINDINGS = [
        Binding("escape", "leave_field", "Out of the field", show=False, priority=True),
        *(Binding(key, f"move('{key}')", show=False, priority=True) for key in Rows.KEYS),
    ]

    def __init__(
        self,
        session: Session,
        clock: Clock | None = None,
        keys: Mapping[str, str] | None = None,
        theme: str = "",
        failed: str = "",
    ) -> None:
        """`keys` of commands by id, when they are not the registry's own; `theme` by its name.

        `failed` is the traceback that ended the screen before this one, to be shown.
        """
        super().__init__(session.robot, session.options.on_disconnect, theme)
        self.robot = session.robot
        self.host = session.host
        self.registry = COMMANDS
        self.main = MainScreen()
        self.edits = Edits()
        self._failed_before = failed
        self._clock = clock or Clock()
        self._session = session
        self._alarms = session.alarms
        self._snapshot = Snapshot()
        self._second = self._clock.monotonic()
        self._keys = {command.id: command.key for command in COMMANDS} | dict(keys or {})
        self._shown_keys = shown_keys(self._keys)
        self._bind_commands()
        self.view = self._view()

    def _bind_commands(self) -> None:
        """All have priority, so that a key acts before the next one goes to whatever it focused.

        Over a slow line several arrive at once. check_action takes the letters back while typing.
        App.bind knows no priority, and a keymap of Textual's drops what shares a key.
        """
        for command in self.registry:
            key, action = self._keys[command.id], f"command('{command.id}')"
            binding = Binding(key, action, command.help, id=command.id, priority=True)
            # another list: the class's own bindings are shared by all apps
            known = self._bindings.key_to_bindings.get(key, [])
            ours = [b for b in known if b.action.startswith("command(")]
            self._bindings.key_to_bindings[key] = [*ours, binding]

    def get_default_screen(self) -> Screen[None]:
        return self.main

    def on_mount(self) -> None:
        self.robot.subscribe(self._take)
        self.set_interval(1.0, self.tick)
        if self._failed_before:
            said = "The screen failed and was started anew; the nodes ran on."
            text = f"{said}\n\n{self._failed_before}"
            self.push_screen(ShowText("An error of the console", text))

    def on_resize(self) -> None:
        self.call_after_refresh(self.tick)

    def _take(self, snapshot: Snapshot) -> None:
        self._snapshot = snapshot
        try:
            self.show()
        except Exception as error:  # called by the loop: Textual would not hear of it
            self._handle_exception(error)

    def tick(self) -> None:
        """A second has passed: show ages and the time anew."""
        self._second = self._clock.monotonic()
        self.show()

    def show(self) -> None:
        """Show the newest snapshot at the time it is now."""
        now = self._clock.monotonic()
        found = conditions(self._snapshot, now, self.host.states())
        self._session.alarmed(self._alarms.update(found, now, self._clock.now()))
        self.view = self._view()
        if self.is_running and self.main.is_mounted:  # neither before nor behind the screen's life
            blocked = frozenset(c.id for c in self.registry if self.blocked(c))
            self.view = replace(self.view, blocked=blocked)
            footer = [
                (c.id, c.footer_key or self.view.key(c.id), c.footer, c.id in blocked)
                for c in self.registry
                if c.footer
            ]
            self.main.show(self.view, footer)
            for screen in self.screen_stack:
                if isinstance(screen, AlarmList):
                    screen.show(self.view)

    def _view(self) -> View:
        return View(
            self._snapshot,
            self._clock.monotonic(),
            self._second,
            self._clock.now(),
            self._session.engine,
            self._session.options.namespace,
            self._alarms.all(),
            self.host.states(),
            self._shown_keys,
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
        if action == "move":
            return isinstance(self.focused, Rows)
        if action != "command":
            return super().check_action(action, parameters)
        command = self._command(str(parameters[0]))
        if command.where == EVERYWHERE:
            return True
        if self.screen is not self.main or typing:
            return False
        return not command.panel or command.panel == self.main.focused_panel

    def _command(self, name: str) -> Command:
        return next(c for c in self.registry if c.id == name)

    def action_command(self, name: str) -> None:
        """Run a command of the registry, or say why it cannot run."""
        command = self._command(name)
        reason = self.blocked(command)
        if reason:
            self.notify(reason, severity="warning", markup=False)
            if not command.runs_blocked:
                return
        work = command.run(self)  # at once: the next key may be for what this one focused
        if work is not None:
            self.run_worker(work, group=name)

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """The palette: the registry, and what Textual brings."""
        for command in self.registry:
            title = f"{command.help.partition(';')[0]} ({self.view.key(command.id)})"
            yield SystemCommand(
                title,
                self.blocked(command) or command.help,
                lambda name=command.id: self.action_command(name),
            )
        brought = ("Theme", "Screenshot")
        yield from (c for c in super().get_system_commands(screen) if c.title in brought)

    def tell(self, outcome: Outcome) -> None:
        """Say it when a command failed; what it did is seen on the screen."""
        if not outcome.ok:
            self.notify(outcome.text, severity="error", markup=False)

    async def ask(self, question: Confirm) -> str:
        """Put a question and wait for the answer, the safe one if another is being asked."""
        if isinstance(self.screen, Confirm):
            return question.safe
        return str(await self.push_screen_wait(question))  # type: ignore[arg-type]

    def acknowledge(self, alarms: list[Alarm]) -> None:
        """The operator has seen these alarms."""
        for alarm in alarms:
            self._session.alarmed(self._alarms.acknowledge(alarm, self._clock.now()))
        self.show()

    def shelve(self, alarm: Alarm) -> None:
        """Silence an alarm for a while, or take it off the shelf."""
        self._session.alarmed(self._alarms.shelve(alarm, self._clock.now()))
        self.show()

    def copy_selection(self) -> bool:
        """Copy what is selected; False when nothing is."""
        focused = self.focused
        text = focused.selected_text if isinstance(focused, Input) else None
        text = text or self.screen.get_selected_text()
        if text:
            self.copy_to_clipboard(text)
        return bool(text)

    def action_move(self, key: str) -> None:
        """Move the cursor of the list that has the focus."""
        if isinstance(self.focused, Rows):
            self.focused.press(key)

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
                lambda value: self.set_parameters(parameter.node, {parameter.name: value}),
            )
        )

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none; what was done can be undone."""
        return await self.edits.set_parameters(self.robot, node, values)

    @property
    def attached(self) -> bool:
        """True when the robot lives on without this process."""
        return self._session.options.attach
