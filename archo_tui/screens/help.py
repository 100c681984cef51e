"""All keys, from the one registry: by where they work, found by typing."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog
from archo_tui.station.station import View
from archo_tui.widgets.field import Field

_INTRODUCTION = (
    "STOP is a software stop: it does not replace the hardware emergency stop. "
    "tab moves on, enter presses or edits, esc leads out; while you type, letters are text."
)
_COLUMN = 52  # cells from which a column is worth having
_GAP = 3  # cells between two


class Entry(NamedTuple):
    """What is said about one key."""

    section: str  # where it works
    key: str
    help: str
    reason: str  # why it cannot run now, or empty


class Help(Dialog[None]):
    """One line a command, the reason below it when it cannot run now."""

    BINDINGS = [
        ("escape", "close", "Close"),
        ("pageup", "scroll(-1)", "Scroll up"),
        ("pagedown", "scroll(1)", "Scroll down"),
    ]

    def __init__(self, list_entries: Callable[[], Sequence[Entry]]) -> None:
        """Create it; `list_entries` is called again while it is open: reasons come and go."""
        super().__init__()
        self._list_entries = list_entries
        self._entries = entries = list_entries()
        self._scroll = VerticalScroll(can_focus=False)
        self._part = Field(
            id="narrow",
            placeholder="type a part of a key's or a command's name",
            changed=self._draw,
            stepped=lambda step: self._scroll.scroll_relative(y=step, animate=False),
        )
        self._key = max((cell_len(entry.key) for entry in entries), default=0)  # cells
        self._columns = Static(classes="column"), Static(classes="column")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog keys") as box:
            box.border_title = "Keys"
            box.border_subtitle = "type to search   ↑ ↓ scroll   esc close"
            yield self._part
            with self._scroll:
                yield Static(_INTRODUCTION)
                with Horizontal(classes="columns"):
                    yield from self._columns

    def on_mount(self) -> None:
        self.set_focus(self._part)

    def on_resize(self) -> None:
        self.call_after_refresh(self._draw)

    def follow(self, view: View) -> None:
        """Bring the reasons up to date."""
        entries = self._list_entries()
        if entries != self._entries:
            self._entries = entries
            self._draw()

    def action_scroll(self, pages: int) -> None:
        """By what is seen."""
        page = max(self._scroll.size.height - 1, 1)
        self._scroll.scroll_relative(y=pages * page, animate=False)

    def _draw(self) -> None:
        wanted = self._part.value.strip().casefold()
        shown = [e for e in self._entries if wanted in f"{e.key} {e.help}".casefold()]
        width = self._scroll.size.width - 1
        count = 2 if width >= 2 * _COLUMN + _GAP else 1
        room = max((width - _GAP * (count - 1)) // count, 1)
        columns = _columns(self._sections(shown, room), count)
        for place, column in enumerate(self._columns):
            column.display = place < count
            column.update(Content("\n").join(columns[place]) if place < count else "")

    def _sections(self, entries: Iterable[Entry], width: int) -> list[list[Content]]:
        """The lines of each section, with its name above."""
        found: dict[str, list[Content]] = {}
        for entry in entries:
            name = Content.styled(entry.section, "bold")
            found.setdefault(entry.section, [Content(""), name]).extend(self._lines(entry, width))
        return list(found.values())

    def _lines(self, entry: Entry, width: int) -> list[Content]:
        room = max(width - self._key - 3, 10)
        quiet = "$quiet" if entry.reason else ""
        first, *more = textwrap.wrap(entry.help, room)
        key = (" " * (self._key - cell_len(entry.key)) + entry.key, quiet or "bold")
        lines = [Content.assemble(" ", key, (f"  {first}", quiet))]
        margin = " " * (self._key + 3)
        lines += [Content.styled(margin + line, quiet) for line in more]
        if entry.reason:
            said = textwrap.wrap(f"not now: {entry.reason}", room)
            lines += [Content.styled(margin + line, quiet) for line in said]
        return lines


def _columns(blocks: Sequence[list[Content]], count: int) -> list[list[Content]]:
    """The blocks one below the other, in columns about as high as each other."""
    half = sum(map(len, blocks)) / count
    columns: list[list[Content]] = [[]]
    for block in blocks:
        if len(columns) < count and len(columns[-1]) + len(block) / 2 > half:
            columns.append([])
        columns[-1] += block
    return columns + [[]] * (count - len(columns))
