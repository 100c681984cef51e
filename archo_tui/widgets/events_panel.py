"""Panel 6: what the nodes log and what the operator did, newest first."""

from __future__ import annotations

from rich.segment import Segment
from rich.style import Style
from textual.app import ComposeResult
from textual.geometry import Size
from textual.scroll_view import ScrollView
from textual.strip import Strip

from archo_tui.clock import time_of_day
from archo_tui.robot.state import Event
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.view import View

LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")
_CYCLE = ("WARN", "INFO", "DEBUG", "ERROR")


def is_shown(event: Event, level: str) -> bool:
    """True for the operator's own, and from `level` up."""
    return event.level == "YOU" or LEVELS.index(event.level) >= LEVELS.index(level)


def event_line(event: Event) -> str:
    """`12:04:31  WARN   dashboard         Low battery: 18.0%`."""
    count = f"  x {event.count}" if event.count > 1 else ""
    command = f"   $ {event.command}" if event.command else ""
    head = f"{time_of_day(event.time)}  {event.level:<5}  {event.source:<16}"
    return f"{head}  {event.text}{count}{command}"


class EventList(ScrollView, can_focus=True):
    """Draws only the lines that are seen."""

    def __init__(self) -> None:
        super().__init__(id="event-list")
        self._events: list[Event] = []

    def show(self, events: list[Event]) -> None:
        """Show these, newest first."""
        if events != self._events:
            self._events = events
            width = max((len(event_line(event)) for event in events[:100]), default=0)
            self.virtual_size = Size(width, len(events))
            self.refresh()

    def render_line(self, y: int) -> Strip:
        row = y + self.scroll_offset.y
        width = self.size.width
        if not self._events and y == 0:
            return self._strip("Nothing to report.", Style(dim=True), width)
        if row >= len(self._events):
            return Strip.blank(width, self.rich_style)
        event = self._events[row]
        style = Style(bold=event.level in ("WARN", "ERROR", "FATAL"), dim=event.level == "DEBUG")
        return self._strip(event_line(event), style, width)

    def _strip(self, text: str, style: Style, width: int) -> Strip:
        strip = Strip([Segment(text, self.rich_style + style)])
        left = self.scroll_offset.x
        return strip.crop_extend(left, left + width, self.rich_style)


class EventsPanel(Panel):
    """The list, and the level from which it shows."""

    number, title_text = 6, "Events"

    def __init__(self) -> None:
        super().__init__()
        self._level = _CYCLE[0]
        self._seen: tuple[Event, ...] = ()
        self._say_level()

    def compose(self) -> ComposeResult:
        yield EventList()

    def take_focus(self) -> None:
        self.screen.set_focus(self.query_one(EventList))

    def show(self, view: View) -> None:
        if view.snapshot.events is not self._seen:
            self._seen = view.snapshot.events
            self._fill()

    def next_level(self) -> None:
        """More, all, then only the worst."""
        self._level = _CYCLE[(_CYCLE.index(self._level) + 1) % len(_CYCLE)]
        self._say_level()
        self._fill()

    def _say_level(self) -> None:
        self.border_subtitle = f"{self._level} and above, and yours   l level"

    def _fill(self) -> None:
        shown = [event for event in reversed(self._seen) if is_shown(event, self._level)]
        self.query_one(EventList).show(shown)
