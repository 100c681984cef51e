"""The rules for what `--plain` prints of events and goals: each fact once. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.words.event import is_of_own_file

_PRINTED_LEVELS = ("YOU", "SHELL", "AI", "PEER", "WARN", "ERROR", "FATAL")


def is_event_news(
    event: Event, goal: Goal | None, hosted: Iterable[Hosted], *, is_ending: bool
) -> bool:
    """Return True if a line is printed for an event.

    None is printed for DEBUG and GOAL, nor for INFO except of the user's own files, nor for what
    another line reports: a failed command, unless the console `is_ending`, and why this console's
    goal was refused.
    """
    if event.level not in _PRINTED_LEVELS:
        return event.level == "INFO" and is_of_own_file(event, hosted)
    record = event.audit_record
    if event.level == "YOU" and record is not None and not Outcome(record.code, "").ok:
        # `failed: ...` reports what failed of the typed line. There is no such line while the
        # console ends, nor for what fails after the line was answered.
        return is_ending or "later" in record.arguments
    if goal is None or not goal.mine or not goal.kind.refusals:
        return True
    # The server logs why it refuses a goal, and `failed: ...` repeats that reason.
    is_refusal = event.text.startswith(goal.kind.refusals)
    is_repeated = event.text.removeprefix(goal.kind.refusals) == goal.message
    is_of_goal = goal.phase == Phase.SENT or (goal.phase == Phase.REFUSED and is_repeated)
    return not (is_refusal and is_of_goal)


def is_goal_news(before: Goal | None, goal: Goal) -> bool:
    """Return True if a line is printed for a goal: it reached a milestone no answer has told."""
    is_changed = before is None or _milestone(before) != _milestone(goal)
    return is_changed and not _is_in_answer(before, goal)


def _milestone(goal: Goal) -> tuple[Phase, bool, bool, int]:
    """Return the parts of a goal's state that are printed when one changes."""
    quarter = min(int(goal.fraction() * 4), 3)
    return goal.phase, bool(goal.unreadable), _has_feedback(goal), quarter


def _is_in_answer(before: Goal | None, goal: Goal) -> bool:
    """Return True if the answer to a line typed here has told this change of the goal already."""
    if before is None or before.phase == Phase.SENT:  # Otherwise the answer came late.
        has_just_begun = goal.phase == Phase.MOVING and not _has_feedback(goal)
        return goal.mine and (has_just_begun or goal.phase in (Phase.SENT, Phase.REFUSED))
    return goal.mine and goal.phase == Phase.CANCELLING and goal.cancel_asked is not None


def _has_feedback(goal: Goal) -> bool:
    """Return True if feedback was received, readable or not."""
    return bool(goal.unreadable or goal.feedback) or goal.remaining is not None
