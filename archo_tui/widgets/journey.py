"""The three rows of a goal's journey: its ends, a bar with the robot on it, and its pace."""

from __future__ import annotations

from collections.abc import Sequence

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.containers import Vertical

from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.widgets.line import Line
from archo_tui.widgets.rows import crop, pad
from archo_tui.words.goal import known_length, remaining_text, time_left_text
from archo_tui.words.state import ACTIVE, EDGE, OLD, PLAIN, STRONG, Spans, speed_text

ROWS = 3
_GAP = 4  # Cells between the parts of the lowest row.


class Journey(Vertical):
    """The way of a goal in three rows, whose parts keep their places while the robot moves."""

    DEFAULT_CSS = "Journey { height: 3; width: 1fr; }"

    def __init__(self) -> None:
        super().__init__(id="journey")
        self._ends, self._bar, self._pace = Line(), Line(id="journey-bar"), Line()

    def compose(self) -> ComposeResult:
        yield from (self._ends, self._bar, self._pace)

    def show(self, snapshot: Snapshot, now: float, width: int, waiting: Sequence[str]) -> None:
        """Show the way of the snapshot's goal, empty if there is none."""
        self._ends.show_spans(ends(snapshot.goal, width))
        self._bar.show_spans(bar(snapshot.goal, width))
        self._pace.show_spans(pace(snapshot, now, width, waiting))


def ends(goal: Goal | None, width: int) -> Spans:
    """Return the row above the bar: `START      9.0 m left   50 %   shelf 12`."""
    length = known_length(goal)
    if goal is None or goal.remaining is None or length is None:
        return _at_both_ends((("START", OLD),), (("-- left    -- %", OLD),), width)
    tone = STRONG if goal.is_running else PLAIN
    left, digits = remaining_text(goal), len(f"{length:.1f}") - len(f"{goal.remaining:.1f}")
    left = f"{' ' * max(digits, 0)}{left}   " if left else ""  # Of one width until the end.
    numbers = f"{left}{100 * goal.fraction():3.0f} %"
    target = f"   {goal.name}" if goal.kind.noun and goal.target else ""
    room = max(width - len("START ") - cell_len(numbers), 0)
    target = pad(target, min(cell_len(target), room))
    return _at_both_ends((("START", OLD),), ((numbers, tone), (target, tone)), width)


def bar(goal: Goal | None, width: int) -> Spans:
    """Return a bar of the full width up to the robot's place; empty if the way is not known."""
    if goal is None or known_length(goal) is None:
        return (("░" * width, EDGE),)
    done = min(int(goal.fraction() * width), width - 1)
    tone = ACTIVE if goal.is_running else OLD
    return ("█" * done, tone), ("▶", STRONG), ("░" * (width - done - 1), EDGE)


def pace(snapshot: Snapshot, now: float, width: int, waiting: Sequence[str] = ()) -> Spans:
    """Return the row below the bar: `0.80 m/s x 7.5    about 12 s left    then 7, 3`."""
    goal, speed = snapshot.goal, speed_text(snapshot)
    is_old = snapshot.motion.received is None or snapshot.motion.is_old(now)
    runs = goal is not None and goal.is_running
    left = time_left_text(goal, now) if goal is not None and goal.phase == Phase.MOVING else ""
    gap = " " * _GAP if speed and left else ""
    room = width - cell_len(f"{speed}{gap}{left}") - _GAP
    following = crop(f"then {', '.join(waiting)}", room) if waiting and room > _GAP else ""
    tone = PLAIN if runs and not is_old else OLD
    return _at_both_ends(((speed, tone), (f"{gap}{left}", PLAIN)), ((following, PLAIN),), width)


def _at_both_ends(before: Spans, behind: Spans, width: int) -> Spans:
    used = sum(cell_len(text) for text, _ in (*before, *behind))
    return *before, (" " * max(width - used, 1), PLAIN), *behind
