"""Curves of braille dots, two across a cell and four down. Pure functions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from archo_tui.robot.state.topic import Range
from archo_tui.text.state import EDGE, OLD, Spans, share

_BLANK = 0x2800
# Left and right column of dots, from above.
_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
MARK = "┄"  # Dashes in the marked row.
AREA = "░"  # Between the curve and zero.


def curve(
    values: Sequence[Range | None], low: float, high: float, rows: int, mark: float | None = None
) -> list[str]:
    """Return the rows of a curve from the top, with two values in each cell.

    Neighbours are joined, and the cells below a curve are filled down to zero, or to the lowest
    row. None leaves a gap; the row of `mark` is dashed.
    """
    steps = rows * 4 - 1

    def step(value: float) -> int:
        """Return the row of dots of a value, 0 at the top; values outside go to the ends."""
        return steps - round(share(value, low, high) * steps)

    cells = [[0] * ((len(values) + 1) // 2) for _ in range(rows)]
    zero = step(0.0) // 4
    filled = [[False] * len(cells[0]) for _ in range(rows)]
    before: tuple[int, int] | None = None
    for index, value in enumerate(values):
        if value is None:
            before = None
            continue
        bottom, top = map(step, value)
        above, below = before or (top, bottom)
        for dot in range(min(top, below), max(bottom, above) + 1):
            cells[dot // 4][index // 2] |= _DOTS[index % 2][dot % 4]
        for row in range(max(bottom, above) // 4 + 1, zero + 1):
            filled[row][index // 2] = True
        before = top, bottom
    dashed = None if mark is None or not low <= mark <= high else step(mark) // 4

    def drawn(row: int, cell: int) -> str:
        if cells[row][cell]:
            return chr(_BLANK | cells[row][cell])
        if row == dashed:
            return MARK
        return AREA if filled[row][cell] else " "

    return ["".join(drawn(row, cell) for cell in range(len(cells[0]))) for row in range(rows)]


def plot_lines(
    values: Sequence[Range | None],
    low: float,
    high: float,
    rows: int,
    label_width: int,
    tone: str,
    mark: float | None = None,
) -> list[Spans]:
    """Return the rows of a `curve` from the top, with an axis at the left that names both ends."""
    lines: list[Spans] = []
    for row, text in enumerate(curve(values, low, high, rows, mark)):
        at = {0: high, rows - 1: low}.get(row)
        label = "" if at is None else _label(at, label_width)
        side = f"{label:>{label_width}}{'│' if at is None else '┤'}"
        parts = (
            ("".join(part), EDGE if is_beside else tone)
            for is_beside, part in groupby(text, lambda char: char in (MARK, AREA))
        )
        lines.append(((side, OLD), *parts))
    return lines


def _label(value: float, width: int) -> str:
    """Return a number in few characters, with two digits if six of them are too wide."""
    label = f"{value:g}"
    return label if len(label) <= width else f"{value:.2g}"
