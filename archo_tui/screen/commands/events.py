"""The commands of Events and of History."""

from __future__ import annotations

from archo_tui.screen.commands.base import IN_PANEL, Command, Desk, file_writer
from archo_tui.screen.dialog import AskPath, ShowText
from archo_tui.screen.widgets.events_panel import EventsPanel, event_details, events_as_text


class _InEvents(Command):
    in_replay = True
    where, panel = IN_PANEL, EventsPanel


class NextLevel(_InEvents):
    id, key = "level", "l"
    help = "Choose the lowest level of the events that are shown"

    def run(self, desk: Desk) -> None:
        desk.main.events.next_level()


class SearchEvents(_InEvents):
    id, key = "search", "slash"
    help = "Search the events: shows those whose source or text contains your text"

    def run(self, desk: Desk) -> None:
        desk.main.events.search.open()


class _OfEvent(_InEvents):
    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.main.events.selected else "no event is selected"


class CopyCommand(_OfEvent):
    id, key = "copy_command", "y"
    help = "Copy the ros2 command of the selected event; or its text if it has none"

    def run(self, desk: Desk) -> None:
        event = desk.main.events.selected
        assert event is not None
        desk.copy_to_clipboard(event.command or event.text)
        what = "the command" if event.command else "the text: this event has no command"
        desk.show_message(event.command or event.text, title=f"Copied {what}")


class ToggleFullScreen(_InEvents):
    id, key = "full_screen", "e"
    help = "Show the events on the full screen, or leave it"

    def run(self, desk: Desk) -> None:
        desk.main.toggle_full(desk.main.events)


class SaveEvents(_InEvents):
    id, key = "save_events", "ctrl+s"
    help = "Save the events that are shown to a file"

    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.main.events.shown else "no event is shown"

    def run(self, desk: Desk) -> None:
        text = events_as_text(desk.main.events.shown)
        write = file_writer(desk, text, "save events")
        title = "Save the events that are shown"
        desk.open(AskPath(title, "Text file", "events.txt", write, writes=True))


class ShowEvent(_OfEvent):
    id, key = "whole_event", "enter"
    help = "Show the selected event in full"

    def run(self, desk: Desk) -> None:
        event = desk.main.events.selected
        assert event is not None
        desk.open(ShowText("Event", event_details(event)))


class ShowHistory(Command):
    in_replay = True
    id, key, verbs = "history", "h", ("history",)
    help = "Show the history on the full screen, or leave it"

    def run(self, desk: Desk) -> None:
        desk.main.toggle_full(desk.main.history)


class ChangeSpan(Command):
    """A command that shows the next longer (1) or shorter (-1) time span of the history."""

    in_replay = True

    def __init__(self, by: int) -> None:
        self._by = by
        self._word, self._most = ("longer", "longest") if by > 0 else ("shorter", "shortest")
        self.id = self._word
        self.key = "right_square_bracket" if by > 0 else "left_square_bracket"
        self.help = f"Show a {self._word} time in the history: 1 min, 10 min or an hour"

    def disabled_reason(self, desk: Desk) -> str:
        history = desk.main.history
        if not history.display:
            return f"the history is not shown: press {desk.view.key('history')}"
        return "" if history.can_change_span(self._by) else f"already the {self._most} span"

    def run(self, desk: Desk) -> None:
        desk.main.history.change_span(self._by)
        desk.update_screen()
