"""What every widget is shown: a snapshot, and the time it is shown at."""

from __future__ import annotations

from dataclasses import dataclass

from archo_tui.alarms import Alarm
from archo_tui.robot.state import Snapshot


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
