"""The goals that run, those that were lost, and those that ended last. ROS thread only."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable

from archo_tui.clock import Clock
from archo_tui.robot.goal_action import GoalAction
from archo_tui.robot.state import Goal, Phase
from archo_tui.robot.tracked_goal import TrackedGoal

HISTORY = 20  # Ended goals that are kept.
_ENDED_IDS = 100  # Ids that are kept: more than goals end between two status messages.


class GoalRegister:
    """The goals of a session.

    Attributes:
        running: The goals that run, by id, in the order in which tracking began.
        ended_ids: The ids of the last 100 goals that ended.
        lost: The goals that ended as GONE, because their node left, by id: the last 20 or so. One
            that is heard of again is taken out by `GoalFinder`.
        history: The last 20 goals that ended, the newest first.
    """

    def __init__(
        self,
        clock: Clock,
        on_change: Callable[[bool], None],
        on_end: Callable[[Goal, str], None],
    ) -> None:
        """Create a register without goals.

        Args:
            clock: The clock of all times.
            on_change: Called after each change; with True if a goal is new or has another phase.
            on_end: Called with a goal that has ended and a text about its end, except for a refusal
                that came in time: the verb reports it.
        """
        self._clock, self._on_change, self._on_end = clock, on_change, on_end
        self._numbers = itertools.count(1)
        self._last: Goal | None = None  # The goal that ended last.
        self.running: dict[bytes, TrackedGoal] = {}
        self.ended_ids: deque[bytes] = deque(maxlen=_ENDED_IDS)
        self.lost: dict[bytes, TrackedGoal] = {}
        self.history: deque[Goal] = deque(maxlen=HISTORY)

    @property
    def goal(self) -> Goal | None:
        """The goal to show: that of `shown`, or the last that ended; None before the first."""
        shown = self.shown
        return self._last if shown is None else shown.goal

    @property
    def shown(self) -> TrackedGoal | None:
        """The running goal to show: ours, else the one tracked last; None if none runs."""
        return self.ours or next(reversed(self.running.values()), None)

    @property
    def ours(self) -> TrackedGoal | None:
        """The first running goal that this console sent; None if there is none."""
        return next((tracked for tracked in self.running.values() if tracked.goal.mine), None)

    def next_number(self) -> int:
        """Return a number that no other goal of the session has."""
        return next(self._numbers)

    def prepare(self, goal: Goal, goal_id: bytes, action: GoalAction) -> TrackedGoal:
        """Return a tracked goal that is not in the register yet; `add` it just before it is sent.

        Its changes are reported to the register, also before it is added.

        Args:
            goal: The state of the goal.
            goal_id: The 16 bytes of its UUID.
            action: Its action.
        """
        return TrackedGoal(goal, goal_id, action, self._clock, self._goal_changed)

    def add(self, tracked: TrackedGoal) -> None:
        """Add a goal to those that run, and report the change."""
        self.running[tracked.id] = tracked
        self._on_change(True)

    def _goal_changed(self, tracked: TrackedGoal, before: Goal) -> None:
        """Report a change of a goal; move one that has just ended to the history."""
        goal = tracked.goal
        if before.is_running and not goal.is_running:
            self.running.pop(tracked.id, None)
            self.ended_ids.append(tracked.id)
            if goal.phase == Phase.GONE:
                self.lost = {**dict([*self.lost.items()][-HISTORY:]), tracked.id: tracked}
            self._last = goal
            self.history.appendleft(goal)
            # A refusal that comes in time is reported by the verb.
            if goal.phase != Phase.REFUSED or before.phase != Phase.SENT:
                self._on_end(goal, _end_text(goal))
        self._on_change(goal.phase != before.phase)


def _end_text(goal: Goal) -> str:
    """Return how a goal ended: `shelf 12 arrived: MESSAGE`.

    The robot's message alone is returned if it has both the goal's name and the word for its phase.
    """
    word, message = goal.word.lower(), goal.message.lower()
    if message and word in message and goal.name.lower() in message:
        return goal.message
    return f"{goal.name} {word}: {goal.message}".rstrip(": ")
