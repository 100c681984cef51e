"""The one kind of button: a line high."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, cast

from textual import widgets


class RunsCommands(Protocol):
    """The app, as a button knows it."""

    def action_command(self, name: str) -> None:
        """Run a command by its id."""


class Button(widgets.Button, inherit_css=False):
    """Textual's, which does by a call what it is for.

    It has none of its fifty-seven rules: every style that is looked up asks them all.
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
        """Create a button; `does` is the id of a command, or what is called."""
        super().__init__(label, id=id, disabled=disabled, compact=True)
        self._does = does

    def press(self) -> Button:
        """Do what it is for, now: Textual would post a message, or call later."""
        if not self.disabled and self.display:
            self._start_active_affect()
            if isinstance(self._does, str):
                cast("RunsCommands", self.app).action_command(self._does)
            else:
                self._does()
        return self
