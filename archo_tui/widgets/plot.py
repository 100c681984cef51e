"""Curves of braille dots, two across a cell and four down. Pure functions."""

from __future__ import annotations

from collections.abc import Sequence

_BLANK = 0x2800
# Left and right column of dots, from above.
_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
MARK = "┄"  # Dashes in the marked row.

Range = tuple[float, float]  # Least and greatest value.


def curve(
    values: Sequence[Range | None], low: float, high: float, rows: int, mark: float | None = None
) -> list[str]:
    """Return the rows of a curve from the top, with two values in each cell.

    Each value is drawn from its least to its greatest; neighbours are joined.

    Args:
        values: The values, oldest first; None leaves a gap.
        low: The value of the lowest dot.
        high: The value of the highest dot.
        rows: The number of rows.
        mark: A value whose row is dashed where nothing is drawn; None for none.
    """
    steps = rows * 4 - 1

    def step(value: float) -> int:
        """Return the number of the dot of a value, from the top."""
        share = (value - low) / (high - low) if high > low else 0.0
        return steps - round(min(max(share, 0.0), 1.0) * steps)

    cells = [[0] * ((len(values) + 1) // 2) for _ in range(rows)]
    before: tuple[int, int] | None = None
    for index, value in enumerate(values):
        if value is None:
            before = None
            continue
        bottom, top = map(step, value)
        above, below = before or (top, bottom)
        for dot in range(min(top, below), max(bottom, above) + 1):
            cells[dot // 4][index // 2] |= _DOTS[index % 2][dot % 4]
        before = top, bottom
    dashed = None if mark is None or not low <= mark <= high else step(mark) // 4
    return [
        "".join(chr(_BLANK | cell) if cell else MARK if row == dashed else " " for cell in line)
        for row, line in enumerate(cells)
    ]
