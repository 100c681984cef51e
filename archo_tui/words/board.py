"""The board on which an operator picks the one whole number that a goal takes. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.types import INTEGERS
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import GoalKind
from archo_tui.words.state import BAD, OLD, PLAIN, STRONG, WARN

PAGE = 200  # The most numbers on a page.
_MAX_NUMBERS = 1_000_000  # A board of more numbers is of no use.
_QUEUE_PLACES = "¹²³⁴⁵⁶⁷⁸⁹"
_BEYOND_NINTH = "⁺"
_ENDS = {Phase.ARRIVED: ("✓", STRONG), Phase.DISPUTED: ("?", WARN)}
_FAILED = ("✗", BAD)


class Mark(NamedTuple):
    """The marks at a number of the board, and their tone."""

    before: str = " "  # An arrow if the robot goes there.
    behind: str = " "  # The place in the queue, or else how the last goal there ended.
    tone: str = OLD


class Grid(NamedTuple):
    """The layout of the numbers in columns and pages."""

    numbers: range  # All of the board.
    columns: int
    rows: int  # Of a page.

    @property
    def digits(self) -> int:
        """Return the width of the widest number in cells, its minus sign included."""
        return max(len(str(self.numbers[0])), len(str(self.numbers[-1])))

    @property
    def cell_width(self) -> int:
        """Return the width in cells of a number with both its marks."""
        return self.digits + 2

    @property
    def page_size(self) -> int:
        """Return how many numbers a full page has."""
        return self.columns * self.rows

    @property
    def pages(self) -> int:
        """Return how many pages there are."""
        return -(-len(self.numbers) // self.page_size)

    def at(self, first: int, column: int, row: int) -> int | None:
        """Return the index in `numbers` of a cell on the page that begins at `first`, or None."""
        place = first + row * self.columns + column
        inside = 0 <= column < self.columns and 0 <= row < self.rows
        return place if inside and place < len(self.numbers) else None


def selectable_numbers(snapshot: Snapshot, kind: GoalKind) -> range | None:
    """Return the numbers that a goal can take.

    None if it is not one whole number within known limits, or if there are none or too many.
    """
    fields = snapshot.forms.get(kind.id, ())
    if len(fields) != 1 or fields[0].type not in INTEGERS:
        return None
    given = kind.form[fields[0].path]
    low, high = snapshot.limit(given.low), snapshot.limit(given.high)
    if low is None or high is None or not 0 <= high - low < _MAX_NUMBERS:
        return None
    return range(math.ceil(low), math.floor(high) + 1) or None


def fit_grid(numbers: range, width: int, rows: int) -> Grid:
    """Return the layout with as many columns as fit: a multiple of ten, else five, else fewer."""
    fitting = max(width // Grid(numbers, 1, 1).cell_width, 1)
    columns = fitting // 10 * 10 if fitting >= 10 else 5 if fitting >= 5 else fitting
    columns = min(columns, len(numbers))
    needed = -(-len(numbers) // columns)
    if needed > rows or len(numbers) > PAGE:  # A line is left for the number of the page.
        needed = min(max(rows - 1, 1), max(PAGE // columns, 1))
    return Grid(numbers, columns, needed)


def marks(snapshot: Snapshot, kind: GoalKind, queue: Sequence[QueuedGoal]) -> Mapping[int, Mark]:
    """Return the marks of a board by number; `queue` has the next goal first."""
    found: dict[int, Mark] = {}
    path = next(iter(kind.form))
    latest = True
    for goal in (snapshot.goal, *snapshot.history):  # The newest first.
        if goal is None or goal.is_running or goal.kind.id != kind.id or path not in goal.fields:
            continue
        glyph, tone = _ENDS.get(goal.phase, _FAILED)
        found.setdefault(goal.fields[path], Mark(behind=glyph, tone=tone if latest else PLAIN))
        latest = False
    waiting = [goal.values.get(path) if goal.kind.id == kind.id else None for goal in queue]
    for place, number in reversed([*enumerate(waiting)]):  # The first place of a number is kept.
        if number is None:
            continue
        glyph = _QUEUE_PLACES[place] if place < len(_QUEUE_PLACES) else _BEYOND_NINTH
        found[number] = Mark(behind=glyph, tone=PLAIN)
    goal = snapshot.running_goal
    if goal is not None and goal.kind.id == kind.id and path in goal.fields:
        number = goal.fields[path]
        again = found[number].behind if number in waiting else " "
        found[number] = Mark("▶", again, STRONG)
    return found
