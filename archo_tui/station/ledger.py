"""What was asked of the robot and has no answer yet, whoever asked for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.robot_file.model import GoalKind

RELEASE = "release"


class Ledger:
    """The requests without an answer: they count before the last snapshot does.

    Used on the loop only.
    """

    def __init__(self) -> None:
        self.goal: Goal | None = None  # ours, until it is refused or a snapshot shows it
        self.before = 0  # the newest goal that was known when it was asked for
        self.has_left = False  # its request was handed to the robot's thread
        self.is_cancelled = False  # before that
        self._requests: Counter[str] = Counter()

    def send(self, kind: GoalKind, values: Mapping[str, Any], snapshot: Snapshot) -> None:
        """Enter a goal that is to be sent now."""
        self.goal = Goal(kind, values, Phase.SENT, 0.0, 0.0)
        self.before = max((goal.number for goal in _known(snapshot)), default=0)
        self.has_left = self.is_cancelled = False

    def drop(self) -> None:
        """Strike out the goal: it was refused, or is not sent."""
        self.goal = None

    def take(self, snapshot: Snapshot) -> None:
        """Strike out the goal when the snapshot shows it."""
        if any(goal.mine and goal.number > self.before for goal in _known(snapshot)):
            self.goal = None

    def running_goal(self, snapshot: Snapshot) -> Goal | None:
        """Return our goal on its way, else the goal that runs as the snapshot has it."""
        return snapshot.running_goal if self.goal is None else self.goal

    @contextmanager
    def asking(self, request: str) -> Iterator[None]:
        """Enter a request while it is waited for."""
        self._requests[request] += 1
        try:
            yield
        finally:
            self._requests[request] -= 1

    def waits_for(self, request: str) -> bool:
        """Return whether such a request has no answer yet."""
        return self._requests[request] > 0


def _known(snapshot: Snapshot) -> list[Goal]:
    return [goal for goal in (snapshot.goal, *snapshot.history) if goal is not None]
