"""Curves, and the trend of the charge. Pure functions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from archo_tui.robot.topics.rows import Range
from archo_tui.text.state import BARS, EDGE, OLD, Spans, share

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


Samples = tuple[tuple[float, float], ...]  # Pairs of monotonic s and %, oldest first.

_BAR_SECONDS = 5.0
_MIN_SPAN = 5.0  # In %, from the lowest to the highest bar, so that noise looks like noise.
_WINDOW = 30.0  # Seconds of samples for the estimate.
_PRESENT = 5.0  # Seconds of samples that tell how it goes at present,
_MUCH = 2.0  # if in the window before the charge changed by so many %,
_LEAST_SHARE = 2 / 3  # and whose rate is no other one by chance if it differs by more.
_MIN_SAMPLED = 3.0  # Seconds of samples below which there is no estimate.


def sparkline(samples: Samples, width: int) -> str:
    """Return a bar for each 5 s that have samples, the newest at the right end, and the range."""
    cells: dict[int, float] = {}
    for at, percentage in samples:
        cells[int(at // _BAR_SECONDS)] = percentage
    shown = [cells[cell] for cell in sorted(cells)][-(width - len(" 100 .. 100 %")) :]
    if not shown:
        return ""
    low, high = min(shown), max(shown)
    span = max(high - low, _MIN_SPAN)
    bars = "".join(BARS[int((value - low) / span * (len(BARS) - 1))] for value in shown)
    return f"{bars} {low:.0f} .. {high:.0f} %".rjust(width)


def time_left_text(samples: Samples, *, charging: bool) -> str:
    """Return `empty in about 2 min`, or `full ...`, by the trend of the last 30 s."""
    seconds = _seconds_to_end(samples, charging)
    if seconds is None:
        return ""
    return f"{'full' if charging else 'empty'} in about {_round_duration(seconds)}"


def _seconds_to_end(samples: Samples, charging: bool) -> float | None:
    if not samples:
        return None
    last_at, last = samples[-1]
    at, percentage = next(sample for sample in samples if last_at - sample[0] <= _WINDOW)
    way = 1.0 if charging else -1.0
    gained = way * (last - percentage)
    if last_at - at < _MIN_SAMPLED or gained <= 0:
        return None
    rate = gained / (last_at - at)
    at, percentage = next(sample for sample in samples if last_at - sample[0] <= _PRESENT)
    if gained >= _MUCH and last_at > at:  # Enough to see whether it goes on like that.
        lately = way * (last - percentage)
        present = lately / (last_at - at)
        if not _LEAST_SHARE <= present / rate <= 1 / _LEAST_SHARE:
            if lately < _MUCH / 2:
                return None
            rate = present
    return (100.0 - last if charging else last) / rate


def _round_duration(seconds: float) -> str:
    """Return a duration in one or two digits: `4 s`, `40 s`, `12 min`, `3 h`; `days` from 100 h."""
    if seconds < 100:
        return f"{max(round(seconds, -1 if seconds >= 10 else 0), 1):.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.0f} h" if seconds < 360_000 else "days"
