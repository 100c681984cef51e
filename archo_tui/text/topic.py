"""The texts of a topic: how often messages come, their size, the fields, and plots of them."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime

from archo_tui.base.safe_text import harmless
from archo_tui.robot.topics.rows import SHOWN_ELEMENTS, Curve, FieldKind, FieldView, TopicView
from archo_tui.ros.names import base_name
from archo_tui.text.columns import GAP, QUIET, Columns, Text, column, crop, fit_columns, in_columns
from archo_tui.text.plot import plot_lines
from archo_tui.text.state import (
    ACTIVE,
    BARS,
    OLD,
    PLAIN,
    STRONG,
    WARN,
    Spans,
    age_text,
    not_drawn,
    share,
    thousands,
)


def size_text(size: float) -> str:
    """Return a number of bytes in B, kB or MB, each 1000 times the one before: `1.4 kB`."""
    if size < 1000:
        return f"{size:.0f} B"
    return f"{size / 1e3:.1f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"


_FIRST_DATE = 1e8  # Unix seconds; an earlier stamp is a simulation's or a robot's own time.
_LAST_DATE = 2e11  # No later one can be written as a date.


def summary(view: TopicView, *, is_frozen: bool) -> Spans:
    """Return `11.3 Hz   0.7 kB/s   0.1 s old`, and what is wrong or out of the ordinary."""
    texts = []
    if view.rate is not None:
        texts.append(f"{view.rate:.1f} Hz")
    elif view.age is not None:
        texts.append("-- Hz")
    if view.bytes_per_second is not None:
        texts.append(f"{size_text(view.bytes_per_second)}/s")
    if view.age is not None:
        texts.append(f"{age_text(view.age)} old")
    elif view.type and not view.fault:
        texts.append("sent before" if view.received else "no message yet")
    frozen = ("   frozen: space shows new messages", STRONG) if is_frozen else ("", PLAIN)
    cut = f"   only the first {len(view.fields)} fields" if view.is_cut else ""
    line = "   ".join(texts)
    fault = f"{'   ' if line else ''}{view.fault}" if view.fault else ""
    return (line, PLAIN), frozen, (harmless(fault), WARN), (cut, OLD)


def value_text(field: FieldView) -> str:
    """Return what stands behind the name of a field: `12.3 m`, or `4 CHARGING` for a constant."""
    if field.kind is FieldKind.GROUP:
        return ""
    if field.kind is FieldKind.ARRAY:
        return f"{base_name(field.type)} {field.first}".rstrip()
    if field.kind is FieldKind.MORE:
        return f"enter shows {SHOWN_ELEMENTS} more of {field.value}"
    value = field.value
    if field.is_time:
        text = time_text(float(value or 0))
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, (int, float)):
        text = number_text(value)
    else:
        text = harmless(str(value))
    if field.constant:
        return f"{text} {field.constant}"
    return f"{text} {field.unit}" if field.unit and text != "nan" else text


def number_text(value: float, digits: int = 7) -> str:
    """Return a number in few characters: an int with grouped digits, a float rounded."""
    if isinstance(value, int):
        return thousands(value)
    return str(value) if not math.isfinite(value) else f"{value:.{digits}g}"


def range_text(field: FieldView) -> str:
    """Return `0.12 .. 9.8, 3 nan`: the range of an array, or of a number's values so far."""
    parts = []
    if field.least is not None and field.greatest is not None:
        parts.append(f"{_short(field.least)} .. {_short(field.greatest)}")
    if field.nan:
        parts.append(f"{field.nan} nan")
    return ", ".join(parts)


def _short(value: float) -> str:
    """Return a number with four digits, or from 10,000 to a billion as a whole number."""
    is_long = 1e4 <= abs(value) < 1e9
    return number_text(round(value) if is_long else value, digits=4)


def time_text(seconds: float) -> str:
    """Return a Unix time as the local time, `12:04:31.250`, or in seconds without a date."""
    if not _FIRST_DATE <= seconds <= _LAST_DATE:
        return f"{seconds:.3f} s"
    return f"{datetime.fromtimestamp(seconds):%H:%M:%S.%f}"[:-3]


def sparkline(curve: Curve) -> str:
    """Return a bar for each column of a curve, scaled from its least to its greatest value."""
    known = [value for both in curve if both is not None for value in both]
    if not known:
        return ""
    low, high = min(known), max(known)
    bars, before = "", known[0]
    for both in curve:
        if both is None:
            bars += " "
            continue
        before = max(both, key=lambda value: abs(value - before))
        bars += BARS[round(share(before, low, high) * (len(BARS) - 1))]
    return bars


_NAME = (12, 40)  # Least and most cells of names.
_VALUE = (14, 28)
_RANGE = 24
_CURVE = (16, 60)
_MARK = " ●"  # Behind a field that is plotted.
_WIDE = 80  # Cells from which a value leaves room to the others.
_MEASURED = 200  # Rows whose names decide the width of their column.
_AXIS = 10  # Cells left of a plot.
_MIN_ROWS = 2  # Of a plot, besides its caption.
_INDENT = "  "


