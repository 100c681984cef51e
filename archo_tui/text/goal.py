"""The texts of a goal: its state, its progress bar, and the goals before it. Pure functions."""

from __future__ import annotations

from collections.abc import Sequence

from archo_tui.base.clock import time_of_day
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import GoalKind
from archo_tui.text.state import (
    ACTIVE,
    BAD,
    EDGE,
    OLD,
    PLAIN,
    STRONG,
    WARN,
    Spans,
    fault_text,
    seconds_text,
    time_factor_text,
)

_WORD_WIDTH = 14  # The column of the state's word, in cells.
_MIN_QUEUE_WIDTH = 12  # The queue's cells below which its keys are left out.
_WIDE_STRIP = 60  # A line of so many cells names the ends of the bar.
_FIRST_FEEDBACK = 15.0  # Seconds after which an action is taken to send no feedback.
NO_ESTIMATE = "-- s left"  # In the place of a time that is not known.


def goal_line(
    snapshot: Snapshot,
    now: float,  # monotonic, s
    ask: str,  # How a goal is given, said while there is none.
    width: int | None = None,  # Where the details have no column of their own; None: unlimited.
) -> Spans:
    """Return the state of the last goal in a line, which may be wider than `width`."""
    goal = snapshot.goal
    if goal is None:
        return no_goal_line(snapshot, ask, width)
    texts = {
        Phase.SENT: (
            PLAIN,
            running_word(goal),
            f"waiting for the robot ... {seconds_text(now - goal.sent)}",
        ),
        Phase.REFUSED: (BAD, "✗ REFUSED", f"at {time_of_day(goal.time)}: {goal.message}"),
        Phase.MOVING: (STRONG, running_word(goal), _progress(goal, now)),
        Phase.CANCELLING: (
            STRONG,
            "CANCELLING" if goal.mine else running_word(goal),
            f"asked {seconds_text(now - (goal.cancel_asked or now))} ago",
        ),
        Phase.CANCELLED: (BAD, "✗ CANCELLED", _cancelled_details(goal)),
        Phase.ARRIVED: (STRONG, f"✓ {goal.word}", _arrival_details(goal)),
        Phase.ABORTED: (BAD, "✗ ABORTED", goal.message),
        Phase.DISPUTED: (WARN, "? ENDED", goal.message),
        Phase.GONE: (BAD, "✗ LOST", goal.message),
        Phase.UNKNOWN: (
            WARN,
            "? UNKNOWN",
            f"no answer for {seconds_text(now - (goal.heard or goal.sent))}; "
            "the goal may be running (asking again)",
        ),
        Phase.LOST: (
            BAD,
            "✗ LOST",
            f"nothing heard for {seconds_text(now - (goal.heard or now))}; "
            "the robot may still be moving",
        ),
    }
    tone, word, rest = texts[goal.phase]
    is_estimated = goal.seconds_left(now) is not None and time_left_text(goal, now)
    if goal.phase == Phase.MOVING and is_estimated:
        longer = f"{rest} {time_factor_text(snapshot)}".rstrip()
        # A factor that is cut would be another number; in full it stands beside the speed.
        rest = longer if width is None or len(f"{word}   {longer}") <= width else rest
    if goal.is_running and not goal.kind.stop_cancels:
        rest += "   STOP does not cancel it"
    if goal.is_running and snapshot.running > 1:
        others = snapshot.running - 1
        rest += f"   +{others} other goal{'s'[: others > 1]}"
    has_room = width is None or _WORD_WIDTH + 1 + len(rest) <= width
    if len(word) <= _WORD_WIDTH and has_room:
        return (f"{word:<{_WORD_WIDTH}}", tone), (f" {rest}", PLAIN)
    return (word, tone), (f"   {rest}", PLAIN)


