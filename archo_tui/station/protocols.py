"""The parts of the console that a station calls: its frontend and its recorder."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from typing import Any, Protocol

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome
from archo_tui.station.alarms import Alarm
from archo_tui.station.view import View


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
        """Start the process again, or say that this is left to a person.

        Do nothing in a process that hosts no nodes. May be called on any thread.

        Args:
            why: The reason in words, for the operator.
        """


class Recorder(Protocol):
    """The part of the black box that the station uses."""

    @property
    def trouble(self) -> str:
        """A failure of recordings that the operator has to know; "" if there is none."""

    def on_view(self, view: View, changed: Sequence[Alarm]) -> None:
        """Record a new view.

        Args:
            view: The view.
            changed: The alarms whose state differs from the last view.
        """

    @property
    def kept(self) -> str:
        """The name of the last recording that was begun by hand; "" if none is on the disk."""

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Begin to record the last minute by hand; call it on the loop.

        Args:
            written: Is called on the loop when the recording is on the disk, or cannot be written.

        Returns:
            DONE if the recording has begun: only then `written` is called, once.
        """
