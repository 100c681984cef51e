"""Texts in columns, fitted to a width in cells. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.cells import cell_len, set_cell_size

Text = tuple[str, str]  # A line and its Rich style, in which `$warn` is the theme's tone.
QUIET = "$quiet"
Columns = tuple[int, ...]  # Their widths, in cells; 0 for one without room.
GAP = 2  # Cells between two columns.


def pad(text: str, width: int) -> str:
    """Return a text in exactly `width` cells: filled with blanks, or cut in its middle by `…`."""
    if width <= 0:
        return ""
    if cell_len(text) > width:
        head = set_cell_size(text, max(width - 1, 0) // 2)
        tail = text[len(head) :]
        while cell_len(head) + 1 + cell_len(tail) > width:
            tail = tail[1:]
        text = f"{head}…{tail}"
    return text + " " * (width - cell_len(text))


def crop(text: str, width: int) -> str:
    """Return a text in at most `width` cells, with `…` at its end if it is cut."""
    if cell_len(text) > width:
        text = text.rstrip()  # Blanks at the end need no ellipsis.
    return text if cell_len(text) <= width else set_cell_size(text, max(width - 1, 0)) + "…"


def column(texts: Iterable[str], least: int, most: int) -> int:
    """Return the width of a column, in cells: that of its widest text, within bounds."""
    return max(least, min(most, max(map(cell_len, texts), default=0)))


def fit_columns(
    bounds: Sequence[tuple[int, int]], width: int, order: Sequence[int], gap: int = GAP
) -> Columns:
    """Return the widths of columns, each within its least and most cells.

    `order` has their numbers, the most important first: from the first one that has no room on, all
    are hidden, but not the very first. What is left widens them in that order.
    """
    widths, room = [0] * len(bounds), max(width, 0)
    for number in order:
        least = bounds[number][0]
        if number == order[0]:
            least = min(least, room)
        if least > room:
            break
        widths[number] = least
        room -= least + gap if least else 0
    room += gap
    for number in order:
        more = min(bounds[number][1] - widths[number], room) if widths[number] else 0
        widths[number] += max(more, 0)
        room -= max(more, 0)
    return tuple(widths)


def in_columns(
    texts: Sequence[str], columns: Columns, numbers: Sequence[int] = (), gap: int = GAP
) -> str:
    """Return texts in columns, cut in their middle; those of `numbers` are at the right, uncut."""
    cells = (
        f"{text:>{width}}" if number in numbers else pad(text, width)
        for number, (text, width) in enumerate(zip(texts, columns, strict=True))
        if width
    )
    return (" " * gap).join(cells).rstrip()
