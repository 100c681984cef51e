"""Everything that a frontend shows at one moment, and the recorder that keeps it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Hosted, Snapshot
from archo_tui.station.alarms import Alarm
from archo_tui.station.approvals import ApprovalRequest
from archo_tui.station.history import History


@dataclass(frozen=True)
class View:
    """Everything that a frontend shows at one moment.

    Attributes:
        snapshot: The state of the robot.
        now: Monotonic time in seconds.
        second: The same at the last tick of the clock, for ages that need not be livelier.
        time: Unix time in seconds.
        engine: The engine in words; see `engine.describe`.
        namespace: The namespace of the robot.
        history: The curves of the last hour; a console goes on to add to them.
        alarms: All alarms that are not normal, in the order in which they are shown.
        hosted: The nodes of this process.
        watching: True if every command is refused, STOP included.
        queue: The goals that wait, the next one first.
        held: The reason why the queue is held, in words; "" if it is not.
        changing: True while a change of parameters from here has no answer.
        clients: The programs that are connected, by their names for people.
        requests: The requests of assistants that wait for a person, the oldest first.
        restart_waits: True while a restart of the console waits for the release of a STOP, and
            then for a key.
        is_restarting: True once the console is about to start again.
        replay: In a replay, words that say so; "" if the robot itself is shown.
    """

    snapshot: Snapshot
    now: float
    second: float
    time: float
    engine: str
    namespace: str
    history: History
    alarms: tuple[Alarm, ...] = ()
    hosted: tuple[Hosted, ...] = ()
    watching: bool = False
    queue: tuple[QueuedGoal, ...] = ()
    held: str = ""
    changing: bool = False
    clients: tuple[str, ...] = ()
    requests: tuple[ApprovalRequest, ...] = ()
    restart_waits: bool = False
    is_restarting: bool = False
    replay: str = ""

    @property
    def waiting(self) -> tuple[str, ...]:
        """The goals of the queue in words, the next one first."""
        return tuple(goal.text for goal in self.queue)


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