def goal_strip(goal: Goal | None, width: int, rows: int = 1) -> list[Spans]:
    """Return `start   6.0 m ━━━▶────── 12.0 m shelf 12   33 %`, or an empty bar, in 1 or 3 rows."""
    length = known_length(goal)
    if goal is None or length is None:
        return _in_rows((("─" * max(width - 8, 4), EDGE), ("     -- ", OLD)), (), (), rows)
    fraction = goal.fraction()
    before, behind = _strip_ends(goal, length) if width >= _WIDE_STRIP else ("", "")
    room = max(width - 8 - len(before) - len(behind), 4)
    done = min(int(fraction * room), room - 1)
    is_thick = rows >= 3
    tone = ACTIVE if goal.is_running else OLD if is_thick else PLAIN
    driven = "█" if is_thick else "━"
    way = (driven * done + "▶", tone), ("─" * (room - done - 1), EDGE)
    line = (before, OLD), *way, (behind, OLD), (f"  {100 * fraction:3.0f} %", PLAIN)
    blanks = (" " * len(before), PLAIN)
    return _in_rows(line, (blanks, ("▄" * done, tone)), (blanks, ("▀" * done, tone)), rows)


def _in_rows(line: Spans, above: Spans, below: Spans, rows: int) -> list[Spans]:
    return [above, line, below] if rows >= 3 else [line]


def known_length(goal: Goal | None) -> float | None:
    """Return the length of a goal's way in its unit; None if its progress is not known."""
    if goal is None or goal.remaining is None or goal.unreadable:
        return None
    return None if goal.phase in (Phase.SENT, Phase.REFUSED) else goal.length or None


def _strip_ends(goal: Goal, length: float) -> tuple[str, str]:
    """Return the distance driven and the one left, of the same width at each moment of the way."""
    unit, wide = _unit_suffix(goal), len(f"{length:.1f}")
    left = length * (1 - goal.fraction())
    target = f" {goal.name}" if goal.kind.noun and goal.target else ""
    return f"start {length - left:{wide}.1f}{unit} ", f" {left:{wide}.1f}{unit}{target}"


def goal_history(
    history: tuple[Goal, ...],  # The newest first.
    width: int,
    waiting: Sequence[str] = (),  # The next one first.
    held: str = "",  # Why the queue is held.
    keys: str = "",  # `n continue   k skip`
) -> Spans:
    """Return the goals that wait in a line; if none waits, those that ended, as many as fit."""
    if waiting:
        return _queue_line(waiting, held, width, keys)
    if not history:
        return (("last goals: none", OLD),)
    text = f"last goals: {ended_text(history[0])}"
    for goal in history[1:]:
        longer = f"{text}   {ended_text(goal)}"
        if len(longer) > width:
            break
        text = longer
    return ((text, OLD),)


def _queue_line(waiting: Sequence[str], held: str, width: int, keys: str) -> Spans:
    """Return `then 7, 3`, or `held: 7, 3 (cancelled)   n continue   k skip`, cut to a width."""
    after = f" ({held})" if held else ""
    keys = f"   {keys}" if held and keys else ""
    if len(after + keys) + _MIN_QUEUE_WIDTH > width:
        keys = ""
    if len(after) + _MIN_QUEUE_WIDTH > width:
        after = f"{after[: max(width - _MIN_QUEUE_WIDTH - 2, 0)]}…)" if after else ""
    room = max(width - len(after + keys), _MIN_QUEUE_WIDTH)
    text = ("held: " if held else "then ") + ", ".join(waiting)
    text = text if len(text) <= room else f"{text[: room - 1]}…"
    return (text + after, WARN if held else PLAIN), (keys, PLAIN)


def no_goal_line(snapshot: Snapshot, ask: str, width: int | None = None) -> Spans:
    """Return how to give the first goal of the robot file, or why it cannot be given."""
    if not snapshot.file.goals:
        return (("the robot file names no goal", OLD),)
    kind = snapshot.file.goals[0]
    why = snapshot.unavailable(kind.action)
    if why:
        why = why if width is None else fault_text(why, width)
        return ((why, WARN if kind.action in snapshot.offered else OLD),)
    return ((f"No goal yet. {ask}".rstrip(), PLAIN),)


def keys_to_press(kind: GoalKind, go_key: str) -> str:
    """Return `Press g, type the shelf, press enter.`; in the field, without a key, the rest."""
    labels = [given.label or path for path, given in kind.form.items()]
    what = labels[0].lower() if len(labels) == 1 else ", ".join(labels)
    what = f"the {what}" if len(labels) == 1 else what
    steps = f"press {go_key}" if go_key else "", f"type {what}" if what else "", "press enter"
    text = ", ".join(filter(None, steps))
    return f"{text[0].upper()}{text[1:]}."


