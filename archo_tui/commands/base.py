"""What a command is."""

from __future__ import annotations

from collections.abc import Coroutine
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp

EVERYWHERE, NOT_TYPING, IN_PANEL = "everywhere", "not while typing", "in the panel"
PANELS = ("Battery", "Motor", "Go to shelf", "Parameters", "Nodes", "Events")
PARAMETERS, NODES, EVENTS = 4, 5, 6


class Command:
    """One thing the operator can do. A command's docstring is its help."""

    id: ClassVar[str]
    key: ClassVar[str]  # Textual's name of the key, when the keymap names no other
    footer: ClassVar[str] = ""  # one word; empty: not in the footer
    footer_key: ClassVar[str] = ""  # the key in the footer where it stands for several
    where: ClassVar[str] = NOT_TYPING
    panel: ClassVar[int] = 0  # the panel's number, for IN_PANEL
    service: ClassVar[str] = ""  # what somebody must offer
    runs_blocked: ClassVar[bool] = False  # says why, and does its harmless part all the same

    @property
    def help(self) -> str:
        """One sentence for `?` and the palette."""
        return (self.__doc__ or "").rstrip(".")

    @property
    def place(self) -> str:
        """Where the key works, in words."""
        return f"in {PANELS[self.panel - 1]}" if self.where == IN_PANEL else self.where

    def blocked(self, app: ArchoApp) -> str:
        """Why the command cannot run now, or an empty string."""
        if self.service and self.service not in app.view.snapshot.offered:
            return f"{self.service} is not offered by any node"
        return ""

    def run(self, app: ArchoApp) -> Coroutine[Any, Any, None] | None:
        """Do it at once, or return a coroutine that may wait for the robot."""
        raise NotImplementedError
