"""The handling of keys and clicks: STOP first, the others in their order, a held one once."""

from __future__ import annotations

import asyncio
import math
import string
from typing import NamedTuple

from textual import events
from textual.binding import Binding
from textual.widget import Widget
from textual.widgets import Input

from archo_tui.screen.commands.base import EVERYWHERE, Command, Desk, InputTime
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.main import MainScreen
from archo_tui.screen.terminal.stop_marks import mark_stops, marks_of, stops_before, typed_after
from archo_tui.screen.widgets.bars import NoticeLine
from archo_tui.screen.widgets.field import Field
from archo_tui.screen.widgets.rows import Rows
from archo_tui.station.station import Station


class Entered(NamedTuple):
    """A key, a paste, or a press or release of the mouse, as it was read."""

    event: events.Event
    repeated: bool  # Its key is held down.
    read: InputTime


# Seconds within which an equal key means a held one: X11 begins to repeat after 0.66 s. They count
# to when the key was surely not typed yet, which is 0.1 s earlier on an idle machine.
HELD = 0.7


class KeyedApp(Desk):
    """The base of the app, which passes keys and clicks to commands or to the focused widget.

    STOP acts at once. The others act one after the other, each when the one before is done.
    """

    BINDINGS = [
        Binding("escape", "leave_field", "Leave the field", show=False, priority=True),
    ]

    def __init__(self, station: Station, theme: str) -> None:
        super().__init__(station, theme)
        self._early: list[Entered] = []  # Typed before their target was there.
        self._acting: Widget | None = None  # It was clicked, and has not handled that yet.
        self._is_drawn = False  # True once the last input is visible: a click is for what is seen.
        self._is_typed = False  # True if the current key goes to the focused widget.
        self._last_key, self._last_typed = "", 0.0
        self._last_stops: int | None = None  # The count of STOPs read before the last input.
        self._acted: tuple[object, ...] = ()  # Where the last key acted.
        self._pressed_stop = False
        self._swallows = False  # True if enter is held, and a message has explained that.
        self._last_read = -math.inf  # The `event.time` of the last key or click.
        self._read = InputTime(-math.inf, math.inf)  # Of that, however late it is handled.

    @property
    def was_operated(self) -> bool:
        """True once a key, a paste or a click was read."""
        return self._last_read > -math.inf

    def bind_commands(self) -> None:
        """Bind the keys of commands with priority, so that a key acts before the next is handed on.

        check_action gives letters back to a field. A key loses what else it was bound to, but not
        the other commands that share it. App.bind has no priority, and a keymap of Textual's drops
        commands that share a key.
        """
        for command in self.registry:
            key, action = self.keys[command.id], f"command('{command.id}')"
            if not key:
                continue
            binding = Binding(key, action, command.help, id=command.id, priority=True)
            # A new list, since all apps share the class's own bindings.
            known = self._bindings.key_to_bindings.get(key, [])
            ours = [b for b in known if b.action.startswith("command(")]
            self._bindings.key_to_bindings[key] = [*ours, binding]
            if key in string.digits:  # With alt, which escape before it is in tmux, it is no text.
                key, action = f"alt+{key}", f"digit('{command.id}')"
                own = [Binding(key, action, priority=True)]
                self._bindings.key_to_bindings.setdefault(key, own)

    async def on_event(self, event: events.Event) -> None:
        if isinstance(event, (events.MouseDown, events.MouseUp)) and event.button > 1:
            return  # Only the left button acts.
        if isinstance(event, events.Key) and event.is_forwarded:
            return  # No widget took it; bindings were looked up in its turn.
        if isinstance(event, events.Key) and self.is_stop(event):
            # It comes from another driver than the terminal's.
            mark_stops(event, self.stops.register())
            self.stop_now(event)
            return
        if isinstance(event, events.MouseEvent) and not event.is_forwarded:
            if self._stop_if_clicked(event):
                return
            if self.mouse_captured is None and not self.screen.region.contains(event.x, event.y):
                return  # From when the terminal was larger: outside it would only take the focus.
        kinds = events.Key, events.Paste, events.MouseDown, events.MouseUp
        is_input = isinstance(event, kinds) and not event.is_forwarded
        if is_input and stops_before(event) is None:  # Of another driver than the terminal's.
            mark_stops(event, self.stops.count)
        if isinstance(event, (events.MouseEvent, events.Key)) and not event.is_forwarded:
            await asyncio.sleep(0)  # Even in a flood others get their turn, STOP above all.
        if not is_input:
            await super().on_event(event)
            return
        # A button acts as the mouse is released, for the input that the press was.
        repeated = not isinstance(event, events.MouseUp) and self._record_input(event)
        entered = Entered(event, repeated, self._read)
        if self._early and self._overtakes_waiting(event):
            self._early.clear()
            said = "What was typed while an answer is waited for is dropped."
            self.notify(said, severity="warning", markup=False)
        if self._early or not self._takes(event):
            self._early.append(entered)
            self.call_later(self._release)
        else:
            await self._hand_on(entered)

    async def _hand_on(self, entered: Entered) -> None:
        """Handle a key or a click, unless it was meant for a dialog that has gone."""
        event = entered.event
        stops, typed = stops_before(event), isinstance(event, (events.Key, events.Paste))
        if typed and not self._works_everywhere(event):
            is_void = stops is not None and stops < self._answers_void
            if is_void or self._was_for_a_dialog(event):
                return
        is_key = isinstance(event, events.Key) and not entered.repeated
        if is_key and isinstance(self.screen, (Dialog, MainScreen)):
            self.screen.forget_refusal()
        await self._handle(entered)

    def _was_for_a_dialog(self, event: events.Event) -> bool:
        """Return True, with a message the first time, if a key was for a dialog just closed."""
        if self._shut_since is None:
            return False
        if isinstance(event, events.Key) and event.key == "escape":  # Escape only closes.
            return False
        if self._earliest(event) - self._shut_since >= HELD:
            self._shut_since = None
            return False
        self._shut_since = self.station.clock.monotonic()
        if not self._shut_said:
            self._shut_said = True
            said = f"{self._shut_by}: press the key again."
            self.notify(said, severity="warning", markup=False)
        return True

    def stop_now(self, event: events.Key) -> None:
        """Run STOP, whose key is counted already, while another key may be being handled."""
        before, self.repeated = self.repeated, self._record_input(event)
        with self.stops.typed_at(stops_before(event)):
            self.action_command("stop", counted=True)
        self.repeated = before  # Of the key that is being handled.

    def _works_everywhere(self, event: events.Event) -> bool:
        free = {self.keys[c.id] for c in self.registry if c.where == EVERYWHERE}
        return isinstance(event, events.Key) and event.key in free

    def _stop_if_clicked(self, event: events.MouseEvent) -> bool:
        """Run STOP if a press of the mouse is on a visible STOP button, also beside a dialog.

        True for the press and the release of the button, which nothing else may handle.
        """
        if isinstance(event, events.MouseUp) and self._pressed_stop:
            self._pressed_stop = False
            return True
        if not isinstance(event, events.MouseDown) or not self.main.shows_stop_at(event.x, event.y):
            return False
        front = self.screen
        is_leaving = isinstance(front, Dialog) and front.is_dismissed
        stands = front is not self.main and not is_leaving
        pressed = (widget for widget, _ in front.get_widgets_at(event.x, event.y))
        if stands and next(w for w in pressed if not isinstance(w, NoticeLine)) is not front:
            return False  # On the dialog.
        self._pressed_stop = True
        self.repeated = False
        self.action_command("stop")
        return True

    def _record_input(self, event: events.Event) -> bool:
        """Note when a key, paste or press was read, and which STOPs came before it.

        True for a key that is held down: the same as the last one, within HELD, without a STOP
        between unless it is STOP's own.
        """
        key = event.key if isinstance(event, events.Key) else ""
        before, since = self._last_key, self._last_typed
        self._last_key, self._last_typed = key, self.station.clock.monotonic()
        typed = typed_after(event)
        at = event.time if typed is None else typed
        self._read, self._last_read = InputTime(at, at - self._last_read), event.time
        # Equal unless a STOP came between them.
        apart, self._last_stops = self._last_stops, stops_before(event)
        repeated = key != "" and key == before and self._earliest(event) - since < HELD
        repeated = repeated and (key == self.stop_key or apart == self._last_stops)
        self._swallows = self._swallows and repeated
        return repeated

    def _earliest(self, event: events.Event) -> float:
        """Return the earliest time at which a key can have been typed, on the station's clock.

        It may be long ago, if this process did not come to read it.
        """
        typed = typed_after(event)
        return self.station.clock.monotonic() if typed is None else typed

    async def _handle(self, entered: Entered) -> None:
        """Pass a key or a click on to Textual; do nothing for a held key that may not repeat."""
        event, repeated, self.input = entered
        self.repeated, self._is_drawn = repeated, False
        if isinstance(event, events.Key):
            if repeated and not self._may_repeat(event):
                return
            self._acted = self._place
        self._acting = self._widget_acting_later(event)
        with self.stops.typed_at(stops_before(event)), marks_of(event, self):
            await super().on_event(event)
        is_queued = self._acting is not None and self._acting.call_later(self._on_acted)
        self._acting = self._acting if is_queued else None

    def _widget_acting_later(self, event: events.Event) -> Widget | None:
        """Return the widget that will handle an event from its own queue, after this call.

        None if nothing does: a field handles pastes and text at once. Whether a key is text is
        noted.
        """
        focused = self.focused
        if isinstance(event, events.MouseEvent):
            return self.screen.get_widget_and_offset_at(event.x, event.y)[0]
        if isinstance(event, events.Key):
            consumes = focused is not None and focused.check_consume_key(event.key, event.character)
            self._is_typed = event.is_printable if isinstance(focused, Field) else consumes
            if not self._is_typed:
                return None
        return None if isinstance(focused, Field) else focused

    def _on_acted(self) -> None:
        """Hand on the keys that wait: the widget has handled the click or the text."""
        self._acting = None
        self.call_later(self._release)

    async def _check_bindings(self, key: str, priority: bool = False) -> bool:
        """Run what is bound to a key, and return True if anything is.

        Textual asks for bindings with priority first. The others are looked up then, too, unless
        the key is text: a widget would look them up later, from its queue.
        """
        if await super()._check_bindings(key, priority):
            return True
        return priority and not self._is_typed and await super()._check_bindings(key)

    @property
    def _place(self) -> tuple[object, ...]:
        """Return where a key acts: the screen, the focused widget, and its row if it is a list."""
        focused = self.focused
        return self.screen, focused, focused.item_key if isinstance(focused, Rows) else None

    def _may_repeat(self, event: events.Key) -> bool:
        """Return True if a key that is held down may act again where it has led.

        Most keys act on no other screen than before, unless they are text there, close it, or work
        everywhere. Enter neither answers nor sends, which a message says once.
        """
        here, before = self._place, self._acted
        if event.key != "enter":
            is_text = isinstance(self.focused, Field) and event.is_printable
            leads_out = event.key == "escape" or self._works_everywhere(event)
            return here[0] is before[0] or is_text or leads_out
        if isinstance(self.focused, Field) and self.focused.next_field is not None:
            return True
        if isinstance(self.focused, Rows) and here[0] is before[0] and here != before:
            return True
        empty = isinstance(self.focused, Input) and not self.focused.value
        if not (self._swallows or empty):
            self.notify("Enter came too soon after the last one: press it again.", markup=False)
        self._swallows = True
        return False

    @property
    def _is_changing(self) -> bool:
        if not self.screen_stack or not self.screen.is_mounted:
            return True
        return isinstance(self.screen, Dialog) and self.screen.is_dismissed

    def _takes(self, event: events.Event) -> bool:
        """Return True if an event can be handled now: what came before is done, its target there.

        While a dialog waits for an answer, or is being opened, only keys that work everywhere are
        taken. A press of the mouse waits until the screen is drawn, so that it is for what is seen.
        """
        if self._is_changing or (self._acting is not None and self._acting.is_running):
            return False
        if isinstance(event, events.MouseDown) and not self._is_drawn:
            return False
        if isinstance(self.screen, Dialog) and self.screen.is_asking:
            return self._works_everywhere(event) or getattr(event, "key", "") == "escape"
        return not self._opening or self._works_everywhere(event)

    def _overtakes_waiting(self, event: events.Event) -> bool:
        """Return True if a key acts now, before other keys that wait for an answer.

        Only escape and the keys that work everywhere do so, if the first of those that wait has
        waited for HELD: keys of one burst keep their order.
        """
        first, escapes = self._early[0].event, getattr(event, "key", "") == "escape"
        if event.time - first.time < HELD or not (escapes or self._works_everywhere(event)):
            return False
        return self._takes(event) and not self._takes(first)

    async def _release(self) -> None:
        """Hand on the next waiting key or click, or try again later."""
        if self._early and self._takes(self._early[0].event):
            await self._hand_on(self._early.pop(0))
        if not self._early:
            return
        event = self._early[0].event
        if self._is_changing or self._takes(event):
            await asyncio.sleep(0)
            self.call_later(self._release)
        elif isinstance(event, events.MouseDown) and not self._is_drawn:
            self.call_after_refresh(self._drawn)

    def _drawn(self) -> None:
        self._is_drawn = True
        self.call_later(self._release)

    def on_worker_state_changed(self) -> None:
        """Hand on the keys that waited for an answer: a worker may have got it."""
        self.call_later(self._release)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return True if the action of a key acts now, False if the key is left to others."""
        main = self.main
        field = self.focused if isinstance(self.focused, Input) else None
        if action == "leave_field":
            leads_out = field is not None or main.search is not None or main.is_full
            return self.screen is main and leads_out
        if action not in ("command", "digit"):
            return super().check_action(action, parameters)
        command = self._find_command(str(parameters[0]))
        if command is None:
            return False
        if command.where == EVERYWHERE:
            return True
        is_text = action == "command" and field is not None and self._is_text(command, field)
        if self.screen is not main or is_text:
            return False
        return command.panel is None or isinstance(main.panel_with_focus, command.panel)

    def _is_text(self, command: Command, field: Input) -> bool:
        """Return True if a field takes the key of a command itself: as text, or to edit."""
        key = self.shown_keys[command.id]
        return not isinstance(field, Field) or len(key) > 1 or field.is_typed(key)

    def action_digit(self, name: str) -> None:
        """Run the command of a digit that was typed with alt, or directly behind an escape."""
        self.action_command(name)

    def action_leave_field(self) -> None:
        """Leave the field, the search or the full screen: the first that applies."""
        main = self.main
        search = main.search
        if isinstance(self.focused, Input):
            main.focus_back()
        elif search is not None:
            search.close()
        else:
            main.leave_full()
