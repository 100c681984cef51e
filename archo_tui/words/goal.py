"""Where a goal stands: its words, its bar, and the goals before. Pure: state in, text out."""

from __future__ import annotations

from collections.abc import Sequence

from archo_tui.clock import time_of_day
from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.robot_file.model import GoalKind
from archo_tui.words.state import (
    ACTIVE,
    BAD,
    EDGE,
    OLD,
    PLAIN,
    STRONG,
    WARN,
    Spans,
    faster,
    seconds_text,
)

_WORD = 14  # cells for the word, as long as it is no longer
_LIST = 12  # cells of the queue without which its keys are not said
_WIDE = 60  # cells from which on a strip names its ends
_FIRST_FEEDBACK = 15.0  # s in which the first feedback of an action that sends any has come


def goal_line(snapshot: Snapshot, now: float, ask: str, width: int | None = None) -> Spans:
    """Where the goal stands, in the words of its phase; `ask` says how one is given.

    What follows the word has a column of its own where all of it has room in `width` cells.
    """
    goal = snapshot.goal
    if goal is None:
        return no_goal(snapshot, ask)
    texts = {
        Phase.SENT: (
            PLAIN,
            doing(goal),
            f"waiting for the robot ... {seconds_text(now - goal.sent)}",
        ),
        Phase.REFUSED: (BAD, "✗ REFUSED", f"at {time_of_day(goal.time)}: {goal.message}"),
        Phase.MOVING: (STRONG, doing(goal), _progress(goal, now)),
        Phase.CANCELLING: (
            STRONG,
            "CANCELLING" if goal.mine else doing(goal),
            f"asked {seconds_text(now - (goal.cancel_asked or now))} ago",
        ),
        Phase.CANCELLED: (BAD, "✗ CANCELLED", _where_ended(goal)),
        Phase.ARRIVED: (STRONG, f"✓ {goal.word}", _arrival(goal)),
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
    if goal.phase == Phase.MOVING and _time_left(goal, now):
        longer = f"{rest} {faster(snapshot)}".rstrip()
        # a part of the factor would be another one; whole, it stands beside the speed
        rest = longer if width is None or len(f"{word}   {longer}") <= width else rest
    if goal.is_running and snapshot.running > 1:
        rest += f"   +{snapshot.running - 1} more"
    has_room = width is None or _WORD + 1 + len(rest) <= width
    if len(word) <= _WORD and has_room:
        return (f"{word:<{_WORD}}", tone), (f" {rest}", PLAIN)
    return (word, tone), (f"   {rest}", PLAIN)


def goal_strip(goal: Goal | None, width: int) -> Spans:
    """The way, with the robot on it: `start   6.0 m ━━━▶────── 12.0 m shelf 12   33 %`.

    At its ends what is driven and what is left, where there is room for it.
    """
    length = None if goal is None or goal.remaining is None else goal.length
    if goal is None or not length or goal.phase in (Phase.SENT, Phase.REFUSED):
        return (("─" * max(width - 8, 4), EDGE), ("     -- ", OLD))
    fraction = goal.fraction()
    before, behind = _ends(goal, length) if width >= _WIDE else ("", "")
    room = max(width - 8 - len(before) - len(behind), 4)
    done = min(int(fraction * room), room - 1)
    tone = ACTIVE if goal.is_running else PLAIN
    way = ("━" * done + "▶", tone), ("─" * (room - done - 1), EDGE)
    return (before, OLD), *way, (behind, OLD), (f"  {100 * fraction:3.0f} %", PLAIN)


def _ends(goal: Goal, length: float) -> tuple[str, str]:
    """What stands before and behind the strip, as wide all the way."""
    unit, wide = _unit(goal), len(f"{length:.1f}")
    left = length * (1 - goal.fraction())
    target = f" {goal.name}" if goal.kind.noun and goal.target else ""
    return f"start {length - left:{wide}.1f}{unit} ", f" {left:{wide}.1f}{unit}{target}"


def goal_history(
    history: tuple[Goal, ...],
    width: int,
    waiting: Sequence[str] = (),
    held: str = "",
    keys: str = "",
) -> Spans:
    """What is driven next, and the goals before, newest first, as many as there is room for.

    `keys` say what can be done with a queue that is held.
    """
    if waiting:
        return _queue(waiting, held, width, keys)
    if not history:
        return (("last goals: none", OLD),)
    text = f"last goals: {ended(history[0])}"
    for goal in history[1:]:
        longer = f"{text}   {ended(goal)}"
        if len(longer) > width:
            break
        text = longer
    return ((text, OLD),)


def _queue(waiting: Sequence[str], held: str, width: int, keys: str) -> Spans:
    """`then 7, 3`, or `held: 7, 3 (cancelled)   n continue   k skip`; the list is cut first."""
    after = f" ({held})" if held else ""
    keys = f"   {keys}" if held and keys else ""
    if len(after + keys) + _LIST > width:
        keys = ""
    if len(after) + _LIST > width:
        after = f"{after[: max(width - _LIST - 2, 0)]}…)" if after else ""
    room = max(width - len(after + keys), _LIST)
    text = ("held: " if held else "then ") + ", ".join(waiting)
    text = text if len(text) <= room else f"{text[: room - 1]}…"
    return (text + after, WARN if held else PLAIN), (keys, PLAIN)


def no_goal(snapshot: Snapshot, ask: str) -> Spans:
    """What can be done while no goal was sent, or why nothing can."""
    if not snapshot.file.goals:
        return (("the robot file names no goal", OLD),)
    kind = snapshot.file.goals[0]
    why = snapshot.unavailable(kind.action)
    if why:
        return ((why, WARN if kind.action in snapshot.offered else OLD),)
    return ((f"No goal yet. {ask}".rstrip(), PLAIN),)


def keys_to_press(kind: GoalKind, go_key: str) -> str:
    """How a goal is given on the screen: `Press g, type the shelf, press enter.`"""
    labels = [given.label or path for path, given in kind.form.items()]
    what = f"type the {labels[0].lower()}, " if len(labels) == 1 else ""
    what = f"type {', '.join(labels)}, " if len(labels) > 1 else what
    return f"Press {go_key}, {what}press enter."


def doing(goal: Goal) -> str:
    """`MOVING to 12`, or `RUNNING fibonacci 10` of one that leads nowhere."""
    if not goal.mine:
        return f"{goal.word} ({goal.name})"
    if goal.kind.noun:
        return f"{goal.word} to {goal.target or goal.kind.noun}"
    return f"{goal.word} {goal.name}"


def way(goal: Goal) -> str:
    """What a running goal does, in a sentence: `on its way to shelf 12`, `running fibonacci 10`."""
    if not goal.mine:
        return f"carrying out {goal.name}"
    return f"on its way to {goal.name}" if goal.kind.noun else f"running {goal.name}"


def way_left(goal: Goal) -> str:
    """`9.0 m left`, or nothing while that is not known."""
    known = goal.remaining is not None and not goal.unreadable
    return f"{goal.remaining:.1f}{_unit(goal)} left" if known else ""


def _unit(goal: Goal) -> str:
    unit = goal.kind.remaining.unit if goal.kind.remaining else ""
    return f" {unit}" if unit else ""


def _progress(goal: Goal, now: float) -> str:
    unit, so_far = _unit(goal), f"{seconds_text(goal.elapsed(now))} so far"
    if goal.unreadable:
        return f"? {goal.unreadable}{unit} left   {so_far}"
    if goal.feedback:
        return f"{so_far}   {goal.feedback}"
    if goal.remaining is None and goal.elapsed(now) > _FIRST_FEEDBACK:
        return f"served, no feedback   {so_far}"
    if goal.remaining is None:
        return f"waiting for the first feedback ... {seconds_text(goal.elapsed(now))}"
    if goal.length is None:  # not known yet: no bar, no percentage
        return f"{way_left(goal)}   {so_far}{_time_left(goal, now)}"
    way = f"{goal.remaining:.1f}{unit} left of {goal.length:.1f}{unit}"
    return f"{way}   {so_far}{_time_left(goal, now)}"


def _time_left(goal: Goal, now: float) -> str:
    """Return `, about 1.5 s left`; empty while what is left is not known."""
    left = None if goal.unreadable or goal.feedback else goal.seconds_left(now)
    return "" if left is None else f", about {seconds_text(left)} left"


def _where_ended(goal: Goal) -> str:
    if goal.remaining is None:
        return goal.message
    where = f"before {goal.name}" if goal.kind.noun and goal.mine else "left"
    return f"{goal.message}, {goal.remaining:.1f}{_unit(goal)} {where}"


def _arrival(goal: Goal) -> str:
    took = seconds_text(goal.elapsed(0.0))
    if goal.length is None:
        return goal.message or f"in {took}"
    way = f"{goal.length:.1f}{_unit(goal)} in {took}"
    return f"{goal.message}, {way}" if goal.message else way


def ended(goal: Goal) -> str:
    """`✓ 12 arrived 12:03:58`."""
    at, name = time_of_day(goal.time), goal.target if goal.kind.noun and goal.target else goal.name
    if not goal.mine:
        glyph = "✓" if goal.phase == Phase.ARRIVED else "?" if goal.phase == Phase.DISPUTED else "✗"
        return f"{glyph} {goal.word.lower()} (another client) {at}"
    if goal.phase == Phase.ARRIVED:
        return f"✓ {name} {goal.word.lower()} {at}"
    if goal.phase == Phase.DISPUTED:
        return f"? {name} ended {at}"
    return f"✗ {name} {goal.word.lower()} {at}"
