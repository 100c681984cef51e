"""A list with a cursor that draws only the lines that are seen, and only those that changed."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from itertools import accumulate
from typing import Generic, TypeVar

from rich.cells import cell_len, set_cell_size
from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import Binding
from textual.geometry import Region, Size
from textual.scroll_view import ScrollView
from textual.strip import Strip

from archo_tui.widgets.by_lines import ByLines
from archo_tui.widgets.quiet_focus import QuietFocus

T = TypeVar("T")
Text = tuple[str, str]  # a line and its Rich style, or QUIET
QUIET = "quiet"  # the theme's tone of that name
Columns = tuple[int, ...]  # their widths in cells

_MEASURED = 100  # first lines whose length decides how far the list scrolls sideways


def pad(text: str, width: int) -> str:
    """Text in `width` cells of a terminal, with blanks behind it, or `…` in its middle."""
    if cell_len(text) > width:
        head = set_cell_size(text, max(width - 1, 0) // 2)
        tail = text[len(head) :]
        while cell_len(head) + 1 + cell_len(tail) > max(width, 1):
            tail = tail[1:]
        text = f"{head}…{tail}"
    return text + " " * (width - cell_len(text))


def crop(text: str, width: int) -> str:
    """Text in at most `width` cells, with `…` at its end where it is cut: no digit ends there."""
    if cell_len(text) > width:
        text = text.rstrip()  # blanks need no ellipsis
    return text if cell_len(text) <= width else set_cell_size(text, max(width - 1, 0)) + "…"


def column(texts: Iterable[str], least: int, most: int) -> int:
    """The width of a column that is as wide as its texts, within bounds."""
    return max(least, min(most, max(map(cell_len, texts), default=0)))


class Rows(ScrollView, ByLines, QuietFocus, Generic[T], can_focus=True):
    """Items by the thousand cost what the seen ones cost; the cursor stays with its item."""

    KEYS = ("up", "down", "pageup", "pagedown", "home", "end", "ctrl+home", "ctrl+end")
    BINDINGS = [Binding(key, f"press('{key}')", show=False) for key in KEYS]

    without_focus = False  # the cursor is shown without it, too

    def __init__(
        self,
        lines: Callable[[T, int, Columns], Sequence[Text]],
        key: Callable[[T], object],
        *,
        id: str,
        empty: str,
        action: str = "",
        wraps: bool = False,
        columns: Callable[[Sequence[T], int], Columns] = lambda *_: (),
    ) -> None:
        """`lines(item, width, columns)` draws an item: one line unless `wraps`.

        `key` tells items apart; `columns(items, width)` says how wide what is shown needs them.
        A click on the item that has the cursor runs `action`.
        """
        super().__init__(id=id)
        self._action = action
        self._draw, self._key, self._empty, self._wraps = lines, key, empty, wraps
        self._items: Sequence[T] = ()
        # when they wrap: what was laid out, the lines of each, and its first line
        self._laid: Sequence[T] = ()
        self._lines: list[Sequence[Text]] = []
        self._starts: list[int] = []
        self._seen: dict[int, tuple[Text, bool]] = {}  # what each line of the window shows
        self._measure = columns
        self.columns: Columns = ()
        self._width = 0  # that the lines were laid out for: the window's may be newer
        self.cursor = 0
        self.shows_cursor = False  # not before a person came to the list

    @property
    def items(self) -> Sequence[T]:
        """What is shown."""
        return self._items

    @property
    def empty(self) -> str:
        """What stands there when there are no items."""
        return self._empty

    @empty.setter
    def empty(self, text: str) -> None:
        if text != self._empty:
            self._empty = text
            if not self._items:  # else it is not seen
                self.redraw()

    @property
    def item(self) -> T | None:
        """The item under the cursor."""
        return self._items[self.cursor] if self.cursor < len(self._items) else None

    @property
    def item_key(self) -> object:
        """What tells the item under the cursor from others."""
        return None if self.item is None else self._key(self.item)

    def show(self, items: Sequence[T]) -> None:
        """Show these. A cursor on the first line stays there, where what is new appears."""
        if items == self._items:
            return
        here = self.item
        self._items = items
        if self.cursor > 0 and here is not None:
            wanted = self._key(here)
            found = (n for n, item in enumerate(items) if self._key(item) == wanted)
            self.cursor = next(found, min(self.cursor, max(len(items) - 1, 0)))
        self._lay_out()

    def redraw(self) -> None:
        """Draw the seen lines that look another way now."""
        top = self.scroll_offset.y
        for y in range(self.size.height):
            if self._seen.get(y) != self._line(top + y):
                self.refresh(Region(0, y, self.size.width, 1))

    def on_resize(self) -> None:
        self._lay_out()

    def show_cursor(self) -> None:
        """A person came to the list: show which item is meant, whenever it has the focus."""
        if not self.shows_cursor:
            self.shows_cursor = True
            self.redraw()

    def watch_has_focus(self, focused: bool) -> None:
        """Show or hide the cursor; no style is for `:focus`, and Textual would look for some."""
        self.redraw()

    def _lay_out(self) -> None:
        before, had_bar = (self._width, self.columns), self.show_vertical_scrollbar
        self._width = self.scrollable_content_region.width
        self.columns = self._measure(self._items, self._width)
        anew = (self._width, self.columns) != before
        total = self._wrap(anew) if self._wraps else len(self._items)
        size = Size(max(self._longest(), 1), total)
        if not had_bar and self._fits(size) and self._fits(self.virtual_size):
            self.set_reactive(Rows.virtual_size, size)  # the screen need not be laid out for it
            self._draw_again(anew)
        elif size != self.virtual_size:
            self.virtual_size = size
            self._keep_cursor_in_sight()
            if self._scrolls != had_bar:  # Textual looks at this only when the size changes
                self._refresh_scrollbars()
            self.refresh()
            if self.show_vertical_scrollbar != had_bar:  # it takes a column, or gives one back
                self._lay_out()
        else:
            self._draw_again(anew)

    def _draw_again(self, anew: bool) -> None:
        if anew:  # lines that are the same may be cut elsewhere
            self.refresh()
        else:
            self.redraw()

    def _fits(self, size: Size) -> bool:
        """True when nothing of it needs scrolling."""
        return size.width <= self._width and size.height <= self.container_size.height

    def _wrap(self, anew: bool) -> int:
        """Lay out the items that are new, or all of them; returns how many lines there are."""
        known = {} if anew else dict(zip(map(id, self._laid), self._lines, strict=True))
        self._lines = [known.get(id(item)) or self._drawn(item) for item in self._items]
        self._laid = self._items  # kept, so that no other object gets one of their ids
        *self._starts, total = accumulate(map(len, self._lines), initial=0)
        return total

    def _lines_of(self, number: int) -> Sequence[Text]:
        return self._lines[number] if self._wraps else self._drawn(self._items[number])

    def _drawn(self, item: T) -> Sequence[Text]:
        return self._draw(item, self._width, self.columns)

    @property
    def _scrolls(self) -> bool:
        """True when not all lines have room."""
        return self.virtual_size.height > self.container_size.height

    def _longest(self) -> int:
        measured = range(min(len(self._items), _MEASURED))
        lines = (line for number in measured for line in self._lines_of(number))
        return max((cell_len(text) for text, _ in lines), default=0)

    def _line(self, row: int) -> tuple[Text, bool]:
        """What stands on a line of the whole list, and whether the cursor is on it."""
        number, part = row, 0
        if self._wraps and row < self.virtual_size.height:
            number = self._number_at(row)
            part = row - self._starts[number]
        if number >= len(self._items):
            return (self.empty, QUIET) if row == 0 else ("", ""), False
        shown = self.shows_cursor and (self.has_focus or self.without_focus)
        return self._lines_of(number)[part], shown and number == self.cursor

    def _number_at(self, row: int) -> int:
        return bisect_right(self._starts, row) - 1 if self._wraps else row

    def render_line(self, y: int) -> Strip:
        seen = self._line(self.scroll_offset.y + y)
        self._seen[y] = seen
        (text, style), selected = seen
        width, left = self.size.width, self.scroll_offset.x
        text = crop(text, left + self._width)
        base = self.base
        quiet = style == QUIET
        drawn = base + Style.parse(self.app.theme_variables[QUIET] if quiet else style or "none")
        if selected:
            base = drawn = drawn + Style(reverse=not drawn.reverse)  # what flashes still does
        return Strip([Segment(text, drawn)]).crop_extend(left, left + width, base)

    # the cursor

    def action_press(self, key: str) -> None:
        """Move the cursor by one of KEYS; the first `down` shows it where it is."""
        page, all_of_them = max(self.size.height - 1, 1), len(self._items)
        by = {"up": -1, "down": int(self.shows_cursor), "pageup": -page, "pagedown": page}
        way = by.get(key, -all_of_them if key.endswith("home") else all_of_them)
        self._move(way)

    def _move(self, by: int) -> None:
        last = max(len(self._items) - 1, 0)
        self.shows_cursor = True
        self.cursor = min(max(self.cursor + by, 0), last)
        self._keep_cursor_in_sight()
        self.redraw()

    async def on_click(self, event: events.Click) -> None:
        row = self.scroll_offset.y + event.y
        if not 0 <= row < self.virtual_size.height:
            return
        number = self._number_at(row)
        if number != self.cursor or not self.shows_cursor:
            self._move(number - self.cursor)
        elif self._action:
            await self.run_action(self._action)

    def _keep_cursor_in_sight(self) -> None:
        if self.item is None:
            return
        first = self._starts[self.cursor] if self._wraps else self.cursor
        height = len(self._lines_of(self.cursor))
        window, top = self.size.height, self.scroll_offset.y
        if first < top:
            self.scroll_to(y=first, animate=False)
        elif first + height > top + window:
            self.scroll_to(y=min(first, first + height - window), animate=False)
