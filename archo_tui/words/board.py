"""The board of a goal that is one whole number: which numbers, and what stands at each. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from archo_tui.robot.fields import INTEGERS
from archo_tui.robot.state import Phase, Snapshot
from archo_tui.robot_file.model import GoalKind
from archo_tui.station.queue import QueuedGoal
from archo_tui.words.state import BAD, OLD, PLAIN, STRONG, WARN

PAGE = 200  # numbers that are shown at once
_MOST = 1_000_000  # numbers beyond which nobody looks for one on a board
_PLACES = "¹²³⁴⁵⁶⁷⁸⁹"  # in the queue
_LATER = "⁺"
_ENDS = {Phase.ARRIVED: ("✓", STRONG), Phase.DISPUTED: ("?", WARN)}
_FAILED = ("✗", BAD)


class Mark(NamedTuple):
    """What stands at a number: a cell before it, a cell behind it, and the tone of these two."""

    before: str = " "  # where the robot goes
    behind: str = " "  # the place in the queue, else how the last goal there ended
    tone: str = OLD


class Grid(NamedTuple):
    """How the numbers are laid out: cells as wide as the longest, and what stands around it."""

    numbers: range
    columns: int
    rows: int  # of a page

    @property
    def digits(self) -> int:
        """The length of the longest number."""
        return max(len(str(self.numbers[0])), len(str(self.numbers[-1])))

    @property
    def cell(self) -> int:
        """The width of a cell."""
        return self.digits + 2

    @property
    def page(self) -> int:
        """How many numbers a page has."""
        return self.columns * self.rows

    @property
    def pages(self) -> int:
        """How many pages there are."""
        return -(-len(self.numbers) // self.page)

    def at(self, first: int, column: int, row: int) -> int | None:
        """The place in `numbers` of a cell, on the page that begins at the place `first`."""
        place = first + row * self.columns + column
        inside = 0 <= column < self.columns and 0 <= row < self.rows
        return place if inside and place < len(self.numbers) else None


def numbers_of(snapshot: Snapshot, kind: GoalKind) -> range | None:
    """The numbers that can be chosen; None where it is not one, or a limit is not known."""
    leaves = snapshot.forms.get(kind.id, ())
    if len(leaves) != 1 or leaves[0].type not in INTEGERS:
        return None
    given = kind.form[leaves[0].path]
    low, high = snapshot.limit(given.low), snapshot.limit(given.high)
    if low is None or high is None or not 0 <= high - low < _MOST:
        return None
    return range(math.ceil(low), math.floor(high) + 1) or None


def grid(numbers: range, width: int, rows: int) -> Grid:
    """As many columns as fit into `width` cells, by tens or five; pages beyond so many rows."""
    fitting = max(width // Grid(numbers, 1, 1).cell, 1)
    columns = fitting // 10 * 10 if fitting >= 10 else 5 if fitting >= 5 else fitting
    columns = min(columns, len(numbers))
    needed = -(-len(numbers) // columns)
    if needed > rows or len(numbers) > PAGE:  # then a line says which page it is
        needed = min(max(rows - 1, 1), max(PAGE // columns, 1))
    return Grid(numbers, columns, needed)


def marks(snapshot: Snapshot, kind: GoalKind, queue: Sequence[QueuedGoal]) -> Mapping[int, Mark]:
    """What stands at the numbers where something does."""
    found: dict[int, Mark] = {}
    path = next(iter(kind.form))
    latest = True
    for goal in (snapshot.goal, *snapshot.history):  # newest first
        if goal is None or goal.is_running or goal.kind.id != kind.id or path not in goal.fields:
            continue
        glyph, tone = _ENDS.get(goal.phase, _FAILED)
        found.setdefault(goal.fields[path], Mark(behind=glyph, tone=tone if latest else PLAIN))
        latest = False
    waiting = [one.values.get(path) if one.kind.id == kind.id else None for one in queue]
    for place, number in reversed([*enumerate(waiting)]):  # the first one stays
        if number is None:
            continue
        glyph = _PLACES[place] if place < len(_PLACES) else _LATER
        found[number] = Mark(behind=glyph, tone=PLAIN)
    goal = snapshot.running_goal
    if goal is not None and goal.kind.id == kind.id and path in goal.fields:
        number = goal.fields[path]
        again = found[number].behind if number in waiting else " "
        found[number] = Mark("▶", again, STRONG)
    return found
