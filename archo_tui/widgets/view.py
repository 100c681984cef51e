"""What every widget is shown: a snapshot, and the time it is shown at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from archo_tui.alarms import Alarm
from archo_tui.robot.state import Hosted, Snapshot


@dataclass(frozen=True)
class View:
    """One moment of the screen."""

    snapshot: Snapshot
    now: float  # monotonic s
    second: float  # the same, at the last tick of the clock: ages that need not be livelier
    time: float  # Unix time
    engine: str
    namespace: str
    alarms: tuple[Alarm, ...] = ()
    hosted: tuple[Hosted, ...] = ()  # the nodes of this process
    keys: Mapping[str, str] = field(default_factory=dict)  # of each command, as a person reads it
    blocked: frozenset[str] = frozenset()  # commands that cannot run now

    def key(self, command: str) -> str:
        """The key of a command, by its id."""
        return self.keys[command]