def field_columns(fields: Sequence[FieldView], width: int) -> Columns:
    """Return the cells of names, values, ranges and curves; 0 for those without room."""
    least, most = _NAME
    most = min(most, max(width // 2 - GAP, least))
    # With room for the mark, which has no other place where there are no curves.
    names = column((_name(field, ()) + _MARK for field in fields[:_MEASURED]), least, most)
    value = _VALUE[0], _VALUE[1] if width >= _WIDE else width
    curve = _CURVE[0] + len(_MARK), _CURVE[1] + len(_MARK)
    return fit_columns(((names, names), value, (_RANGE, _RANGE), curve), width, (0, 1, 2, 3))


def curve_columns(columns: Columns) -> int:
    """Return how many cells the curve beside a field takes, one for each value; 0 for no curves."""
    return max(columns[3] - len(_MARK), 0) if columns else 0


def field_titles(columns: Columns) -> str:
    """Return the titles of the columns: `field   value   least .. greatest   last minute`."""
    return in_columns(("field", "value", "least .. greatest", "last minute"), columns)


def field_line(
    field: FieldView, columns: Columns, closed: Collection[str], plotted: Collection[str]
) -> Text:
    """Return a field as `  speed   0.8 m/s   0 .. 0.8   ▁▁█████▁ ●`, with its style."""
    mark = _MARK if field.path in plotted else ""
    name = _name(field, closed)
    if not columns[3]:  # The mark has no column of its own.
        name, mark = f"{name}{mark}", ""
    curve = f"{sparkline(field.curve):<{curve_columns(columns)}}{mark}"
    value, least_greatest = value_text(field), range_text(field)
    if field.kind is FieldKind.ARRAY and not columns[2]:  # An array has no other value.
        value = f"{value} {least_greatest}".rstrip()
    texts = name, crop(value, columns[1]), crop(least_greatest, columns[2]), curve
    line = in_columns(texts, columns)
    is_quiet = field.kind in (FieldKind.GROUP, FieldKind.MORE)
    return line, QUIET if is_quiet else ""


def _name(field: FieldView, closed: Collection[str]) -> str:
    """Return the last part of a field's path, indented, with `▸` or `▾` for enter."""
    depth = field.path.count(".") + field.path.count("[")
    _, _, name = field.path.rpartition(".")
    if field.path.endswith("]"):
        name = name[name.index("[") :] if "[" in name else name
    if field.kind is FieldKind.MORE:
        name = "next"
    mark = ""
    if field.kind is FieldKind.GROUP:
        mark = "▸ " if field.path in closed else "▾ "
    elif field.kind is FieldKind.ARRAY:
        mark = "▾ " if field.is_open else "▸ "
    return f"{_INDENT * depth}{mark or _INDENT}{name}"


def plot_columns(width: int) -> int:
    """Return the number of values across a plot: two in each cell that the axis leaves."""
    return max(2 * (width - _AXIS - 2), 0)


def topic_plots(
    fields: Mapping[str, FieldView],
    plots: Mapping[str, Curve],
    paths: Sequence[str],
    size: tuple[int, int],  # Cells and lines.
) -> list[Spans]:
    """Return the lines of plots, one below the other, above a common axis of the last 60 s."""
    width, height = size
    shown = list(paths)
    while shown and (height - 1) // len(shown) < _MIN_ROWS + 1:
        shown.pop()
    if not shown or width < 2 * _AXIS:
        return [(("too small for the plot", OLD),)]
    rows = (height - 1) // len(shown) - 1
    lines: list[Spans] = []
    for path in shown:
        field = fields.get(path)
        value = "--" if field is None else value_text(field)
        lines.append(((f"{'':{_AXIS + 2}}{path} ", OLD), (value, STRONG)))
        try:
            values = plots.get(path, ())
            lines += plot_lines(values, *_scale(values), rows, _AXIS, ACTIVE)
        except Exception as error:  # The other plots go on.
            lines += [((not_drawn(error), WARN),), *[()] * (rows - 1)]
    more = f" {len(paths) - len(shown)} more have no room" if len(shown) < len(paths) else ""
    begin, end = " 60 s ago ", f"{more} now "
    line = f"{begin}{'─' * max(width - _AXIS - 1 - len(begin) - len(end), 0)}{end}"
    return [*lines, ((f"{'└':>{_AXIS + 1}}{line}", OLD),)]


def _scale(values: Curve) -> tuple[float, float]:
    """Return the ends of the axis: round numbers around all values, 0 and 1 without values."""
    known = [value for both in values if both is not None for value in both]
    if not known:
        return 0.0, 1.0
    low, high = float(min(known)), float(max(known))
    span = min(high - low or abs(high) or 1.0, sys.float_info.max)
    step = 10.0 ** math.floor(math.log10(span)) / 2
    if not step:
        return low, high
    bottom, top = math.floor(low / step) * step, math.ceil(high / step) * step
    if math.isinf(bottom) or math.isinf(top):
        return low, high
    return (bottom, top) if top > bottom else (bottom, bottom + step)
