"""The button that all panels and dialogs use, one line high."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, cast

from textual import widgets
from textual.strip import Strip

_LINE_PAD = 2  # Cells around the label, as `line-pad: 1` below has it on either side.


class RunsCommands(Protocol):
    """The part of the app that a button uses."""

    def action_command(self, name: str) -> None:
        """Run a command by its id, or say why it cannot run."""


class Button(widgets.Button, inherit_css=False):
    """A button that calls a function or runs a command at once, where Textual's posts a message.

    It has none of the fifty-seven CSS rules of Textual's button, each of which every style lookup
    evaluates.
    """

    DEFAULT_CSS = """
        Button {
            width: auto; min-width: 16; height: 1; line-pad: 1; text-align: center;
            content-align: center middle; pointer: pointer;
        }
        Button:focus { background-tint: $foreground 5%; }
        Button:disabled { text-opacity: 0.6; pointer: not-allowed; }
        Button.-active { tint: $background 30%; }
    """

    def __init__(
        self, label: str, does: str | Callable[[], object], *, id: str, disabled: bool = False
    ) -> None:
        super().__init__(label, id=id, disabled=disabled, compact=True)
        self._does = does

    def render_line(self, y: int) -> Strip:
        """Render the button, blank if it is too narrow for a label: there Textual fails."""
        if self.size.width <= _LINE_PAD:
            return Strip.blank(self.size.width, self.rich_style)
        return super().render_line(y)

    def press(self) -> Button:
        """Run the command or call the function at once; nothing if disabled or hidden."""
        super().press()
        if not self.disabled and self.display:
            if isinstance(self._does, str):
                cast("RunsCommands", self.app).action_command(self._does)
            else:
                self._does()
        return self
