"""A numbered panel with its title above and its keys below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from textual.color import Color
from textual.containers import Container
from textual.content import Content
from textual.geometry import Region
from textual.markup import escape
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget

from archo_tui.station.station import View
from archo_tui.widgets.button import Button
from archo_tui.widgets.keys import click, key_content
from archo_tui.widgets.quiet_focus import QuietFocus
from archo_tui.widgets.rows import Rows
from archo_tui.widgets.shown import Shown

_EDGES = ("border_top", "border_right", "border_bottom", "border_left")
FULL_SCREEN = "full screen"  # the word of the keys that give a panel all the room


class Panel(Container, QuietFocus):
    """Base of the eight panels; `show` gets every new view."""

    number = 0
    title_text = ""
    keys: Sequence[tuple[str, str]] = ()  # (command, word) for the border below
    shown_as: Mapping[str, str] = {}  # the key of a command where another one does it in here

    class Resized(Message):
        """What it shows may be for another width."""

        def __init__(self, panel: Panel) -> None:
            super().__init__()
            self.panel = panel

    def __init__(self) -> None:
        super().__init__(id=f"panel-{self.number}", classes="panel")
        self.border_title = f"{self.number} {self.title_text}"
        self._title, self._below = Content(self.border_title), Content("")
        self._narrowed, self._more = "", ""  # behind the title: plain text, then markup
        self._keyed: object = None  # what its keys were last written for
        self._marked = ""  # the colour of its border while it has the focus

    def on_resize(self) -> None:
        self.post_message(self.Resized(self))

    def show(self, view: Shown) -> None:
        """Show what changed."""
        raise NotImplementedError

    def show_keys(self, view: Shown, before: str = "", key_before: str = "") -> None:
        """Write the keys on the border, as many as there is room for; each can be clicked.

        Those of commands that cannot run now are darker; pressed, they say why. `before` is a word
        that stands before them, `key_before` the key for it, if there is one.
        """
        room, is_full = self.size.width - 4, self.screen.has_class("-full")
        words = room, is_full, before, key_before, self.keys
        keyed = words, view.keys, view.blocked, view.replay
        if keyed == self._keyed:
            return
        self._keyed = keyed
        parts = [Content(before)] if before else []
        if key_before:
            parts = [Content.assemble((key_before, "bold"), f" {before}")]
        if is_full:  # how to leave is what must have room
            back = Content.assemble(("esc", "bold"), " back")
            parts.append(back.stylize(click("leave_field()")))
        for command, word in self.keys:
            if command not in view.keys or (view.replay and command == "stop"):
                continue  # of a replay, where none acts
            if is_full and word == FULL_SCREEN:
                continue
            key, blocked = self.shown_as.get(command, view.key(command)), command in view.blocked
            parts.append(key_content(command, key, word, blocked=blocked))
        while parts and sum(part.cell_length + 3 for part in parts) - 3 > room:
            parts.pop()
        below = Content("   ").join(parts)
        if not below.is_same(self._below):
            self._below = below
            self.border_subtitle = below

    def show_publishers(self, view: View, topic: str) -> None:
        """Name them in the title when there are several: their readings come mixed."""
        names = view.snapshot.publishers.get(topic, ())
        self.show_title(f"   {len(names)} publishers: {escape(', '.join(names))}" if names else "")

    def show_title(self, more: str) -> None:
        """Show the title, and more behind it as markup."""
        self._more = more
        title = Content.assemble(
            f"{self.number} {self.title_text}",
            (self._narrowed, "$warning"),
            Content.from_markup(more),
        )
        if not title.is_same(self._title):
            self._title = self.border_title = title

    def show_narrowed(self, *what: str) -> None:
        """Say in the title, in colour, what hides rows of this panel; nothing where nothing does.

        Args:
            what: Plain texts, of which empty ones are left out.
        """
        said = ", ".join(filter(None, what))
        self._narrowed = f"   {said}" if said else ""
        self.show_title(self._more)

    def grey(self, view: View, buttons: Sequence[tuple[str, Button]]) -> None:
        """Dim the button of each service that nobody offers, or another; pressed, it says so.

        Who only watches has none at all.
        """
        snapshot = view.snapshot
        for service, button in buttons:
            blocked = view.watching or bool(snapshot.unavailable(service))
            button.set_class(blocked, "-blocked")

    def mark_focused(self, has_focus: bool) -> None:
        """Show by the border whether it has the focus, or what it contains."""
        colour = self.app.theme_variables["primary"] if has_focus else ""
        if colour != self._marked:
            self._marked = colour
            edge = ("heavy", Color.parse(colour)) if colour else None
            for name in _EDGES:  # set as one border, all that it surrounds would be drawn anew
                self.styles.inline.set_rule(name, edge)
            self._refresh_border()

    def _refresh_border(self) -> None:
        """Have it drawn anew, and nothing of what it surrounds."""
        (width, height), (left, top) = self.outer_size, self.content_offset
        across, down = Region(0, 0, width, 1), Region(0, 0, 1, height)
        edges = across, across.translate((0, height - 1)), down, down.translate((width - 1, 0))
        self.refresh(*(edge.translate((-left, -top)) for edge in edges))

    def render_lines(self, crop: Region) -> list[Strip]:
        """As Textual's, but only one of the lines between its borders is made: all are the same."""
        first, last = max(crop.y, 1), min(crop.bottom, self.outer_size.height - 1)
        if last - first < 2:
            return super().render_lines(crop)
        left, width = crop.x, crop.width
        above = super().render_lines(Region(left, crop.y, width, first + 1 - crop.y))
        below = Region(left, last, width, crop.bottom - last)
        return [
            *above,
            *[above[-1]] * (last - first - 1),
            *(super().render_lines(below) if below else ()),
        ]

    def watch_has_focus(self, focused: bool) -> None:
        """The border shows it; no style is for `:focus`, and Textual would look for some."""

    @property
    def operated(self) -> Widget:
        """What a person expects to operate in this panel."""
        return self

    def take_focus(self) -> None:
        """Focus it at once: keys may follow. The screen shows the whole panel, when it is asked."""
        operated = self if self.can_focus else self.operated
        self.screen.set_focus(operated, scroll_visible=False)
        if isinstance(operated, Rows):
            operated.show_cursor()
