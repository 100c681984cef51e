"""A list with a cursor that draws only visible lines, and only those that changed."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import Generic, TypeVar

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import Binding
from textual.geometry import Region, Size
from textual.scroll_view import ScrollView
from textual.strip import Strip

from archo_tui.text.columns import QUIET, Columns, Text, crop
from archo_tui.text.state import not_drawn

T = TypeVar("T")


class Rows(ScrollView, Generic[T], can_focus=True):
    """A list with a cursor, whose cost depends on the visible items only."""

    KEYS = ("up", "down", "pageup", "pagedown", "home", "end", "ctrl+home", "ctrl+end")
    BINDINGS = [Binding(key, f"press('{key}')", show=False) for key in KEYS]

    without_focus = False  # True: the cursor needs no focus, and the first click on a row acts.

    def __init__(
        self,
        # Draws an item in a width, with the columns' widths.
        lines: Callable[[T, int, Columns], Sequence[Text]],
        # Returns what identifies an item, by which the cursor follows it.
        key: Callable[[T], object],
        *,
        id: str,
        empty: str,  # The text of an empty list.
        action: str = "",  # A Textual action, for a click on the item under the visible cursor.
        wraps: bool = False,  # True if an item may take several lines.
        columns: Callable[[Sequence[T], int], Columns] = lambda *_: (),
    ) -> None:
        super().__init__(id=id)
        self._action = action
        self._draw, self._key, self._empty, self._wraps = lines, key, empty, wraps
        self.items: Sequence[T] = ()  # Those that are shown.
        # If items wrap: the items laid out, the lines of each, and the number of its first line.
        self._laid_out: Sequence[T] = ()
        self._lines: list[Sequence[Text]] = []
        self._starts: list[int] = []
        self._drawn_lines: dict[int, tuple[Text, bool]] = {}  # What each visible line shows.
        self._base = Style()  # Of a blank cell.
        self._measure = columns
        self.columns: Columns = ()  # Of the last layout.
        self._width = 0  # The width of the layout; the widget's own may be newer.
        self.cursor = 0
        self.shows_cursor = False  # True once the operator has moved to it or in it.

    @property
    def item(self) -> T | None:
        """Return the item under the cursor, or None in an empty list."""
        return self.items[self.cursor] if self.cursor < len(self.items) else None

    @property
    def item_key(self) -> object:
        """Return what identifies the item under the cursor; None in an empty list."""
        return None if self.item is None else self._key(self.item)

    def show(self, items: Sequence[T], empty: str | None = None) -> None:
        """Show other items, and keep the cursor on its item; equal items change nothing.

        A cursor on the first line stays there, since new items come first. `empty` is the text in
        the place of no items; None leaves it as it is.
        """
        is_other_text = empty is not None and empty != self._empty
        self._empty = self._empty if empty is None else empty
        if items == self.items:
            if is_other_text and not items:
                self.redraw_changed()
            return
        here = self.item
        self.items = items
        if self.cursor > 0 and here is not None:
            wanted = self._key(here)
            found = (n for n, item in enumerate(items) if self._key(item) == wanted)
            self.cursor = next(found, min(self.cursor, max(len(items) - 1, 0)))
        self._lay_out()

    def redraw_changed(self) -> None:
        """Redraw the visible lines whose text, style or cursor differs from what is drawn."""
        top, (width, height) = self.scroll_offset.y, self.size
        changed = [
            Region(0, y, width, 1)
            for y in range(height)
            if self._drawn_lines.get(y) != self._line_at(top + y)
        ]
        if changed:  # Without regions, all would be drawn.
            self.refresh(*changed)

    def redraw_all(self) -> None:
        """Lay out and draw all items again, also those that are equal: they look different now."""
        self._laid_out, self._lines = (), []
        self._lay_out()

    def on_resize(self) -> None:
        self._lay_out()

    def show_cursor(self) -> None:
        """Show the cursor from now on, whenever the list has the focus."""
        if not self.shows_cursor:
            self.shows_cursor = True
            self.redraw_changed()

    def watch_has_focus(self, focused: bool) -> None:
        """Show or hide the cursor, without Textual's search for `:focus` styles."""
        self.redraw_changed()

    def _lay_out(self) -> None:
        before, had_bar = (self._width, self.columns), self.show_vertical_scrollbar
        self._width = self.scrollable_content_region.width
        self.columns = self._measure(self.items, self._width)
        is_changed = (self._width, self.columns) != before
        total = self._wrap(is_changed) if self._wraps else len(self.items)
        size = Size(self._width, total)
        if not had_bar and self._fits(size) and self._fits(self.virtual_size):
            self.set_reactive(Rows.virtual_size, size)  # Spares a layout of the screen.
            self._redraw_all_or_changed(is_changed)
        elif size != self.virtual_size:
            self.virtual_size = size
            self._scroll_to_cursor()
            if (total > self.container_size.height) != had_bar:  # Textual checks it on resize only.
                self._refresh_scrollbars()
            self.refresh()
            if self.show_vertical_scrollbar != had_bar:  # The bar takes a column.
                self._lay_out()
        else:
            self._redraw_all_or_changed(is_changed)

    def _redraw_all_or_changed(self, is_changed: bool) -> None:
        if is_changed:  # Equal lines may be cut elsewhere.
            self.refresh()
        else:
            self.redraw_changed()

    def _fits(self, size: Size) -> bool:
        return size.height <= self.container_size.height

    def _wrap(self, is_changed: bool) -> int:
        """Lay out the items, or (if `is_changed` is False) what differs only; return the lines."""
        pairs = () if is_changed else zip(self._laid_out, self._lines, strict=True)
        known = {self._key(item): (item, lines) for item, lines in pairs}
        self._lines = []
        for item in self.items:
            before, lines = known.get(self._key(item), (None, ()))
            self._lines.append(lines if before == item else self._draw_item(item))
        self._laid_out = self.items
        *self._starts, total = accumulate(map(len, self._lines), initial=0)
        return total

    def _lines_of(self, number: int) -> Sequence[Text]:
        return self._lines[number] if self._wraps else self._draw_item(self.items[number])

    def _draw_item(self, item: T) -> Sequence[Text]:
        try:
            return self._draw(item, self._width, self.columns)
        except Exception as error:  # The other items go on.
            return [(not_drawn(error), "$warn")]

    def _line_at(self, row: int) -> tuple[Text, bool]:
        """Return the text and style of a line of the whole list, and True for a visible cursor."""
        number, part = row, 0
        if self._wraps and row < self.virtual_size.height:
            number = self._number_at(row)
            part = row - self._starts[number]
        if number >= len(self.items):
            return (self._empty, QUIET) if row == 0 else ("", ""), False
        shown = self.shows_cursor and (self.has_focus or self.without_focus)
        return self._lines_of(number)[part], shown and number == self.cursor

    def _number_at(self, row: int) -> int:
        return bisect_right(self._starts, row) - 1 if self._wraps else row

    def render_lines(self, crop: Region) -> list[Strip]:
        self._base = self.rich_style  # Computed once: it depends on all ancestors.
        return super().render_lines(crop)

    def render_line(self, y: int) -> Strip:
        seen = self._line_at(self.scroll_offset.y + y)
        self._drawn_lines[y] = seen
        (text, style), selected = seen
        width, text = self.size.width, crop(text, self._width)
        base = self._base
        tones = self.app.theme_variables
        words = (tones[word[1:]] if word.startswith("$") else word for word in style.split())
        drawn = base + Style.parse(" ".join(words) or "none")
        if selected:
            # A highlighted row stays visible, and has no colour of an alarm's banner.
            base = drawn = base + Style(bold=drawn.bold, reverse=not drawn.reverse)
        return Strip([Segment(text, drawn)]).crop_extend(0, width, base)

    def action_press(self, key: str) -> None:
        """Move the cursor by one of KEYS; the first `down` only shows it where it is."""
        page, count = max(self.size.height - 1, 1), len(self.items)
        by = {"up": -1, "down": int(self.shows_cursor), "pageup": -page, "pagedown": page}
        way = by.get(key, -count if key.endswith("home") else count)
        self._move(way)

    def move_to(self, number: int) -> None:
        """Move the cursor to an item by its number, at most the last one, and scroll to it."""
        self._move(number - self.cursor)

    def _move(self, by: int) -> None:
        last = max(len(self.items) - 1, 0)
        self.shows_cursor = True
        self.cursor = min(max(self.cursor + by, 0), last)
        self._scroll_to_cursor()
        self.redraw_changed()

    async def on_click(self, event: events.Click) -> None:
        row = self.scroll_offset.y + event.y
        if not 0 <= row < self.virtual_size.height:
            return
        number = self._number_at(row)
        acts = self.without_focus or (number == self.cursor and self.shows_cursor)
        self.move_to(number)
        if acts and self._action:
            await self.run_action(self._action)

    def _scroll_to_cursor(self) -> None:
        if self.item is None:
            return
        first = self._starts[self.cursor] if self._wraps else self.cursor
        height = len(self._lines_of(self.cursor))
        window, top = self.size.height, self.scroll_offset.y
        if first < top:
            self.scroll_to(y=first, animate=False)
        elif first + height > top + window:
            self.scroll_to(y=min(first, first + height - window), animate=False)
