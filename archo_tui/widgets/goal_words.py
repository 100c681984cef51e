"""Where a goal stands: its words, its bar, and the goals before. Pure: state in, text out."""

from __future__ import annotations

from textual.content import Content

from archo_tui.clock import time_of_day
from archo_tui.robot.state import MOVE, Goal, Phase, Snapshot
from archo_tui.widgets import words
from archo_tui.widgets.words import seconds_text

_TEXTBOOK = "motor_controller"


def goal_line(snapshot: Snapshot, now: float, go_key: str) -> Content:
    """Where the goal stands, in the words of its phase."""
    goal = snapshot.goal
    if goal is None:
        if MOVE not in snapshot.offered:
            return Content.styled("move_to_shelf: not offered by any node", words.OLD)
        return Content(f"No goal yet. Press {go_key}, type a shelf number, press enter.")
    texts = {
        Phase.SENT: (
            "",
            f"SENT to {goal.shelf}",
            f"waiting for {_server(snapshot)} ... {seconds_text(now - goal.sent)}",
        ),
        Phase.REFUSED: (words.BAD, "✗ REFUSED", goal.message),
        Phase.MOVING: ("bold", f"MOVING to {goal.shelf}", _progress(goal, now)),
        Phase.CANCELLING: (
            "bold",
            "CANCELLING",
            f"asked {seconds_text(now - (goal.cancel_asked or now))} ago",
        ),
        Phase.CANCELLED: (words.BAD, "✗ CANCELLED", _where_ended(goal)),
        Phase.ARRIVED: ("bold", "✓ ARRIVED", _arrival(goal)),
        Phase.ABORTED: (words.BAD, "✗ ABORTED", goal.message),
        Phase.UNKNOWN: (
            words.WARN,
            "? UNKNOWN",
            f"no answer for {seconds_text(now - (goal.heard or goal.sent))}; "
            "the goal may be running (asking again)",
        ),
        Phase.LOST: (
            words.BAD,
            "✗ LOST",
            f"nothing heard for {seconds_text(now - (goal.heard or now))}; "
            "the robot may still be moving",
        ),
    }
    style, word, rest = texts[goal.phase]
    return Content.assemble((f"{word:<14}", style), f" {rest}")


def goal_bar(goal: Goal | None, width: int) -> Content:
    """The way driven: a bar with its number beside it."""
    room = max(width - 8, 4)
    fraction = goal.fraction() if goal is not None else 0.0
    done = int(fraction * room)
    if goal is None or goal.phase in (Phase.SENT, Phase.REFUSED):
        return Content.styled("─" * room + "     --", words.OLD)
    style = "$primary" if goal.is_running else ""
    return Content.assemble(
        ("━" * done, style), ("─" * (room - done), words.OLD), f" {fraction:5.0%} "
    )


def goal_history(history: tuple[Goal, ...], width: int) -> Content:
    """The goals before, newest first, as many as there is room for."""
    if not history:
        return Content.styled("before: none", words.OLD)
    text = f"before: {_ended(history[0])}"
    for goal in history[1:]:
        longer = f"{text}   {_ended(goal)}"
        if len(longer) > width:
            break
        text = longer
    return Content.styled(text, words.OLD)


def _server(snapshot: Snapshot) -> str:
    """Who is asked to move: the textbook's node, if it is there."""
    there = any(node.name.endswith(f"/{_TEXTBOOK}") for node in snapshot.nodes)
    return _TEXTBOOK if there else "the robot"


def _progress(goal: Goal, now: float) -> str:
    if goal.remaining is None or goal.length is None:
        return f"waiting for the first feedback ... {seconds_text(goal.elapsed(now))}"
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
    return f"✗ {goal.shelf} {goal.phase.value.lower()} {at}"
