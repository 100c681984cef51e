"""The board: a grid of all numbers that a goal can take; choosing one types it, and no more."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import Binding
from textual.geometry import Region
from textual.strip import Strip

from archo_tui.widgets.line_widget import LineWidget
from archo_tui.widgets.rows import crop
from archo_tui.widgets.styled import rich_style
from archo_tui.words.board import Grid, Mark
from archo_tui.words.state import ACTIVE, OLD

_NO_MARK = Mark()


class Board(LineWidget, can_focus=True):
    """The grid of numbers, in which only the lines that changed are redrawn."""

    DEFAULT_CSS = "Board { width: 1fr; height: auto; display: none; }"

    KEYS = ("left", "right", "up", "down", "pageup", "pagedown", "home", "end")
    BINDINGS = [
        Binding("enter", "take", show=False),
        *(Binding(key, f"press('{key}')", show=False) for key in KEYS),
    ]

    def __init__(
        self, on_choose: Callable[[int], None], on_focus_change: Callable[[], None]
    ) -> None:
        super().__init__(id="board")
        self._on_choose, self._on_focus_change = on_choose, on_focus_change
        self._grid = Grid(range(1, 2), 1, 1)
        self._marks: Mapping[int, Mark] = {}
        self._index = 0  # The cursor's, in the numbers.

    @property
    def rows(self) -> int:
        """Return the number of rows: the grid's, and one for several pages."""
        return self._grid.rows + (self._grid.pages > 1)

    def show(self, grid: Grid, marks: Mapping[int, Mark]) -> None:
        """Show a grid and its marks; the cursor stays on its number, or else keeps its place."""
        before, self._marks = self._marks, marks
        if grid != self._grid:
            number = self._grid.numbers[self._index]  # The cursor stays on it.
            self._grid = grid
            there = number in grid.numbers
            last = len(grid.numbers) - 1
            self._index = grid.numbers.index(number) if there else min(self._index, last)
            self.styles.height = self.rows
            self.refresh()
        elif marks != before:
            numbers = before.keys() | marks.keys()
            changed = [n for n in numbers if before.get(n) != marks.get(n)]
            self._draw(*(grid.numbers.index(n) for n in changed if n in grid.numbers))

    def action_press(self, key: str) -> None:
        """Move the cursor as one of KEYS says; up and down do nothing where the column ends."""
        grid, last = self._grid, len(self._grid.numbers) - 1
        by = {"left": -1, "right": 1, "up": -grid.columns, "down": grid.columns}
        by |= {
            "pageup": -grid.page_size,
            "pagedown": grid.page_size,
            "home": -self._index,
            "end": last,
        }
        target = self._index + by[key]
        # At the end of a column the cursor stays.
        if key not in ("up", "down") or 0 <= target <= last:
            self._move(min(max(target, 0), last))

    def action_take(self) -> None:
        self._on_choose(self._grid.numbers[self._index])

    def on_click(self, event: events.Click) -> None:
        index = self._grid.at(self._first, event.x // self._grid.cell_width, event.y)
        if index is not None and event.chain == 1:  # A double click chooses once.
            self._move(index)
            self.action_take()

    def on_mouse_scroll_down(self) -> None:
        self.action_press("pagedown")

    def on_mouse_scroll_up(self) -> None:
        self.action_press("pageup")

    def watch_has_focus(self, focused: bool) -> None:
        """Show or hide the cursor, without Textual's search for `:focus` styles."""
        self._draw(self._index)
        self._on_focus_change()

    @property
    def _first(self) -> int:
        return self._index // self._grid.page_size * self._grid.page_size

    def _move(self, index: int) -> None:
        before, first = self._index, self._first
        self._index = index
        if self._first != first:
            self.refresh()
        else:
            self._draw(before, index)

    def _draw(self, *indices: int) -> None:
        grid, first = self._grid, self._first
        rows = {(index - first) // grid.columns for index in indices}
        for row in rows & {*range(grid.rows)}:
            self.refresh(Region(0, row, self.size.width, 1))

    def render_line(self, y: int) -> Strip:
        grid, width, base = self._grid, self.size.width, self.base
        if y >= grid.rows:
            style = base + rich_style(OLD, self.app.theme_variables)
            segments = [Segment(crop(self._page_line(), width), style)]
        else:
            indices = (grid.at(self._first, column, y) for column in range(grid.columns))
            cells = (self._cell(index, base) for index in indices if index is not None)
            segments = [segment for cell in cells for segment in cell]
        return Strip(segments).adjust_cell_length(width, base)

    def _cell(self, index: int, base: Style) -> tuple[Segment, Segment]:
        number = self._grid.numbers[index]
        mark = self._marks.get(number, _NO_MARK)
        tones = (ACTIVE, mark.tone)
        before, style = (base + rich_style(tone, self.app.theme_variables) for tone in tones)
        if self.has_focus and index == self._index:
            before = style = base + Style(reverse=True)
        head = mark.before.rjust(self._grid.digits + 1 - len(str(number)))
        return Segment(head, before), Segment(f"{number}{mark.behind}", style)

    def _page_line(self) -> str:
        """Return the line below the grid: ` 1 .. 40 of 120   page 1 of 3   pgup, pgdn`."""
        grid, first = self._grid, self._first
        last = min(first + grid.page_size, len(grid.numbers)) - 1
        shown = f" {grid.numbers[first]} .. {grid.numbers[last]} of {grid.numbers[-1]}"
        page = f"page {first // grid.page_size + 1} of {grid.pages}"
        return f"{shown}   {page}   pgup, pgdn"
