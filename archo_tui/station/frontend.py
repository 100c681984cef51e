"""The frontend of a station: the part that shows it to its operator and runs its work."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any, Protocol

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome


class Frontend(Protocol):
    """The part that shows the station to its operator and runs its work.

    It is the app, `--plain`, or the connection of a shell verb that runs without a console. All
    methods but `restart` are called on its event loop.
    """

    def carry_out(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Start work that the operator requested; the app's shutdown waits for it."""

    def run_in_background(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Start work that another program requested; the shutdown does not wait for it."""

    def on_goal_answered(self, goal: QueuedGoal, outcome: Outcome) -> None:
        """Tell the operator how the robot answered a queued goal: its verb returned long before."""

    @property
    def has_person(self) -> bool:
        """True if somebody sees the requests of assistants and can answer them."""

    def close_questions(self) -> None:
        """Close the questions to the operator, because another console sent a STOP."""

    def restart(self, why: str) -> None:
        """Start the process again, or say that this is left to a person; `why` is for the operator.

        Do nothing in a process that hosts no nodes. May be called on any thread.
        """
