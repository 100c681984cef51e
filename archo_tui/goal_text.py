"""Where a goal stands: its words, its bar, and the goals before. Pure: state in, text out."""

from __future__ import annotations

from archo_tui.clock import time_of_day
from archo_tui.robot.state import MOVE, Goal, Phase, Snapshot
from archo_tui.state_text import BAD, OLD, PLAIN, STRONG, WARN, Spans, seconds_text

ACTIVE = "active"  # the tone of the way that is being driven
_TEXTBOOK = "motor_controller"
_INT32_MAX = 2**31 - 1  # the goal's field is an int32
_SHOWN = 20  # characters of a wrong text that are shown


def parse_shelf(text: str) -> int:
    """The shelf number that a person typed. Raises ValueError with one line that says why not.

    Which shelves exist is the robot's to say.
    """
    text = text.strip()
    if not text:
        raise ValueError("type a shelf number")
    shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]} ..."
    if not text.removeprefix("-").isdecimal() or not text.isascii():
        raise ValueError(f"not a shelf number: {shown}")
    if len(text) > _SHOWN or int(text) > _INT32_MAX:
        raise ValueError(f"no such shelf: {shown}")
    if int(text) < 1:
        raise ValueError(f"shelves are numbered from 1: {shown}")
    return int(text)


def goal_line(snapshot: Snapshot, now: float, go_key: str) -> Spans:
    """Where the goal stands, in the words of its phase."""
    goal = snapshot.goal
    if goal is None:
        if MOVE not in snapshot.offered:
            return (("move_to_shelf: not offered by any node", OLD),)
        if MOVE in snapshot.faults:
            return ((snapshot.faults[MOVE], WARN),)
        return ((f"No goal yet. Press {go_key}, type a shelf number, press enter.", PLAIN),)
    texts = {
        Phase.SENT: (
            PLAIN,
            f"SENT to {goal.shelf}",
            f"waiting for {_server(snapshot)} ... {seconds_text(now - goal.sent)}",
        ),
        Phase.REFUSED: (BAD, "✗ REFUSED", goal.message),
        Phase.MOVING: (STRONG, f"MOVING to {goal.shelf}", _progress(goal, now)),
        Phase.CANCELLING: (
            STRONG,
            "CANCELLING",
            f"asked {seconds_text(now - (goal.cancel_asked or now))} ago",
        ),
        Phase.CANCELLED: (BAD, "✗ CANCELLED", _where_ended(goal)),
        Phase.ARRIVED: (STRONG, "✓ ARRIVED", _arrival(goal)),
        Phase.ABORTED: (BAD, "✗ ABORTED", goal.message),
        Phase.DISPUTED: (WARN, "? ENDED", goal.message),
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
    return (f"{word:<14}", tone), (f" {rest}", PLAIN)


def goal_bar(goal: Goal | None, width: int) -> Spans:
    """The way driven: a bar with its number beside it."""
    room = max(width - 8, 4)
    if goal is None or goal.phase in (Phase.SENT, Phase.REFUSED) or not goal.length:
        return (("─" * room + "     --", OLD),)
    fraction = goal.fraction()
    done = int(fraction * room)
    tone = ACTIVE if goal.is_running else PLAIN
    return ("━" * done, tone), ("─" * (room - done), OLD), (f" {fraction:5.0%} ", PLAIN)


def goal_history(history: tuple[Goal, ...], width: int) -> Spans:
    """The goals before, newest first, as many as there is room for."""
    if not history:
        return (("before: none", OLD),)
    text = f"before: {_ended(history[0])}"
    for goal in history[1:]:
        longer = f"{text}   {_ended(goal)}"
        if len(longer) > width:
            break
        text = longer
    return ((text, OLD),)


def _server(snapshot: Snapshot) -> str:
    """Who is asked to move: the textbook's node, if it is there."""
    there = any(node.name.endswith(f"/{_TEXTBOOK}") for node in snapshot.nodes)
    return _TEXTBOOK if there else "the robot"


def _progress(goal: Goal, now: float) -> str:
    if goal.unreadable:
        return f"? {goal.unreadable} m left   {seconds_text(goal.elapsed(now))} so far"
    if goal.remaining is None:
        return f"waiting for the first feedback ... {seconds_text(goal.elapsed(now))}"
    if goal.length is None:  # not known yet: no bar, no percentage
        return f"{goal.remaining:.1f} m left   {seconds_text(goal.elapsed(now))} so far"
    left = goal.seconds_left(now)
    about = "" if left is None else f", about {seconds_text(left)} left"
    return (
        f"{goal.remaining:.1f} m left of {goal.length:.1f} m   "
        f"{seconds_text(goal.elapsed(now))} so far{about}"
    )


def _where_ended(goal: Goal) -> str:
    if goal.remaining is None:
        return goal.message
    return f"{goal.message}, {goal.remaining:.1f} m before shelf {goal.shelf}"


def _arrival(goal: Goal) -> str:
    if goal.length is None:
        return goal.message
    return f"{goal.message}, {goal.length:.1f} m in {seconds_text(goal.elapsed(0.0))}"


def _ended(goal: Goal) -> str:
    at = time_of_day(goal.time)
    if goal.phase == Phase.ARRIVED:
        return f"✓ {goal.shelf} arrived {at}"
    if goal.phase == Phase.DISPUTED:
        return f"? {goal.shelf} ended {at}"
    return f"✗ {goal.shelf} {goal.phase.value.lower()} {at}"
