"""The base of the numbered panels, and the state that they show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from textual.app import ComposeResult
from textual.containers import Container
from textual.content import Content
from textual.markup import escape
from textual.message import Message
from textual.widget import Widget

from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import RobotFile
from archo_tui.screen.widgets.field import Button
from archo_tui.screen.widgets.line import click, key_content
from archo_tui.screen.widgets.rows import Rows
from archo_tui.station.alarms import Alarm, advice, remedy_hints
from archo_tui.station.view import View

NONE_RECORDED = "-- none recorded"  # The text of an empty list in a replay.


@dataclass(frozen=True)
class ScreenState(View):
    """The station's view, with what only a screen needs."""

    # By the command's id, as a person reads it.
    keys: Mapping[str, str] = field(default_factory=dict)
    blocked: frozenset[str] = frozenset()  # The ids of the commands that cannot run now.
    # The ids of the commands whose keys the focused field takes as text, and of what it is for.
    typed: frozenset[str] = frozenset()

    def advice(self, alarm: Alarm) -> str:
        """Return the text of an alarm, with the key of the command that helps if it can run now."""
        names = [name for name, key in self.keys.items() if key and name not in self.blocked]
        hints = {name: f"press {self.key_to_press(name)}" for name in names}
        return advice(alarm, remedy_hints(self.snapshot, hints))

    def key_to_press(self, command: str) -> str:
        """Return the key of a command, behind `esc` while it is text; "" if it has none."""
        key = self.key(command)
        return f"esc {key}" if key and command in self.typed else key

    def key(self, command: str) -> str:
        """Return the key of a command by its id, or "" if it has none."""
        return self.keys.get(command, "")


FULL_SCREEN = "full screen"  # The word of keys that enlarge a panel.


class Panel(Container):
    """The base of the numbered panels; the screen calls `show` with every new state."""

    number = 0  # Set by the table of panels; it is also the key that leads to the panel.
    title_text = ""
    verbs: Sequence[str] = ()  # Those that print what it shows.
    place = "below"  # "left" or "right", in a column, or "beside" the columns.
    needs_room = False  # It is shown among the others on a large screen only.
    gives_way = False  # A robot file or a keymap may take the key of its number.
    # Pairs of a command's id and a word, for the lower border.
    keys: Sequence[tuple[str, str]] = ()
    # Of the field with the focus, each with its word.
    field_keys: Sequence[tuple[str, str]] = ()
    # The keys of commands, by id, that differ within this panel.
    other_keys: Mapping[str, str] = {}

    class Outdated(Message):
        """The message that a panel must be shown again, though no new state has come."""

        def __init__(self, panel: Panel) -> None:
            super().__init__()
            self.panel = panel

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(classes="-needs-room" if self.needs_room else None)
        self.title_text = self.title_for(snapshot.file)
        self.border_title = f"{self.number} {self.title_text}"
        self._title, self._keys_below = Content(self.border_title), Content("")
        self._narrowed, self._title_more = "", ""  # After the title: plain text, then markup.
        # What the keys, and what takes long to make, were last written for.
        self._keys_inputs: object = None
        self._inputs: object = None

    @classmethod
    def title_for(cls, _robot: RobotFile) -> str:
        """Return the title without the number; that of some panels is the robot file's."""
        return cls.title_text

    def on_resize(self) -> None:
        self.post_message(self.Outdated(self))

    def show(self, view: ScreenState) -> None:
        """Update the panel; only what has changed is redrawn. A subclass must define it."""
        raise NotImplementedError

    def is_news(self, *inputs: object) -> bool:
        """Return True if this differs from what the panel was last made of."""
        before, self._inputs = self._inputs, inputs
        return inputs != before

    def show_keys(self, view: ScreenState, before: str = "") -> None:
        """Write the keys on the lower border, as many as fit; a click on one runs its command.

        Commands without a key are left out, and STOP in a replay. `before` is a word in front of
        them.
        """
        room, is_full = self.size.width - 4, self.screen.has_class("-full")
        words = room, is_full, before, self.keys
        inputs = words, view.keys, view.blocked, view.replay
        if inputs == self._keys_inputs:
            return
        self._keys_inputs = inputs
        parts = [Content(before)] if before else []
        if is_full:  # The key to leave comes first, so that it always fits.
            back = Content.assemble(("esc", "bold"), " back")
            parts.append(back.stylize(click("leave_field()")))
        for command, word in self.keys:
            if command not in view.keys or (view.replay and command == "stop"):
                continue  # STOP does nothing in a replay.
            if is_full and word == FULL_SCREEN:
                continue
            key, blocked = self.other_keys.get(command, view.key(command)), command in view.blocked
            if not key:
                continue  # The palette has it.
            parts.append(key_content(command, key, word, blocked=blocked))
        while parts and sum(part.cell_length + 3 for part in parts) - 3 > room:
            parts.pop()
        below = Content("   ").join(parts)
        if not below.is_same(self._keys_below):
            self._keys_below = below
            self.border_subtitle = below

    def show_publishers(self, view: View, topic: str) -> None:
        """Name the publishers of a topic in the title if there are several: their readings mix."""
        names = view.snapshot.publishers.get(topic, ())
        self.show_title(f"   {len(names)} publishers: {escape(', '.join(names))}" if names else "")

    def show_title(self, more: str) -> None:
        """Show the title, what hides rows, and a text as Textual's markup, in place of the last."""
        self._title_more = more
        title = Content.assemble(
            f"{self.number} {self.title_text}",
            (self._narrowed, "$warning"),
            Content.from_markup(more),
        )
        if not title.is_same(self._title):
            self._title = self.border_title = title

    def show_narrowed(self, *what: str) -> None:
        """Say in the title, in colour, what hides rows or waits; without texts, say nothing."""
        text = ", ".join(filter(None, what))
        self._narrowed = f"   {text}" if text else ""
        self.show_title(self._title_more)

    def dim_unavailable(self, view: View, buttons: Sequence[tuple[str, Button]]) -> None:
        """Dim the buttons whose services cannot be called, or all if the console only watches."""
        snapshot = view.snapshot
        for service, button in buttons:
            blocked = view.watching or bool(snapshot.unavailable(service))
            button.set_class(blocked, "-blocked")

    @property
    def focus_target(self) -> Widget:
        """Return the widget, such as a list, that gets the focus instead of this panel."""
        return self

    def take_focus(self) -> None:
        """Focus the panel, or its `focus_target`, before the next key, without scrolling."""
        focus_target = self if self.can_focus else self.focus_target
        self.screen.set_focus(focus_target, scroll_visible=False)
        if isinstance(focus_target, Rows):
            focus_target.show_cursor()


T = TypeVar("T")


class ListPanel(Panel, Generic[T]):
    """The base of the panels with a list."""

    rows: Rows[T]

    def compose(self) -> ComposeResult:
        yield self.rows

    @property
    def selected(self) -> T | None:
        """The item under the cursor; None in an empty list."""
        return self.rows.item

    @property
    def focus_target(self) -> Widget:
        return self.rows
