"""Panel 6: what the nodes log and what the operator did, newest first."""

from __future__ import annotations

import textwrap

from rich.segment import Segment
from rich.style import Style
from textual.app import ComposeResult
from textual.geometry import Region, Size
from textual.scroll_view import ScrollView
from textual.strip import Strip

from archo_tui.clock import time_of_day
from archo_tui.robot.state import Event
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.view import View

LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")
_CYCLE = ("WARN", "INFO", "DEBUG", "ERROR")
_ONE_LINE = 70  # columns from which an event stands on one line
_MEASURED = 100  # newest lines whose length decides how far the list scrolls sideways


def is_shown(event: Event, level: str) -> bool:
    """True for the operator's own, and from `level` up."""
    return event.level == "YOU" or LEVELS.index(event.level) >= LEVELS.index(level)


def event_lines(event: Event, width: int) -> list[str]:
    """`12:04:31  WARN   dashboard         Low battery: 18.0%`, wrapped where that is too wide."""
    count = f"  x {event.count}" if event.count > 1 else ""
    command = f"   $ {event.command}" if event.command else ""
    text = f"{event.text}{count}{command}"
    if width >= _ONE_LINE:
        return [f"{time_of_day(event.time)}  {event.level:<5}  {event.source:<16}  {text}"]
    head = f"{time_of_day(event.time)} {event.level:<5} {event.source}"
    wrapped = textwrap.wrap(text, max(width - 2, 10), subsequent_indent="  ")
    return [head, *(f"  {line}" for line in wrapped)]


class EventList(ScrollView, can_focus=True):
    """Draws only the lines that are seen."""

    def __init__(self) -> None:
        super().__init__(id="event-list")
        self._events: list[Event] = []
        self._lines: list[tuple[str, Style]] = []

    def show(self, events: list[Event]) -> None:
        """Show these, newest first."""
        if events != self._events:
            self._events = events
            self._lay_out()

    def on_resize(self) -> None:
        self._lay_out()

    def _lay_out(self) -> None:
        width, old = self.size.width, self._lines
        self._lines = [
            (line, _style(event)) for event in self._events for line in event_lines(event, width)
        ]
        longest = max((len(line) for line, _ in self._lines[:_MEASURED]), default=0)
        size = Size(longest, len(self._lines))
        if size != self.virtual_size or len(old) != len(self._lines):
            self.virtual_size = size
            self.refresh()
            return
        top = int(self.scroll_offset.y)
        for row in range(top, min(top + self.size.height, len(old))):
            if old[row] != self._lines[row]:  # mostly one line, whose count has grown
                self.refresh(Region(0, row - top, width, 1))

    def render_line(self, y: int) -> Strip:
        row = y + self.scroll_offset.y
        width = self.size.width
        if not self._lines and y == 0:
            return self._strip("Nothing to report.", Style(dim=True), width)
        if row >= len(self._lines):
            return Strip.blank(width, self.rich_style)
        return self._strip(*self._lines[row], width)

    def _strip(self, text: str, style: Style, width: int) -> Strip:
        strip = Strip([Segment(text, self.rich_style + style)])
        left = self.scroll_offset.x
        return strip.crop_extend(left, left + width, self.rich_style)


def _style(event: Event) -> Style:
    return Style(bold=event.level in ("WARN", "ERROR", "FATAL"), dim=event.level == "DEBUG")


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
