"""The command palette, Textual's own."""

from __future__ import annotations

from contextlib import suppress
from typing import Literal

from textual import events
from textual.app import ComposeResult
from textual.await_complete import AwaitComplete
from textual.command import CommandList, CommandPalette
from textual.css.query import NoMatches
from textual.errors import NoWidget
from textual.message import Message
from textual.widgets import Input

from archo_tui.screens.dialog import Below, Leaving


class Commands(CommandList):
    """Textual's list fails on options and lines that it has no more, or not yet."""

    async def _on_click(self, event: events.Click) -> None:
        event.prevent_default()  # Textual would call its own as well
        with suppress(LookupError):
            await super()._on_click(event)

    def _move_page(self, direction: Literal[-1, 1]) -> None:
        with suppress(LookupError):
            super()._move_page(direction)


class Palette(CommandPalette, Leaving[None]):
    """Its cursor stands still: a blinking one is traffic over SSH."""

    closes_at_stop = True

    def compose(self) -> ComposeResult:
        for widget in super().compose():
            yield Commands() if isinstance(widget, CommandList) else widget
        yield Below()

    def on_mount(self) -> None:
        self.query_one(Input).cursor_blink = False

    def dismiss(self, result: None = None) -> AwaitComplete:
        """Also by a STOP, in the midst of a search."""
        self._cancel_gather_commands()
        self._stop_no_matches_countdown()
        return super().dismiss(result)

    async def _dispatch_message(self, message: Message) -> None:
        """What still comes may be for parts that have gone."""
        try:
            await super()._dispatch_message(message)
        except NoMatches:
            if not self.has_left:
                raise

    async def _watch__show_busy(self) -> None:
        if not self.has_left:
            await super()._watch__show_busy()

    def _on_click(self, event: events.Click) -> None:  # type: ignore[override]
        event.prevent_default()
        with suppress(NoWidget):  # the terminal has shrunk since
            super()._on_click(event)
