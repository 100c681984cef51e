"""Panel 7: battery, speed and what is left of the way, over the last minutes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import NamedTuple

from rich.segment import Segment
from textual.app import ComposeResult
from textual.geometry import Region
from textual.strip import Strip

from archo_tui.clock import time_of_day
from archo_tui.robot.state import Goal, Phase
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.history import SPANS, Quantity, readings
from archo_tui.station.station import View
from archo_tui.widgets.by_lines import ByLines
from archo_tui.widgets.panel import FULL_SCREEN, Panel
from archo_tui.widgets.plot import MARK, Range, curve
from archo_tui.widgets.shown import Shown
from archo_tui.widgets.styled import rich_style
from archo_tui.words.state import ACTIVE, EDGE, OLD, PLAIN, STRONG, WARN, Spans, time_factor_text

_LABEL = 6  # cells for the number at the side
_LEAST = 3  # rows of a plot
_GLYPHS = {Phase.ARRIVED: "✓", Phase.DISPUTED: "?"}


class Plot(NamedTuple):
    """One reading over time."""

    title: str
    unit: str
    places: int  # behind the decimal point
    quantity: Quantity
    least: float  # what the scale reaches at least
    fixed: bool = False  # the scale reaches just that


def plots(robot: RobotFile) -> tuple[Plot, ...]:
    """Those of what the robot reports."""
    remaining = next((kind.remaining for kind in robot.goals[:1]), None)
    found = []
    if robot.battery is not None:
        found.append(Plot("battery", "%", 0, "charge", 100.0, fixed=True))
    if robot.motion is not None:
        found.append(Plot("speed", "m/s", 2, "speed", 0.5))
    if remaining is not None:
        found.append(Plot("remaining", remaining.unit, 1, "left", 1.0))
    return tuple(found)


def history_lines(
    shown: Sequence[Plot], view: View, span: float, width: int, height: int, more: str = ""
) -> list[Spans]:
    """The plots below each other, the ends of goals, and the time that all of them share.

    `more` says how they get more room, where they have too little.
    """
    cells = width - _LABEL - 2
    rows = (height - 2) // max(len(shown), 1) - 1
    if rows < _LEAST or cells < 10:
        return [((f"too small for the plots{more}", OLD),)]
    lines: list[Spans] = []
    latest = readings(view.snapshot, view.now)  # the newest sample may be a second old
    for plot in shown:
        values = view.history.ranges(plot.quantity, span, 2 * cells, view.second)
        mark = view.snapshot.threshold if plot.fixed else None
        unit = (
            plot.unit
            if plot.quantity != "speed"
            else f"{plot.unit} {time_factor_text(view.snapshot)}"
        )
        lines += _plot(plot._replace(unit=unit.rstrip()), values, latest[plot.quantity], rows, mark)
    ends = end_marks(view.history.ends, view.time, span, cells)
    lines.append(((" " * (_LABEL + 1), PLAIN), (ends, PLAIN)))
    return [*lines, ((f"{'└':>{_LABEL + 1}}{_times(view, span, cells)}", OLD),)]


def _plot(
    plot: Plot, values: Sequence[Range | None], latest: float | None, rows: int, mark: float | None
) -> list[Spans]:
    known = [value for both in values if both is not None for value in both]
    low = 0.0 if plot.fixed else min([0.0, *known])
    high = plot.least if plot.fixed else _round(max([plot.least, *known]))
    form = f".{plot.places}f"
    now = "--" if latest is None else format(latest, form)
    tone = WARN if mark is not None and latest is not None and latest < mark else ACTIVE
    caption = (f"{'':{_LABEL + 2}}{plot.title} ", OLD), (f"{now} {plot.unit}", STRONG)
    lines: list[Spans] = [caption if mark is None else (*caption, (f"   low {mark:g}", OLD))]
    for row, text in enumerate(curve(values, low, high, rows, mark)):
        at = {0: high, rows - 1: low}.get(row)
        side = f"{'' if at is None else f'{at:g}':>{_LABEL}}{'│' if at is None else '┤'} "
        parts = (
            ("".join(part), EDGE if dashed else tone)
            for dashed, part in groupby(text, lambda char: char == MARK)
        )
        lines.append(((side[:-1], OLD), *parts))
    return lines


def _round(high: float) -> float:
    """The smallest of 1, 2, 5, 10, ... that is not below it: a scale that seldom changes."""
    power = 10.0 ** math.floor(math.log10(high))
    return next(step * power for step in (1, 2, 5, 10) if high <= step * power)


def end_marks(ends: Iterable[Goal], now: float, span: float, cells: int) -> str:
    """Return a line with a mark for each goal that ended, where it did: `✓  ✓ 7   3✓ 1✗`.

    The target stands behind a mark where there is room; marks that share a cell are counted.

    Args:
        ends: The goals, the newest first.
        now: The Unix time at the right end of the line.
        span: How much time the line stands for, in s.
        cells: How long the line is.
    """
    groups: list[tuple[int, list[Goal]]] = []  # the cell where each begins; from the right
    for goal in ends:
        place, group = cells - 1 - int((now - goal.time) / span * cells), [goal]
        if not 0 <= place < cells:
            continue
        while groups and place + _needed(group, groups[-1][1]) > groups[-1][0]:
            group = groups.pop()[1] + group
            place = max(min(place, cells - len(_mark(group))), 0)
        groups.append((place, group))
    row = [" "] * cells
    for place, group in groups:
        row[place : place + len(_mark(group))] = _mark(group)
    for place, group in groups:
        text = f"{_mark(group)} {_target(group[0])}".rstrip() if len(group) == 1 else ""
        at = min(place, cells - len(text))
        before = row[max(at - 1, 0) : place] if at < place else []
        around = before + row[place + 1 : at + len(text) + 1]
        if text and at >= 0 and set(around) <= {" "}:
            row[place] = " "
            row[at : at + len(text)] = text
    return "".join(row[:cells])


def _mark(group: Sequence[Goal]) -> str:
    """A glyph, or how many there are of each: `3✓ 1✗`."""
    glyphs = Counter(_GLYPHS.get(goal.phase, "✗") for goal in group)
    if len(group) == 1:
        return next(iter(glyphs))
    return " ".join(f"{glyphs[glyph]}{glyph}" for glyph in "✓?✗" if glyphs[glyph])


def _needed(group: Sequence[Goal], following: Sequence[Goal]) -> int:
    """How many cells a mark takes, with the blank around a count."""
    return len(_mark(group)) + (len(group) > 1 or len(following) > 1)


def _target(goal: Goal) -> str:
    short = goal.target if goal.mine else ""
    return short if len(short) <= 8 else ""


def _times(view: View, span: float, cells: int) -> str:
    """`─ 11:54 ────── 11:59 ────── 12:04 `, as far apart as it shows."""
    digits = 8 if span <= SPANS[0] else 5  # without seconds, or with them
    first, middle, last = (time_of_day(view.time - back)[:digits] for back in (span, span / 2, 0.0))
    gap = cells - 3 * digits - 5
    if gap < 2:
        return f" {last} ".rjust(cells, "─")
    return f" {first} {'─' * (gap // 2)} {middle} {'─' * (gap - gap // 2)} {last}"


class Lines(ByLines):
    """Rows of text, of which only those are drawn that changed."""

    DEFAULT_CSS = "Lines { height: 1fr; width: 1fr; }"

    def __init__(self) -> None:
        super().__init__()
        self._lines: Sequence[Spans] = ()

    def show(self, lines: Sequence[Spans]) -> None:
        """Show these instead."""
        before, self._lines = self._lines, lines
        for y in range(max(len(before), len(lines))):
            if list(before[y : y + 1]) != list(lines[y : y + 1]):
                self.refresh(Region(0, y, self.size.width, 1))

    def render_line(self, y: int) -> Strip:
        base, variables = self.base, self.app.theme_variables
        line = self._lines[y] if y < len(self._lines) else ()
        segments = [Segment(text, base + rich_style(tone, variables)) for text, tone in line]
        return Strip(segments).crop_extend(0, self.size.width, base)


class HistoryPanel(Panel, can_focus=True):
    """Plots with one axis of time; drawn once a second, and only while it is shown.

    A reading that comes or goes is drawn at once.
    """

    number, title_text = 7, "History"
    keys = (("history", FULL_SCREEN), ("shorter", "shorter"), ("longer", "longer"))

    def __init__(self, robot: RobotFile) -> None:
        super().__init__()
        self._plots = plots(robot)
        self._span = 1  # of SPANS
        self._lines = Lines()
        self._drawn: object = None

    def compose(self) -> ComposeResult:
        yield self._lines

    def show(self, view: Shown) -> None:
        if not self.display:
            return
        span = SPANS[self._span]
        self.show_keys(view, f"last {span / 60:.0f} min" if span < 3600 else "last hour")
        latest = readings(view.snapshot, view.now)
        known = tuple(value is not None for value in latest.values())
        drawn = (view.second, self._span, self._lines.size, view.snapshot.history, known)
        if drawn != self._drawn:
            self._drawn = drawn
            is_full = self.screen.has_class("-full")
            more = "" if is_full else f": press {view.key('history')}"
            self._lines.show(history_lines(self._plots, view, span, *self._lines.size, more))

    def look_back(self, by: int) -> None:
        """Over a longer (1) or a shorter (-1) time."""
        self._span = min(max(self._span + by, 0), len(SPANS) - 1)

    def can_look_back(self, by: int) -> bool:
        """False at the longest and at the shortest."""
        return 0 <= self._span + by < len(SPANS)
