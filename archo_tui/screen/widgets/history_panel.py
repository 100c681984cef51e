"""The panel of the history: plots of battery, speed and remaining way over the last minutes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from textual.app import ComposeResult

from archo_tui.base.clock import time_of_day
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.topics.rows import Range
from archo_tui.robot_file.model import RobotFile
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import FULL_SCREEN, Panel, ScreenState
from archo_tui.station.history import SPANS, History, Quantity, current_values
from archo_tui.station.view import View
from archo_tui.text.plot import plot_lines
from archo_tui.text.state import ACTIVE, OLD, PLAIN, STRONG, WARN, Spans, time_factor_text

_LABEL_WIDTH = 6  # Cells for the number at the side.
_MAX_NAME = 11  # Cells of the name of a goal that ended, with blanks around it.
_WITH_SECONDS = 240.0  # Seconds up to which the axis shows them.
_MIN_ROWS = 3  # Of a plot.
_MOST_NEEDED = 3  # Plots that are shown or, for want of room, none.
# Seconds that the plots cover until the chosen span has passed. As they grow in steps, a column
# that is past stays as it is, and at most a third is empty.
_STEPS = (20, 30, 45, 60, 90, 120, 180, 240, 300, 450, 600, 900, 1200, 1800, 2700)
_GLYPHS = {Phase.ARRIVED: "✓", Phase.DISPUTED: "?"}


class Plot(NamedTuple):
    """A reading to be plotted over time."""

    title: str
    unit: str
    decimals: int
    quantity: Quantity
    min_top: float  # The upper end of the scale, unless a value is greater.
    is_fixed: bool = False  # The scale always goes from 0 to `min_top`.


def plots(robot: RobotFile) -> tuple[Plot, ...]:
    """Return the plots of charge, speed, way left, x and y, as far as the robot file names them."""
    remaining = next((kind.remaining for kind in robot.goals[:1]), None)
    found = []
    if robot.battery is not None:
        found.append(Plot("battery", "%", 0, "charge", 100.0, is_fixed=True))
    if robot.motion is not None:
        found.append(Plot("speed", "m/s", 2, "speed", 0.5))
    if remaining is not None:
        found.append(Plot("remaining", remaining.unit, 1, "left", 1.0))
    if robot.pose is not None:
        found += [Plot("x", "m", 1, "x", 1.0), Plot("y", "m", 1, "y", 1.0)]
    return tuple(found)


def covered_span(history: History, chosen: float, now: float) -> float:
    """Return the seconds that plots cover: those chosen, or fewer, in steps, after the start."""
    passed = 0.0 if history.begin is None else now - history.begin
    return next((float(step) for step in _STEPS if passed <= step < chosen), chosen)


def history_lines(
    shown: Sequence[Plot], view: View, span: float, width: int, height: int, more: str = ""
) -> list[Spans]:
    """Return the lines of the plots, the marks of ended goals, and the time axis.

    Where rows are few, the plots behind the first three are left out, or one line says so, with
    `more`.
    """
    cells = width - _LABEL_WIDTH - 2
    while len(shown) > _MOST_NEEDED and (height - 2) // len(shown) - 1 < _MIN_ROWS:
        shown = shown[:-1]  # Where the robot is stands in Motion, too.
    rows = (height - 2) // max(len(shown), 1) - 1
    if rows < _MIN_ROWS or cells < 10:
        return [((f"too small for the plots{more}", OLD),)]
    lines: list[Spans] = []
    latest = current_values(view.snapshot, view.now)  # The newest sample may be a second old.
    for plot in shown:
        values = view.history.ranges(plot.quantity, span, 2 * cells, view.second)
        mark = view.snapshot.low_charge if plot.is_fixed else None
        unit = (
            plot.unit
            if plot.quantity != "speed"
            else f"{plot.unit} {time_factor_text(view.snapshot)}"
        )
        lines += _plot(plot._replace(unit=unit.rstrip()), values, latest[plot.quantity], rows, mark)
    ends = end_marks(view.history.ends(view.time), view.time, span, cells)
    lines.append(((" " * (_LABEL_WIDTH + 1), PLAIN), (ends, PLAIN)))
    return [*lines, ((f"{'└':>{_LABEL_WIDTH + 1}}{_time_axis(view, span, cells)}", OLD),)]


def _plot(
    plot: Plot, values: Sequence[Range | None], latest: float | None, rows: int, mark: float | None
) -> list[Spans]:
    known = [value for both in values if both is not None for value in both]
    low = 0.0 if plot.is_fixed else min([0.0, *known])
    high = plot.min_top if plot.is_fixed else _round_up(max([plot.min_top, *known]))
    form = f".{plot.decimals}f"
    now = "--" if latest is None else format(latest, form)
    tone = WARN if mark is not None and latest is not None and latest < mark else ACTIVE
    caption = (f"{'':{_LABEL_WIDTH + 2}}{plot.title} ", OLD), (f"{now} {plot.unit}", STRONG)
    beside = "" if mark is None else f"   low {mark:g}"
    bounds = f"   {min(known):{form}} .. {max(known):{form}}" if known else ""
    if len(f"{plot.title} {now} {plot.unit}{beside}{bounds}") <= len(values) // 2:
        beside = bounds + beside
    lines: list[Spans] = [(*caption, (beside, OLD))]
    return [*lines, *plot_lines(values, low, high, rows, _LABEL_WIDTH, tone, mark)]


def _round_up(high: float) -> float:
    """Return the least of 1, 2, 5, 10, 20, 50, ... (or 0.5, 0.2, ...) that is not below a number.

    Such steps keep the scale from changing often.
    """
    power = 10.0 ** math.floor(math.log10(high))
    return next(step * power for step in (1, 2, 5, 10) if high <= step * power)


def end_marks(ends: Iterable[Goal], now: float, span: float, cells: int) -> str:
    """Return a line with a mark for each goal that ended, at its time: `✓  ✓ 7   ✗ 12`."""
    row, names = [" "] * cells, dict[int, str]()
    for goal in ends:
        place = cells - 1 - int((now - goal.time) / span * cells)
        if 0 <= place < cells and row[place] != "✗":  # Of several, one that failed is told.
            row[place] = _GLYPHS.get(goal.phase, "✗")
            names[place + 1] = f" {goal.target}  " if goal.mine and goal.target else ""
    for begin, name in names.items():
        free = row[begin : begin + len(name)]
        if len(free) == len(name) <= _MAX_NAME and set(free) <= {" "}:
            row[begin : begin + len(name)] = name
    return "".join(row)


def _time_axis(view: View, span: float, cells: int) -> str:
    """Return `─ 11:54 ────── 11:59 ────── 12:04 `: begin, middle and end in local time."""
    digits = 8 if span <= _WITH_SECONDS else 5  # With seconds, or without.
    first, middle, last = (time_of_day(view.time - back)[:digits] for back in (span, span / 2, 0.0))
    gap = cells - 3 * digits - 5
    if gap < 2:
        return f" {last} ".rjust(cells, "─")
    return f" {first} {'─' * (gap // 2)} {middle} {'─' * (gap - gap // 2)} {last}"


class HistoryPanel(Panel, can_focus=True):
    """The panel with plots on a common time axis, drawn once a second while it is visible."""

    title_text, place, needs_room = "History", "beside", True
    keys = (("history", FULL_SCREEN), ("shorter", "shorter"), ("longer", "longer"))

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self._plots = plots(snapshot.file)
        self._span = 1  # Index in SPANS.
        self._lines = Line(id="plots")

    def compose(self) -> ComposeResult:
        yield self._lines

    def show(self, view: ScreenState) -> None:
        if not self.display:
            return
        chosen = SPANS[self._span]
        span = covered_span(view.history, chosen, view.second)
        last = f"last {chosen / 60:.0f} min" if chosen < 3600 else "last hour"
        self.show_keys(view, "since the start" if span < chosen else last)
        latest = current_values(view.snapshot, view.now)
        known = tuple(value is not None for value in latest.values())
        if self.is_news(view.second, span, self._lines.size, view.snapshot.history, known):
            is_full = self.screen.has_class("-full")
            more = "" if is_full else f": press {view.key('history')}"
            lines = history_lines(self._plots, view, span, *self._lines.size, more)
            self._lines.show_spans(*lines)

    def change_span(self, by: int) -> None:
        """Choose the next longer (1) or shorter (-1) span of SPANS, if there is one."""
        self._span = min(max(self._span + by, 0), len(SPANS) - 1)

    def can_change_span(self, by: int) -> bool:
        """Return True if there is a longer (1) or a shorter (-1) span than the chosen one."""
        return 0 <= self._span + by < len(SPANS)
