"""A numbered panel with its title above and its keys below."""

from __future__ import annotations

from collections.abc import Sequence

from textual.containers import Container
from textual.markup import escape
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Button

from archo_tui.station import View
from archo_tui.widgets.shown import Shown


class Panel(Container):
    """Base of the seven panels; `show` gets every new view."""

    number = 0
    title_text = ""
    keys: Sequence[tuple[str, str]] = ()  # (command, word) for the border below

    class Resized(Message):
        """What it shows may be for another width."""

        def __init__(self, panel: Panel) -> None:
            super().__init__()
            self.panel = panel

    def __init__(self) -> None:
        super().__init__(id=f"panel-{self.number}", classes="panel")
        self.border_title = f"{self.number} {self.title_text}"
        self._below = ""
        self._marked = ""  # the colour of its border while it has the focus

    def on_resize(self) -> None:
        self.post_message(self.Resized(self))

    def show(self, view: Shown) -> None:
        """Show what changed."""
        raise NotImplementedError

    def show_keys(self, view: Shown, before: str = "") -> None:
        """Write the keys on the border, as many as there is room for; each can be clicked.

        Those of commands that cannot run now are darker; pressed, they say why.
        """
        room = self.size.width - 4
        parts = [(before, before)] if before else []
        for command, word in self.keys:
            text = f"{view.key(command)} {word}"
            shown = text.replace("[", "\\[")  # the key itself may be one
            markup = f"[@click=app.command('{command}')]{shown}[/]"
            parts.append((text, f"[$off]{markup}[/]" if command in view.blocked else markup))
        while parts and sum(len(text) + 3 for text, _ in parts) - 3 > room:
            parts.pop()
        below = "   ".join(markup for _, markup in parts)
        if below != self._below:
            self._below = below
            self.border_subtitle = below

    def show_publishers(self, view: View, topic: str) -> None:
        """Name them in the title when there are several: their readings come mixed."""
        names = view.snapshot.publishers.get(topic, ())
        more = f"   {len(names)} publishers: {', '.join(names)}" if names else ""
        title = escape(f"{self.number} {self.title_text}{more}")
        if title != self.border_title:
            self.border_title = title

    def grey(self, view: View, buttons: Sequence[tuple[str, Button]]) -> None:
        """Dim the button of each service that nobody offers, or another; pressed, it says so."""
        snapshot = view.snapshot
        for service, button in buttons:
            missing = service not in snapshot.offered or service in snapshot.faults
            button.set_class(missing, "-blocked")

    def mark_focused(self, has_focus: bool) -> None:
        """Show by the border whether it has the focus, or what it contains."""
        colour = self.app.theme_variables["primary"] if has_focus else ""
        if colour != self._marked:
            self._marked = colour
            self.styles.border = ("heavy", colour) if colour else None

    def watch_has_focus(self, focused: bool) -> None:
        """The border shows it; no style is for `:focus`, and Textual would look for some."""

    @property
    def operated(self) -> Widget:
        """What a person expects to operate in this panel."""
        return self

    def take_focus(self) -> None:
        """Focus it at once: keys may follow. The screen shows the whole panel, when it is asked."""
        self.screen.set_focus(self.operated, scroll_visible=False)
