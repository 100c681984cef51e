"""Everything that a frontend shows at one moment, and the recorder that keeps it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.station.alarms import Alarm
from archo_tui.station.approvals import ApprovalRequest
from archo_tui.station.history import History


@dataclass(frozen=True)
class View:
    """Everything that a frontend shows at one moment."""

    snapshot: Snapshot
    now: float  # monotonic, s
    second: float  # The same at the last tick, for ages that need not be livelier.
    time: float  # Unix, s
    engine: str  # In words; see `engine.describe`.
    namespace: str
    history: History  # A console goes on to add to it.
    alarms: tuple[Alarm, ...] = ()  # Those that are not normal, as they are shown.
    hosted: tuple[Hosted, ...] = ()  # The nodes of this process.
    watching: bool = False  # Every command is refused, STOP included.
    queue: tuple[QueuedGoal, ...] = ()  # The next one first.
    held: str = ""  # Why the queue is held.
    clients: tuple[str, ...] = ()  # The connected programs.
    requests: tuple[ApprovalRequest, ...] = ()  # The oldest first.
    restart_waits: bool = False  # For the release of a STOP, and then for a key.
    is_restarting: bool = False
    publishes: tuple[str, ...] = ()  # What the console itself publishes, in words.
    replay: str = ""  # In a replay, words that say so.

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
        """Record a new view, with the alarms whose state differs from the last one."""

    @property
    def kept(self) -> str:
        """The name of the last recording that was begun by hand; "" if none is on the disk."""

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Begin to record by hand; `written` is called when it is on the disk or failed."""
