"""Curves of braille dots, two in a cell's width, four in its height. Pure: numbers in, text out."""

from __future__ import annotations

from collections.abc import Sequence

_BLANK = 0x2800
_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))  # left and right, from above
MARK = "┄"  # of the row that is named

Range = tuple[float, float]  # the least and the greatest value that a dot stands for


def curve(
    values: Sequence[Range | None], low: float, high: float, rows: int, mark: float | None = None
) -> list[str]:
    """Rows of text from the top, with two values in a cell; None leaves a gap.

    Each is drawn from its least to its greatest. Values that follow each other are joined. The row
    of the value `mark` is dashed where nothing is drawn.
    """
    steps = rows * 4 - 1

    def step(value: float) -> int:
        """From the top."""
        share = (value - low) / (high - low) if high > low else 0.0
        return steps - round(min(max(share, 0.0), 1.0) * steps)

    cells = [[0] * ((len(values) + 1) // 2) for _ in range(rows)]
    before: tuple[int, int] | None = None
    for place, value in enumerate(values):
        if value is None:
            before = None
            continue
        bottom, top = map(step, value)
        above, below = before or (top, bottom)
        for dot in range(min(top, below), max(bottom, above) + 1):
            cells[dot // 4][place // 2] |= _DOTS[place % 2][dot % 4]
        before = top, bottom
    dashed = None if mark is None or not low <= mark <= high else step(mark) // 4
    return [
        "".join(chr(_BLANK | cell) if cell else MARK if row == dashed else " " for cell in line)
        for row, line in enumerate(cells)
    ]
