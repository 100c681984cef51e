"""The status of a part of the robot, as it reports it by diagnostic_msgs."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

# Seconds after which a status is stale, at least. diagnostic_updater publishes each second, and
# diagnostic_aggregator calls a status stale after 5 s.
LEAST_STALE = 5.0
GONE = 60.0  # Seconds of silence after which a part may be forgotten; our choice.


class DiagnosticLevel(Enum):
    """The levels of diagnostic_msgs/msg/DiagnosticStatus, by their words."""

    OK = "OK"
    WARN = "WARN"
    ERROR = "ERROR"
    STALE = "STALE"


# The levels, the worst first: of a silent part is known less than of one that warns.
WORST_FIRST = (
    *(DiagnosticLevel.ERROR, DiagnosticLevel.WARN, DiagnosticLevel.STALE),
    DiagnosticLevel.OK,
)


class Diagnostic(NamedTuple):
    """The last status of one part of the robot."""

    name: str  # The name of the part, as diagnostics have it: `base: left motor`.
    hardware_id: str  # The part's serial number or the like; may be "".
    level: DiagnosticLevel  # The level that it reported.
    message: str  # The text that it reported.
    received: float  # When the last status came, in monotonic seconds.
    period: float | None = None  # The typical interval of its statuses in seconds.

    @property
    def key(self) -> tuple[str, str]:
        """The name and the hardware id, by which parts differ."""
        return self.name, self.hardware_id

    @property
    def part(self) -> str:
        """The part as people read it: `base: left motor (sn 12)`."""
        return f"{self.name} ({self.hardware_id})" if self.hardware_id else self.name

    def is_gone_at(self, now: float) -> bool:
        """Return True if it is stale, and has been silent for at least GONE seconds."""
        return self.is_silent_at(now) and now - self.received >= GONE

    def level_at(self, now: float) -> DiagnosticLevel:
        """Return the reported level, or STALE after three periods of silence, at least 5 s."""
        return DiagnosticLevel.STALE if self.is_silent_at(now) else self.level

    def is_silent_at(self, now: float) -> bool:
        """Return True after three periods without a status, at least 5 s."""
        return now - self.received > max(3 * (self.period or 0.0), LEAST_STALE)
