"""The dialog that lists all keys by where they work, and searches them by typing."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screen.commands.base import EVERYWHERE, NOT_TYPING, Command, Desk, PanelKey
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.widgets.field import Field
from archo_tui.screen.widgets.panel import Panel
from archo_tui.station.view import View


class ShowHelp(Command):
    in_replay = True
    id, key, footer = "help", "question_mark", "Help"
    help = "Show the keys of the panel with the focus, and below them all others"

    def run(self, desk: Desk) -> None:
        front = desk.screen
        if isinstance(front, Help):
            front.dismiss()
            return
        panel = desk.main.panel_with_focus if front is desk.main else None
        desk.open(Help(desk, panel))


_INTRODUCTION = (
    "STOP is a software stop: it does not replace the hardware emergency stop. "
    "tab moves the focus, enter presses or edits, esc leaves; while you type, letters are text."
)
_MIN_COLUMN = 52  # Cells; where two columns would have fewer, there is one.
_GAP = 3  # Cells between two columns.


class Entry(NamedTuple):
    """A key and its command."""

    section: str  # The place where the key works.
    key: str
    help: str
    works: bool  # The command can run now.


_NOW = "Now"
_FOR_A_STATE = ("release", "continue", "skip", "ack")  # Each can run in one state only.


class Help(Dialog):
    """A list of all keys, a section for each place where they work; typing searches the list."""

    BINDINGS = [
        ("escape", "close", "Close"),
        ("pageup", "scroll(-1)", "Scroll up"),
        ("pagedown", "scroll(1)", "Scroll down"),
    ]

    def __init__(self, desk: Desk, panel: Panel | None) -> None:
        """Create the dialog; the keys of `panel`, which has the focus, come first."""
        super().__init__()
        self._desk, self._panel = desk, panel
        self._entries = _help_entries(desk, panel)
        self._scroll = VerticalScroll(can_focus=False)
        self._search = Field(
            id="narrow",
            placeholder="type a part of a key's or a command's name",
            changed=self._draw,
            stepped=lambda step: self._scroll.scroll_relative(y=step, animate=False),
        )
        self._key_width = max((cell_len(entry.key) for entry in self._entries), default=0)  # Cells.
        self._columns = Static(classes="column"), Static(classes="column")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog keys") as box:
            box.border_title = "Keys"
            box.border_subtitle = "type to search   ↑ ↓ scroll   esc close"
            yield self._search
            with self._scroll:
                yield Static(_INTRODUCTION)
                with Horizontal(classes="columns"):
                    yield from self._columns

    def on_mount(self) -> None:
        self.set_focus(self._search)

    def on_resize(self) -> None:
        self.call_after_refresh(self._draw)

    def show_view(self, view: View) -> None:
        """Draw the keys again if the entries have changed, such as which of them work now."""
        entries = _help_entries(self._desk, self._panel)
        if entries != self._entries:
            self._entries = entries
            self._draw()

    def action_scroll(self, pages: int) -> None:
        """Scroll by pages, down or (with a negative number) up."""
        page = max(self._scroll.size.height - 1, 1)
        self._scroll.scroll_relative(y=pages * page, animate=False)

    def _draw(self) -> None:
        search_text = self._search.value.strip().casefold()
        shown = [e for e in self._entries if search_text in f"{e.key} {e.help}".casefold()]
        width = self._scroll.size.width - 1
        count = 2 if width >= 2 * _MIN_COLUMN + _GAP else 1
        room = max((width - _GAP * (count - 1)) // count, 1)
        columns = _columns(section_lines(shown, room, self._key_width), count)
        for index, column in enumerate(self._columns):
            column.display = index < count
            column.update(Content("\n").join(columns[index]) if index < count else "")


def _help_entries(desk: Desk, panel: Panel | None) -> list[Entry]:
    """Return all keys: first those for the state, those of the focus, and those of everywhere."""
    here = f"Here, in {panel.title_text}" if panel is not None else ""
    taken = panel.field_keys if panel is not None else ()
    entries = [Entry(here, key, word, True) for key, word in taken]
    for command in desk.registry:
        if isinstance(command, PanelKey) or not command.is_listed:
            continue
        key = desk.view.key(command.id)
        place = command.where_text if key else "in the palette only"
        place = f"{place[0].upper()}{place[1:]}"
        entry = Entry(place, key, command.help, not command.disabled_reason(desk))
        if entry.key and entry.works and command.id in _FOR_A_STATE:
            entry = entry._replace(section=_NOW)
        elif panel is not None and entry.key and command.where != EVERYWHERE:
            key = panel.other_keys.get(command.id, entry.key)
            if any(key == other for other, _ in taken):
                continue
            if command.panel is type(panel) or command.id in dict(panel.keys):
                entry = entry._replace(section=here, key=key)
        if command.id == "release":  # While stopped, that is what is asked for first.
            entries.insert(0, entry)
        else:
            entries.append(entry)
    panels = sum(isinstance(command, PanelKey) for command in desk.registry)
    entries.append(Entry(NOT_TYPING.capitalize(), f"1-{panels}", "Go to a panel", True))
    first = {_NOW: 0, here: 1, EVERYWHERE.capitalize(): 2}
    return sorted(entries, key=lambda entry: (first.get(entry.section, 3), not entry.key))


def section_lines(entries: Iterable[Entry], width: int, key_width: int) -> list[list[Content]]:
    """Return the lines of each section: a blank line, its name, and its keys."""
    sections: dict[str, list[Content]] = {}
    for entry in entries:
        name = Content.styled(entry.section, "bold")
        lines = sections.setdefault(entry.section, [Content(""), name])
        lines.extend(_entry_lines(entry, width, key_width))
    return list(sections.values())


def _entry_lines(entry: Entry, width: int, key_width: int) -> list[Content]:
    """Return a key and what its command does, wrapped; darker if it cannot run now."""
    room = max(width - key_width - 3, 10)
    quiet = "" if entry.works else "$quiet"
    first, *more = textwrap.wrap(entry.help, room)
    key = (" " * (key_width - cell_len(entry.key)) + entry.key, quiet or "bold")
    lines = [Content.assemble(" ", key, (f"  {first}", quiet))]
    return lines + [Content.styled(" " * (key_width + 3) + line, quiet) for line in more]


def _columns(blocks: Sequence[list[Content]], count: int) -> list[list[Content]]:
    """Distribute blocks of lines, none split, over columns of about the same height."""
    height = sum(map(len, blocks)) / count
    columns: list[list[Content]] = [[]]
    for block in blocks:
        if len(columns) < count and len(columns[-1]) + len(block) / 2 > height:
            columns.append([])
        columns[-1] += block
    return columns + [[]] * (count - len(columns))
