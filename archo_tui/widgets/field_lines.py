"""The rows of a topic's fields as text, and the plots below them. Pure functions."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Mapping, Sequence

from archo_tui.robot.state.topic import Curve, FieldKind, FieldView
from archo_tui.text.plot import plot_lines
from archo_tui.text.state import ACTIVE, OLD, STRONG, WARN, Spans
from archo_tui.text.topic import range_text, sparkline, value_text
from archo_tui.widgets.line_widget import not_drawn
from archo_tui.widgets.rows import QUIET, Columns, Text, column, crop, pad

_NAME = (12, 40)  # Least and most cells of names.
_VALUE = (14, 28)
_RANGE = 24
_CURVE = (16, 60)
_MARK = " ●"  # Behind a field that is plotted.
_GAP = 2  # Cells between two columns.
_MEASURED = 200  # Rows whose names decide the width of their column.
_AXIS = 10  # Cells left of a plot.
_MIN_ROWS = 2  # Of a plot, besides its caption.
_INDENT = "  "


def field_columns(fields: Sequence[FieldView], width: int) -> Columns:
    """Return the cells of names, values, ranges and curves; 0 for those without room."""
    least, most = _NAME
    most = min(most, max(width // 2 - _GAP, least))
    # With room for the mark, which has no other place where there are no curves.
    names = column((_name(field, ()) + _MARK for field in fields[:_MEASURED]), least, most)
    room = width - names - _GAP
    if room < _VALUE[0] + _RANGE + _GAP:
        return names, room, 0, 0
    room -= _RANGE + _GAP
    if room < _VALUE[0] + _CURVE[0] + len(_MARK) + _GAP:
        return names, room, _RANGE, 0
    curve = min(max(room - _VALUE[1] - _GAP, _CURVE[0] + len(_MARK)), _CURVE[1] + len(_MARK))
    return names, room - curve - _GAP, _RANGE, curve


def curve_columns(columns: Columns) -> int:
    """Return how many cells the curve beside a field takes, one for each value; 0 for no curves."""
    return max(columns[3] - len(_MARK), 0) if columns else 0


def field_titles(columns: Columns) -> str:
    """Return the titles of the columns: `field   value   least .. greatest   last minute`."""
    return _line("field", "value", "least .. greatest", "last minute", columns)


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
    line = _line(name, value, least_greatest, curve, columns)
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


def _line(name: str, value: str, least_greatest: str, curve: str, columns: Columns) -> str:
    names, values, ranges, curves = columns
    line = f"{pad(name, names)}  {pad(crop(value, values), values)}"
    line += f"  {pad(crop(least_greatest, ranges), ranges)}" if ranges else ""
    return (f"{line}  {curve}" if curves else line).rstrip()


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
