"""Commands of the events' panel."""

from __future__ import annotations

from typing import TYPE_CHECKING

from archo_tui.commands.base import EVENTS, IN_PANEL, Command
from archo_tui.screens.text import ShowText
from archo_tui.widgets.events_panel import details

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp


class _InEvents(Command):
    where, panel = IN_PANEL, EVENTS


class Level(_InEvents):
    """Show events of more or fewer levels."""

    id, key = "level", "l"

    def run(self, app: ArchoApp) -> None:
        app.main.events.next_level()


class Search(_InEvents):
    """Show only events with these letters in their source or text."""

    id, key = "search", "slash"

    def run(self, app: ArchoApp) -> None:
        app.main.events.search.open()


class CopyCommand(_InEvents):
    """Copy the ros2 command of the selected event, or of your last one."""

    id, key = "copy_command", "y"

    def _command(self, app: ArchoApp) -> str:
        selected = app.main.events.selected
        if selected is not None and selected.command:
            return selected.command
        return next((e.command for e in reversed(app.view.snapshot.events) if e.command), "")

    def blocked(self, app: ArchoApp) -> str:
        return "" if self._command(app) else "no command was given yet"

    def run(self, app: ArchoApp) -> None:
        command = self._command(app)
        app.copy_to_clipboard(command)
        app.notify(command, title="Copied", markup=False)


class FullScreen(_InEvents):
    """Show the events on the full screen, and back."""

    id, key = "full_screen", "e"

    def run(self, app: ArchoApp) -> None:
        app.main.toggle_events()


class WholeEvent(_InEvents):
    """Show the selected event in full."""

    id, key = "whole_event", "enter"

    def blocked(self, app: ArchoApp) -> str:
        return "" if app.main.events.selected else "no event is selected"

    def run(self, app: ArchoApp) -> None:
        event = app.main.events.selected
        assert event is not None
        app.push_screen(ShowText("Event", details(event)))
