"""The board: every number that a goal can be, in a grid. To choose one types it, and no more."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import Binding
from textual.geometry import Region
from textual.strip import Strip

from archo_tui.widgets.by_lines import ByLines
from archo_tui.widgets.rows import crop
from archo_tui.widgets.styled import rich_style
from archo_tui.words.board import Grid, Mark
from archo_tui.words.state import ACTIVE, OLD

_NOTHING = Mark()


class Board(ByLines, can_focus=True):
    """Draws only the lines that changed. The arrows move the cursor, over pages too."""

    DEFAULT_CSS = "Board { width: 1fr; height: auto; display: none; }"

    KEYS = ("left", "right", "up", "down", "pageup", "pagedown", "home", "end")
    BINDINGS = [
        Binding("enter", "take", show=False),
        *(Binding(key, f"press('{key}')", show=False) for key in KEYS),
    ]

    def __init__(self, take: Callable[[int], None], moved: Callable[[], None]) -> None:
        """`take(number)` is called with what was chosen, `moved()` when the focus came or went."""
        super().__init__(id="board")
        self._take, self._moved = take, moved
        self._grid = Grid(range(1, 2), 1, 1)
        self._marks: Mapping[int, Mark] = {}
        self._place = 0  # of the cursor, in the numbers

    @property
    def rows(self) -> int:
        """How high it is: the grid, and a line that says which page it is."""
        return self._grid.rows + (self._grid.pages > 1)

    def show(self, grid: Grid, marks: Mapping[int, Mark]) -> None:
        """Show this."""
        before, self._marks = self._marks, marks
        if grid != self._grid:
            number = self._grid.numbers[self._place]  # the cursor stays with it
            self._grid = grid
            there = number in grid.numbers
            last = len(grid.numbers) - 1
            self._place = grid.numbers.index(number) if there else min(self._place, last)
            self.styles.height = self.rows
            self.refresh()
        elif marks != before:
            numbers = before.keys() | marks.keys()
            changed = [n for n in numbers if before.get(n) != marks.get(n)]
            self._draw(*(grid.numbers.index(n) for n in changed if n in grid.numbers))

    def action_press(self, key: str) -> None:
        """Move the cursor by one of KEYS; beyond an end it stays."""
        grid, last = self._grid, len(self._grid.numbers) - 1
        by = {"left": -1, "right": 1, "up": -grid.columns, "down": grid.columns}
        by |= {"pageup": -grid.page, "pagedown": grid.page, "home": -self._place, "end": last}
        wanted = self._place + by[key]
        if key not in ("up", "down") or 0 <= wanted <= last:  # else its column has no more
            self._move(min(max(wanted, 0), last))

    def action_take(self) -> None:
        """Choose the number under the cursor."""
        self._take(self._grid.numbers[self._place])

    def on_click(self, event: events.Click) -> None:
        place = self._grid.at(self._first, event.x // self._grid.cell, event.y)
        if place is not None and event.chain == 1:  # the second of a double click is the same wish
            self._move(place)
            self.action_take()

    def on_mouse_scroll_down(self) -> None:
        self.action_press("pagedown")

    def on_mouse_scroll_up(self) -> None:
        self.action_press("pageup")

    def watch_has_focus(self, focused: bool) -> None:
        """Show or hide the cursor; no style is for `:focus`, and Textual would look for some."""
        self._draw(self._place)
        self._moved()

    @property
    def _first(self) -> int:
        """The place of the first number on the page of the cursor."""
        return self._place // self._grid.page * self._grid.page

    def _move(self, place: int) -> None:
        before, first = self._place, self._first
        self._place = place
        if self._first != first:
            self.refresh()
        else:
            self._draw(before, place)

    def _draw(self, *places: int) -> None:
        """Draw the lines with these numbers, as far as they are seen."""
        grid, first = self._grid, self._first
        rows = {(place - first) // grid.columns for place in places}
        for row in rows & {*range(grid.rows)}:
            self.refresh(Region(0, row, self.size.width, 1))

    def render_line(self, y: int) -> Strip:
        grid, width, base = self._grid, self.size.width, self.base
        if y >= grid.rows:
            style = base + rich_style(OLD, self.app.theme_variables)
            segments = [Segment(crop(self._below(), width), style)]
        else:
            places = (grid.at(self._first, column, y) for column in range(grid.columns))
            cells = (self._cell(place, base) for place in places if place is not None)
            segments = [segment for cell in cells for segment in cell]
        return Strip(segments).adjust_cell_length(width, base)

    def _cell(self, place: int, base: Style) -> tuple[Segment, Segment]:
        number = self._grid.numbers[place]
        mark = self._marks.get(number, _NOTHING)
        tones = (ACTIVE, mark.tone)
        before, style = (base + rich_style(tone, self.app.theme_variables) for tone in tones)
        if self.has_focus and place == self._place:
            before = style = base + Style(reverse=True)
        head = mark.before.rjust(self._grid.digits + 1 - len(str(number)))
        return Segment(head, before), Segment(f"{number}{mark.behind}", style)

    def _below(self) -> str:
        """Which page it is."""
        grid, first = self._grid, self._first
        last = min(first + grid.page, len(grid.numbers)) - 1
        shown = f" {grid.numbers[first]} .. {grid.numbers[last]} of {grid.numbers[-1]}"
        page = f"page {first // grid.page + 1} of {grid.pages}"
        return f"{shown}   {page}   pgup, pgdn"
