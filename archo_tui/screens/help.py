"""All keys, from the one registry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog

if TYPE_CHECKING:
    from archo_tui.commands.base import Command

_USUAL = "not while typing"  # the introduction says it for all

_INTRODUCTION = (
    "STOP is a software stop: it does not replace the hardware emergency stop. "
    "tab moves on, enter presses or edits, esc leads out; while you type, letters are text."
)


class Help(Dialog[None]):
    """One line a command, with the reason when it cannot run now."""

    BINDINGS = [("escape,question_mark,q", "close", "Close")]

    def __init__(
        self,
        commands: Sequence[Command],
        blocked: Callable[[Command], str],
        key: Callable[[str], str],
    ) -> None:
        """`blocked(command)` says why one cannot run now, `key(id)` how its key reads."""
        super().__init__()
        self._commands, self._blocked, self._key = commands, blocked, key

    def compose(self) -> ComposeResult:
        with VerticalScroll(classes="dialog keys") as box:
            box.border_title = "Keys"
            box.border_subtitle = "esc close"
            yield Static(Content(_INTRODUCTION))
            for command in self._commands:
                yield Static(self._line(command))

    def _line(self, command: Command) -> Content:
        reason = self._blocked(command)
        key = Content.styled(f"{self._key(command.id):>5}", "dim" if reason else "bold")
        place = "" if command.where == _USUAL else f" ({command.place})"
        text = f"  {command.help}{place}"
        if reason:
            return Content.assemble(key, (f"{text}: {reason}", "dim"))
        return Content.assemble(key, text)
