"""What becomes of keys and clicks: STOP first, the others in their order, a held one once."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping
from typing import cast

from textual import events
from textual.binding import Binding
from textual.widgets import Input

from archo_tui.commands import registry
from archo_tui.commands.base import EVERYWHERE, Command
from archo_tui.commands.keymap import shown_keys
from archo_tui.robot.state import Snapshot
from archo_tui.screens.leaving import Leaving
from archo_tui.screens.main import MainScreen
from archo_tui.station.station import Station
from archo_tui.terminal.app import TerminalApp
from archo_tui.terminal.typed import Read, mark, mark_read, typed_after, with_its_marks
from archo_tui.verbs import verbs
from archo_tui.verbs.base import Verb
from archo_tui.widgets.board import Board
from archo_tui.widgets.field import Field
from archo_tui.widgets.rows import Rows

HELD = 0.7  # s within which the same key again means that it is held: X11 waits 0.66 s at first


_MOVES = tuple(dict.fromkeys((*Rows.KEYS, *Board.KEYS)))


class KeyedApp(TerminalApp):
    """Base of the app: hands keys and clicks to the commands, and to what has the focus."""

    BINDINGS = [
        Binding("escape", "leave_field", "Leave the field", show=False, priority=True),
        Binding("enter", "next_field", "The next field of the form", show=False, priority=True),
        Binding("enter", "take", "Take the number into the field", show=False, priority=True),
        Binding("tab", "beside(1)", "To the board, and on", show=False, priority=True),
        Binding("shift+tab", "beside(-1)", "Back from the board", show=False, priority=True),
        *(Binding(key, f"move('{key}')", show=False, priority=True) for key in _MOVES),
    ]

    def __init__(self, station: Station, keys: Mapping[str, str], theme: str) -> None:
        """`keys` of commands by id, where they are not the registry's own."""
        super().__init__(station, theme)
        snapshot = station.robot.snapshot
        self.verbs: Mapping[str, Verb] = verbs(snapshot.file, snapshot.forms)
        self.registry = self.commands(snapshot)
        self.main = self.main_screen(snapshot)
        self._keys = {c.id: keys.get(c.id, c.key) for c in self.registry}
        self._shown_keys = shown_keys(self._keys)
        self.stop_key = self._keys["stop"]
        self._bind_commands()
        self._early: list[tuple[events.Event, bool]] = []  # typed before the screen could take it
        self._last_key, self._last_typed = "", 0.0
        self._last_stops: int | None = None  # read before it
        self._entered: tuple[object, ...] = ()  # where the last enter acted
        self._pressed_stop = False
        self._shut_since: float | None = None  # when a STOP closed the dialog that keys were for
        self._shut_said = False  # that what came at once was dropped
        self._shut_by = ""  # what did
        self._answers_void = 0  # keys with a lower count were for a question that is not put
        self._swallows = False  # enter is held, and what that does was said
        self.repeated = False
        self._read = Read(-math.inf, math.inf)  # the last key or click, however late it is taken

    def commands(self, snapshot: Snapshot) -> tuple[Command, ...]:
        """All that there are."""
        return registry(snapshot.file, self.verbs)

    def main_screen(self, snapshot: Snapshot) -> MainScreen:
        """The one that all others are over."""
        return MainScreen(snapshot, self.size)

    def _bind_commands(self) -> None:
        """All have priority, so that a key acts before the next one goes to whatever it focused.

        Over a slow line several arrive at once. check_action gives letters back to a field.
        App.bind knows no priority, and a keymap of Textual's drops what shares a key.
        """
        for command in self.registry:
            key, action = self._keys[command.id], f"command('{command.id}')"
            if not key:
                continue
            binding = Binding(key, action, command.help, id=command.id, priority=True)
            # another list: the class's own bindings are shared by all apps
            known = self._bindings.key_to_bindings.get(key, [])
            ours = [b for b in known if b.action.startswith(("command(", "next_field", "take"))]
            self._bindings.key_to_bindings[key] = [*ours, binding]

    def action_command(self, name: str, counted: bool = False) -> None:
        """Run a command of the registry; a STOP is `counted` when it was read from its key."""
        raise NotImplementedError

    def void_answers(self) -> None:
        """What was typed before the last STOP is for no question any more."""
        self._answers_void = self.stops.count
        self._early = [one for one in self._early if self._is_free(one[0])]

    async def on_event(self, event: events.Event) -> None:
        if isinstance(event, (events.MouseDown, events.MouseUp)) and event.button > 1:
            return  # only the left button acts
        typed = isinstance(event, (events.Key, events.Paste)) and not event.is_forwarded
        if typed and isinstance(event, events.Key) and self.is_stop(event):
            mark(event, self.stops.read())  # from another driver than the terminal's
            self.stop_now(event)
            return
        if isinstance(event, events.MouseEvent) and not event.is_forwarded:
            if self._clicks_stop(event):
                return
            if self.mouse_captured is None and not self.screen.region.contains(event.x, event.y):
                return  # of a terminal that was larger: beside everything it takes the focus away
            await asyncio.sleep(0)  # in a flood, too, others get their turn: STOP first of all
        stops = typed_after(event)
        if typed and stops is not None and stops < self._answers_void and not self._is_free(event):
            return
        if typed and self._was_for_a_dialog(event):
            return
        clicked = isinstance(event, events.MouseDown) and not event.is_forwarded
        repeated = (typed or clicked) and self._repeats(event)
        if isinstance(event, events.MouseUp):  # what was pressed acts as it is let go
            mark_read(event, self._read)
        if typed and (self._early or not self._takes_keys):
            self._early.append((event, repeated))
            self.call_later(self._release_keys)
            return
        await self._handle(event, repeated)

    def closed_by_stop(self) -> None:
        """A dialog went, whoever pressed STOP: what comes at once may still be for it."""
        self.void_answers()
        self.dialog_gone("STOP closed the dialog")

    def dialog_gone(self, why: str) -> None:
        """It went by itself: what comes at once acts nowhere else."""
        self._shut_by, self._shut_said = why, False
        self._shut_since = self.station.clock.monotonic()

    def _was_for_a_dialog(self, event: events.Event) -> bool:
        """True, and said, for what would act below a dialog that has just been closed."""
        if self._shut_since is None or self._is_free(event) or self.screen is not self.main:
            return False
        if isinstance(event, events.Key) and event.key == "escape":  # it only leads out
            return False
        if self.station.clock.monotonic() - self._shut_since >= HELD:
            self._shut_since = None
            return False
        if not self._shut_said:
            self._shut_said = True
            said = f"{self._shut_by}: press the key again."
            self.notify(said, severity="warning", markup=False)
        return True

    def stop_now(self, event: events.Key) -> None:
        before, self.repeated = self.repeated, self._repeats(event)
        with self.stops.at(typed_after(event)):
            self.action_command("stop", counted=True)
        self.repeated = before  # of the key that is being handled

    def _is_free(self, event: events.Event) -> bool:
        """True for a key that is a command everywhere: a cancel, say, is for no question."""
        free = {self._keys[c.id] for c in self.registry if c.where == EVERYWHERE}
        return isinstance(event, events.Key) and event.key in free

    def _clicks_stop(self, event: events.MouseEvent) -> bool:
        """True for a click on STOP where it is seen, also beside a dialog, and as one goes.

        It acts as it is pressed; its release does nothing.
        """
        if isinstance(event, events.MouseUp) and self._pressed_stop:
            self._pressed_stop = False
            return True
        if not isinstance(event, events.MouseDown) or not self.main.shows_stop_at(event.x, event.y):
            return False
        front = self.screen
        stands = front is not self.main and not (isinstance(front, Leaving) and front.has_left)
        if stands and front.get_widget_and_offset_at(event.x, event.y)[0] is not front:
            return False  # on the dialog
        self._pressed_stop = True
        self.repeated = False
        self.action_command("stop")
        return True

    def _repeats(self, event: events.Event) -> bool:
        """True for a key that is held down: the same again, and soon."""
        key = event.key if isinstance(event, events.Key) else ""
        before, since = self._last_key, self._last_typed
        self._last_key, self._last_typed = key, self.station.clock.monotonic()
        self._read = Read(event.time, event.time - self._read.at)
        mark_read(event, self._read)
        apart, self._last_stops = self._last_stops, typed_after(event)  # a STOP between them
        repeated = key != "" and key == before and self._last_typed - since < HELD
        repeated = repeated and (key == self.stop_key or apart == self._last_stops)
        self._swallows = self._swallows and repeated
        return repeated

    async def _handle(self, event: events.Event, repeated: bool) -> None:
        self.repeated = repeated
        if isinstance(event, events.Key) and event.key == "enter" and not event.is_forwarded:
            if repeated and not self._may_repeat():
                return
            self._entered = self._place
        # it may have waited behind others; a click is a message of its own
        with self.stops.at(typed_after(event)), with_its_marks(event, self):
            await super().on_event(event)

    @property
    def _place(self) -> tuple[object, ...]:
        """Where enter acts: the screen, what has the focus, and the row of a list."""
        focused = self.focused
        return self.screen, focused, focused.item_key if isinstance(focused, Rows) else None

    def _may_repeat(self) -> bool:
        """False, and said, for an enter that is held down where it would answer or send.

        It runs from field to field, and acts on another row of the screen where the one before
        acted. What was opened by it wants to be answered by another one.
        """
        if self.check_action("next_field", ()):
            return True
        here, before = self._place, self._entered
        if isinstance(self.focused, Rows) and here[0] is before[0] and here != before:
            return True
        empty = isinstance(self.focused, Input) and not self.focused.value
        if not (self._swallows or empty):
            self.notify("Enter came too soon after the last one: press it again.", markup=False)
        self._swallows = True
        return False

    @property
    def _takes_keys(self) -> bool:
        """False while the screen in front is being built, or opens what they are for."""
        if not self.screen_stack or not self.screen.is_mounted:
            return False
        return not (isinstance(self.screen, Leaving) and self.screen.is_opening)

    async def _release_keys(self) -> None:
        """Hand on what was typed meanwhile, in its order; what it opens is waited for as well."""
        while self._early and self._takes_keys:
            await self._handle(*self._early.pop(0))
        if self._early:
            await asyncio.sleep(0)
            self.call_later(self._release_keys)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """False leaves the key to the field or dialog that has the focus."""
        field = self.focused if isinstance(self.focused, Input) else None
        if action == "leave_field":
            is_inside = field is not None or isinstance(self.focused, Board)
            return self.screen is self.main and (is_inside or self.main.is_full)
        if action == "next_field":
            return isinstance(field, Field) and field.next_field is not None
        if action == "take":
            return isinstance(self.focused, Board)
        if action == "beside":
            step = cast("int", parameters[0])
            return (
                self.screen is self.main and self.main.goal.beside(self.focused, step) is not None
            )
        if action == "move":
            kind = type(self.focused)
            return issubclass(kind, (Rows, Board)) and parameters[0] in kind.KEYS
        if action != "command":
            return super().check_action(action, parameters)
        command = self._command(str(parameters[0]))
        if command.where == EVERYWHERE:
            return True
        if self.screen is not self.main or (field is not None and self._is_text(command, field)):
            return False
        return not command.panel or command.panel == self.main.focused_panel

    def _is_text(self, command: Command, field: Input) -> bool:
        """True when the command's key is text, or moves or edits, in the field."""
        key = self._shown_keys[command.id]
        return not isinstance(field, Field) or len(key) > 1 or field.is_text(key)

    def _command(self, name: str) -> Command:
        return next(c for c in self.registry if c.id == name)

    def action_move(self, key: str) -> None:
        """Move the cursor of the list or the board that has the focus."""
        if isinstance(self.focused, (Rows, Board)):
            self.focused.press(key)

    def action_take(self) -> None:
        """At once, as all of these: the keys behind it are for the field."""
        if isinstance(self.focused, Board):
            self.focused.take()

    def action_beside(self, step: int) -> None:
        """From the field to the board and on, or back."""
        beside = self.main.goal.beside(self.focused, step)
        if isinstance(beside, Field):
            self.main.goal.type_on()
        elif beside is not None:
            self.main.set_focus(beside, scroll_visible=False)

    def action_next_field(self) -> None:
        """At once: the keys behind enter are for the next field, however fast they come."""
        if isinstance(self.focused, Field):
            self.screen.set_focus(self.focused.next_field)

    def action_leave_field(self) -> None:
        """Out of a field, to where the focus was; out of the full screen."""
        if isinstance(self.focused, Input):
            self.main.focus_back()
        elif isinstance(self.focused, Board):
            self.main.goal.type_on()
        else:
            self.main.leave_full()
