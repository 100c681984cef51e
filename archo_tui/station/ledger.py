"""The requests to the robot that have no answer yet, whoever made them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.robot_file.model import GoalKind

RELEASE = "release"


class Ledger:
    """The requests without an answer, which the last snapshot does not show yet.

    Used on the event loop only.

    Attributes:
        goal: Our goal on its way to the robot; None if there is none, and once it is refused or a
            snapshot shows it.
        newest_before: The number of the newest goal, of any client, that was known when ours was
            entered; 0 if there was none.
        is_handed_over: True if the goal entered last was handed to the robot's thread, so that only
            a cancel request can stop it.
        is_cancelled: True if that goal was cancelled before it was handed over.
    """

    def __init__(self) -> None:
        """Create a ledger without requests."""
        self.goal: Goal | None = None
        self.newest_before = 0
        self.is_handed_over = False
        self.is_cancelled = False
        self._pending: Counter[str] = Counter()

    def enter_goal(self, kind: GoalKind, values: Mapping[str, Any], snapshot: Snapshot) -> None:
        """Enter a goal that is to be sent now, in the place of an earlier one.

        Args:
            kind: The robot file's entry for the goal.
            values: The values of the goal, by dotted path in the goal message.
            snapshot: The state of the robot before the goal is sent.
        """
        self.goal = Goal(kind, values, Phase.SENT, 0.0, 0.0)
        self.newest_before = max((goal.number for goal in _goals_shown(snapshot)), default=0)
        self.is_handed_over = self.is_cancelled = False

    def remove_goal(self) -> None:
        """Remove the goal: it was refused, or is not sent."""
        self.goal = None

    def remove_goal_if_shown(self, snapshot: Snapshot) -> None:
        """Remove the goal if the snapshot shows it, or a later goal of this console.

        From then on the snapshot tells the goal's state.
        """
        if any(goal.mine and goal.number > self.newest_before for goal in _goals_shown(snapshot)):
            self.goal = None

    def running_goal(self, snapshot: Snapshot) -> Goal | None:
        """Return our goal on its way, else any client's running goal in the snapshot, else None."""
        return snapshot.running_goal if self.goal is None else self.goal

    @contextmanager
    def pending(self, request: str) -> Iterator[None]:
        """Count a request as unanswered while the context lasts.

        Args:
            request: The name of the request, as RELEASE.
        """
        self._pending[request] += 1
        try:
            yield
        finally:
            self._pending[request] -= 1

    def is_pending(self, request: str) -> bool:
        """Return True if a request of that name has no answer yet."""
        return self._pending[request] > 0


def _goals_shown(snapshot: Snapshot) -> list[Goal]:
    """Return the goal of a snapshot, if there is one, and those that have ended."""
    return [goal for goal in (snapshot.goal, *snapshot.history) if goal is not None]
