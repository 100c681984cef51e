"""The last readings of the battery, the motion and the gauges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from archo_tui.robot.period import UNMEASURED, is_silent
from archo_tui.robot_file.model import Gauge


class Battery(NamedTuple):
    """The last battery reading."""

    percentage: float | None = None  # The charge in %; None if it was not within 0 .. 100.
    voltage: float | None = None  # The voltage in V.
    charging: bool | None = None  # True while it charges.
    health: str | None = None  # The battery's own word for its health.
    received: float | None = None  # When the last message came.
    # The seconds between messages: those in the robot file, else the typical interval; None until
    # that is known, some seconds after the first message.
    period: float | None = 1.0
    unreadable: str = ""  # What was received instead of a percentage; "" if one was.
    # The silence in seconds that is allowed while there is no period; None for any.
    grace: float | None = UNMEASURED
    discharging: bool | None = None  # True while it discharges.

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.
        """
        return is_silent(self.received, self.period, now, self.grace)


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Motion:
    """The motion that the robot has reported last."""

    count: int | None = None  # The ticks of the encoder, or whatever the robot file names.
    speed: float | None = None  # The speed, in the unit of the robot file.
    moving: bool | None = None  # True while it moves.
    stopped: bool | None = None  # True while its software stop is latched.
    received: float | None = None  # When the last message came.
    # The seconds between messages: those in the robot file, else the typical interval; None until
    # that is known, some seconds after the first message.
    period: float | None = 0.2
    # The silence in seconds that is allowed while there is no period; None for any.
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.
        """
        return is_silent(self.received, self.period, now, self.grace)


class Pose(NamedTuple):
    """The pose that the robot has reported last."""

    x: float | None = None  # In m.
    y: float | None = None  # In m.
    # The direction in degrees, counter-clockwise from the x axis, -180 to 180.
    yaw: float | None = None
    frame: str = ""  # The name of the frame that the pose is in; "" if it is not reported.
    received: float | None = None  # When the last message came.
    # The seconds between messages: those in the robot file, else the typical interval; None until
    # that is known, some seconds after the first message.
    period: float | None = None
    # The silence in seconds that is allowed while there is no period; None for any.
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.
        """
        return is_silent(self.received, self.period, now, self.grace)


class GaugeReading(NamedTuple):
    """The last number of one of the robot's gauges."""

    gauge: Gauge  # The gauge of the robot file.
    value: float | None = None  # The number.
    received: float | None = None  # When the last message came.
    period: float | None = None  # The typical interval of its messages in seconds.
    unreadable: str = ""  # What was received instead of a number; "" if one was.
    # The silence in seconds that is allowed while there is no period; None for any.
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.
        """
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