def running_word(goal: Goal) -> str:
    """Return a goal's state and name: `MOVING to 12`, or `RUNNING fibonacci 10`."""
    if not goal.mine:
        return f"{goal.word} ({goal.name})"
    if goal.kind.noun:
        return f"{goal.word} to {goal.target or goal.kind.noun}"
    return f"{goal.word} {goal.name}"


def activity(goal: Goal) -> str:
    """Return what a running goal does, to be put in a sentence: `on its way to shelf 12`."""
    if not goal.mine:
        return f"carrying out {goal.name}"
    return f"on its way to {goal.name}" if goal.kind.noun else f"running {goal.name}"


def remaining_text(goal: Goal) -> str:
    """Return the rest of a goal's way, such as `9.0 m left`; "" if it is not known."""
    if goal.remaining is None or goal.unreadable:
        return ""
    return f"{_way(goal, goal.remaining)} left"


def _way(goal: Goal, length: float) -> str:
    return f"{round(length, 1) + 0.0:.1f}{_unit_suffix(goal)}"  # `+ 0.0`: never -0.0.


def _unit_suffix(goal: Goal) -> str:
    unit = goal.kind.remaining.unit if goal.kind.remaining else ""
    return f" {unit}" if unit else ""


def _progress(goal: Goal, now: float) -> str:
    """Return how far a moving goal is: `9.0 m left of 18.0 m   12 s so far`."""
    time_left = f", {text}" if (text := time_left_text(goal, now)) else ""
    so_far = f"{seconds_text(goal.elapsed(now))} so far"
    if goal.unreadable:
        return f"? {goal.unreadable}{_unit_suffix(goal)} left   {so_far}"
    if goal.feedback:
        return f"{so_far}   {goal.feedback}"
    if goal.remaining is None and goal.elapsed(now) > _FIRST_FEEDBACK:
        return f"served, no feedback   {so_far}"
    if goal.remaining is None:
        return f"waiting for the first feedback ... {seconds_text(goal.elapsed(now))}"
    if goal.length is None:  # Without the length of the way there is no percentage.
        return f"{remaining_text(goal)}   {so_far}{time_left}"
    return f"{remaining_text(goal)} of {_way(goal, goal.length)}   {so_far}{time_left}"


def time_left_text(goal: Goal, now: float) -> str:
    """Return `about 1.5 s left`, `-- s left` if unknown, "" without a remaining way."""
    if goal.unreadable or goal.feedback or goal.remaining is None:
        return ""
    left = goal.seconds_left(now)
    return NO_ESTIMATE if left is None else f"about {seconds_text(left)} left"


def _cancelled_details(goal: Goal) -> str:
    """Return the robot's message, and how much of the way was left: `9.0 m before shelf 12`."""
    if goal.remaining is None or goal.unreadable:
        return goal.message
    where = f"before {goal.name}" if goal.kind.noun and goal.mine else "left"
    return f"{goal.message}, {_way(goal, goal.remaining)} {where}"


def _arrival_details(goal: Goal) -> str:
    """Return the robot's message, the length of the way, and how long it took: `18.0 m in 24 s`."""
    took = seconds_text(goal.elapsed(0.0))
    if goal.length is None:
        return goal.message or f"in {took}"
    way = f"{_way(goal, goal.length)} in {took}"
    return f"{goal.message}, {way}" if goal.message else way


def ended_text(goal: Goal) -> str:
    """Return a goal that ended in a few words: `✓ 12 arrived 12:03:58`."""
    at, name = time_of_day(goal.time), goal.target if goal.kind.noun and goal.target else goal.name
    if not goal.mine:
        glyph = "✓" if goal.phase == Phase.ARRIVED else "?" if goal.phase == Phase.DISPUTED else "✗"
        return f"{glyph} {goal.word.lower()} (another client) {at}"
    if goal.phase == Phase.ARRIVED:
        return f"✓ {name} {goal.word.lower()} {at}"
    if goal.phase == Phase.DISPUTED:
        return f"? {name} ended {at}"
    return f"✗ {name} {goal.word.lower()} {at}"
