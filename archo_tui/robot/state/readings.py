"""The last readings of battery, motion, pose, gauges and diagnostics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple

from archo_tui.robot.messages.period import UNMEASURED, is_silent
from archo_tui.robot_file.model import Gauge


class Battery(NamedTuple):
    """The last battery reading."""

    percentage: float | None = None  # The charge in %; None if it was not within 0 .. 100.
    voltage: float | None = None  # The voltage in V.
    charging: bool | None = None
    health: str | None = None  # The battery's own word for its health.
    received: float | None = None
    period: float | None = 1.0  # Without meaning before the first message.
    unreadable: str = ""  # What was received instead of a percentage; "" if one was.
    grace: float | None = UNMEASURED
    discharging: bool | None = None

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Motion:
    """The motion that the robot has reported last."""

    count: int | None = None  # The ticks of the encoder, or whatever the robot file names.
    speed: float | None = None  # The speed, in the unit of the robot file.
    moving: bool | None = None
    stopped: bool | None = None  # True while its software stop is latched.
    received: float | None = None
    period: float | None = 0.2
    grace: float | None = UNMEASURED

    def _replace(self, **changes: Any) -> Motion:
        return replace(self, **changes)

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)


class Pose(NamedTuple):
    """The pose that the robot has reported last."""

    x: float | None = None  # In m.
    y: float | None = None  # In m.
    # The direction in degrees, counter-clockwise from the x axis, -180 to 180.
    yaw: float | None = None
    frame: str = ""  # The name of the frame that the pose is in; "" if it is not reported.
    received: float | None = None
    period: float | None = None
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)


class GaugeReading(NamedTuple):
    """The last number of one of the robot's gauges."""

    gauge: Gauge
    value: float | None = None
    received: float | None = None
    period: float | None = None
    unreadable: str = ""  # What was received instead of a number; "" if one was.
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)

    @property
    def warning(self) -> str:
        """A text such as `above 60` if the number is beyond a limit of the robot file; else ""."""
        value, below, above = self.value, self.gauge.warn_below, self.gauge.warn_above
        if value is not None and below is not None and value < below:
            return f"below {below:g}"
        if value is not None and above is not None and value > above:
            return f"above {above:g}"
        return ""


# Seconds after which a status is stale, at least. diagnostic_updater publishes each second, and
# diagnostic_aggregator calls a status stale after 5 s.
LEAST_STALE = 5.0
FORGET_AFTER = 60.0  # Seconds of silence after which a part may be forgotten; our choice.


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
    level: DiagnosticLevel
    message: str
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
        """Return True if it is stale, and has been silent for at least FORGET_AFTER seconds."""
        return self.is_silent_at(now) and now - self.received >= FORGET_AFTER

    def level_at(self, now: float) -> DiagnosticLevel:
        """Return the reported level, or STALE after three periods of silence, at least 5 s."""
        return DiagnosticLevel.STALE if self.is_silent_at(now) else self.level

    def is_silent_at(self, now: float) -> bool:
        """Return True after three periods without a status, at least 5 s."""
        return now - self.received > max(3 * (self.period or 0.0), LEAST_STALE)
