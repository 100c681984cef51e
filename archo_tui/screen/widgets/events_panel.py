"""The panel of events: what the nodes log and what the operator did, newest first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import datetime

from textual.app import ComposeResult

from archo_tui.base.clock import time_of_day
from archo_tui.robot.state.events import OWN_LEVELS, Event
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.screen.widgets.field import Search
from archo_tui.screen.widgets.panel import FULL_SCREEN, ListPanel, ScreenState
from archo_tui.screen.widgets.rows import Rows
from archo_tui.text.columns import QUIET, Columns, Text
from archo_tui.text.event import is_of_own_file, one_line_text, outcome_glyph
from archo_tui.text.state import with_short_types

LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")
_CYCLE = ("WARN", "INFO", "DEBUG", "ERROR")
_WIDE = 70  # Cells from which sources are shown.
_NO_EVENTS = "Nothing to report."
_STYLES = {"WARN": "bold $warn", "ERROR": "bold $bad", "FATAL": "bold $bad", "DEBUG": QUIET}


def is_shown(event: Event, level: str, hosted: Sequence[Hosted]) -> bool:
    """Return True for what people, assistants and goals did, and for log lines from a level up.

    At WARN, lines at INFO of the user's own nodes are shown, too.
    """
    if event.level in OWN_LEVELS or LEVELS.index(event.level) >= LEVELS.index(level):
        return True
    return level == "WARN" and event.level == "INFO" and is_of_own_file(event, hosted)


def event_lines(event: Event, width: int, _columns: Columns) -> list[Text]:
    """Return `12:04:31  ▲  dashboard: Low battery: 18.0%   x 12 since 12:03:20`."""
    at, text = time_of_day(event.time), one_line_text(event)
    is_wide = width >= _WIDE
    if is_wide and event.source != "console" and event.level != "GOAL":
        text = f"{'shell ' if event.level == 'SHELL' else ''}{event.source}: {text}"
    if event.count > 1:
        text += f"   {repeat_text(event)}" if is_wide else f"   x {event.count}"
    gap = "  " if is_wide else " "
    line = f"{at}{gap}{outcome_glyph(event)}{gap}{text}"
    line = with_short_types(line) if len(line) > width else line
    return [(line, _STYLES.get(event.level, ""))]


def repeat_text(event: Event) -> str:
    """Return how often an event occurred, the first time included: `x 12 since 12:03:20`."""
    return f"x {event.count} since {time_of_day(event.first)}"


def event_details(event: Event) -> str:
    """Return an event in lines: time, level, source and repeats; its text; its ros2 command."""
    count = f"  {repeat_text(event)}" if event.count > 1 else ""
    lines = [f"{time_of_day(event.time)}  {event.level}  {event.source}{count}", "", event.text]
    return "\n".join([*lines, "", f"$ {event.command}"] if event.command else lines)


def events_as_text(events: Iterable[Event]) -> str:
    """Return events for a file, a line each, with local date, repeats and ros2 command."""
    lines = []
    for event in events:
        at = datetime.fromtimestamp(event.time).isoformat(" ", "milliseconds")
        command = f"   $ {event.command}" if event.command else ""
        count = f"   {repeat_text(event)}" if event.count > 1 else ""
        lines.append(
            f"{at}  {event.level:<5}  {event.source}  {one_line_text(event)}{count}{command}\n"
        )
    return "".join(lines)


class EventsPanel(ListPanel[Event]):
    """The list of events, newest first, from a level up, with a search."""

    title_text, verbs = "Events", ("events",)
    keys = (
        ("level", "level"),
        ("search", "search"),
        ("whole_event", "open"),
        ("full_screen", FULL_SCREEN),
        ("copy_command", "copy"),
        ("save_events", "save"),
    )

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self._level = _CYCLE[0]
        self._events: tuple[Event, ...] = ()
        self._hosted: tuple[Hosted, ...] = ()
        self.rows: Rows[Event] = Rows(
            event_lines,
            lambda event: event.number,
            id="event-list",
            empty=_NO_EVENTS,
            action="app.command('whole_event')",
        )
        self.search = Search(self.rows, self._refill)

    def compose(self) -> ComposeResult:
        yield self.rows
        yield self.search.line

    @property
    def shown(self) -> Sequence[Event]:
        """Return the events that level and search leave, the oldest first."""
        return self.rows.items[::-1]

    def show(self, view: ScreenState) -> None:
        own = " and nodes" if self._level == "WARN" and any(n.file for n in view.hosted) else ""
        level = "warnings" if self._level == "WARN" else f"{self._level} and above"
        self.show_keys(view, f"{level} + your commands{own}")
        if view.snapshot.events is not self._events:
            self._events, self._hosted = view.snapshot.events, view.hosted
            self._refill()

    def next_level(self) -> None:
        """Show the events of the next level: from WARN to INFO, DEBUG, ERROR, and WARN again."""
        self._level = _CYCLE[(_CYCLE.index(self._level) + 1) % len(_CYCLE)]
        self._refill()

    def _refill(self) -> None:
        matches, typed = self.search.matches, self.search.search_text
        at = f" at {self._level} and above."
        nothing = f"Nothing contains {typed}{at}" if typed else _NO_EVENTS[:-1] + at
        latest = reversed(self._events)
        at_level = [event for event in latest if is_shown(event, self._level, self._hosted)]
        shown = [event for event in at_level if matches(event.source, event.text)]
        level = f"{self._level} and above" if self._level == _CYCLE[-1] else ""
        self.show_narrowed(level, self.search.show_count(len(shown), len(at_level)))
        self.rows.show(shown, nothing if self._events else _NO_EVENTS)
