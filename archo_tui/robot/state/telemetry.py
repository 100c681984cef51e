"""The last readings of the battery, the motion and the gauges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from archo_tui.robot.period import UNMEASURED, is_silent
from archo_tui.robot_file.model import Gauge


class Battery(NamedTuple):
    """The last battery reading.

    Attributes:
        percentage: The charge in %; None if it was not within 0 .. 100.
        voltage: The voltage in V.
        charging: True while it charges.
        health: The battery's own word for its health.
        received: When the last message came.
        period: The seconds between messages: those in the robot file, else the typical interval;
            None until that is known, some seconds after the first message. Without meaning before.
        unreadable: What was received instead of a percentage; "" if one was.
        grace: The silence in seconds that is allowed while there is no period; None for any.
        discharging: True while it discharges; None means whenever it does not charge.
    """

    percentage: float | None = None
    voltage: float | None = None
    charging: bool | None = None
    health: str | None = None
    received: float | None = None
    period: float | None = 1.0
    unreadable: str = ""
    grace: float | None = UNMEASURED
    discharging: bool | None = None

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.

        Args:
            now: Monotonic time in seconds.
        """
        return is_silent(self.received, self.period, now, self.grace)


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Motion:
    """The motion that the robot has reported last.

    Attributes:
        count: The ticks of the encoder, or whatever the robot file names.
        speed: The speed, in the unit of the robot file.
        moving: True while it moves.
        stopped: True while its software stop is latched.
        received: When the last message came.
        period: The seconds between messages: those in the robot file, else the typical interval;
            None until that is known, some seconds after the first message. Without meaning before.
        grace: The silence in seconds that is allowed while there is no period; None for any.
    """

    count: int | None = None
    speed: float | None = None
    moving: bool | None = None
    stopped: bool | None = None
    received: float | None = None
    period: float | None = 0.2
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.

        Args:
            now: Monotonic time in seconds.
        """
        return is_silent(self.received, self.period, now, self.grace)


class Pose(NamedTuple):
    """The pose that the robot has reported last.

    Attributes:
        x: In m.
        y: In m.
        yaw: The direction in degrees, counter-clockwise from the x axis, -180 to 180.
        frame: The name of the frame that the pose is in; "" if it is not reported.
        received: When the last message came.
        period: The seconds between messages: those in the robot file, else the typical interval;
            None until that is known, some seconds after the first message.
        grace: The silence in seconds that is allowed while there is no period; None for any.
    """

    x: float | None = None
    y: float | None = None
    yaw: float | None = None
    frame: str = ""
    received: float | None = None
    period: float | None = None
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.

        Args:
            now: Monotonic time in seconds.
        """
        return is_silent(self.received, self.period, now, self.grace)


class GaugeReading(NamedTuple):
    """The last number of one of the robot's gauges.

    Attributes:
        gauge: The gauge of the robot file.
        value: The number.
        received: When the last message came.
        period: The typical interval of its messages in seconds; None until it is known, some
            seconds after the first message.
        unreadable: What was received instead of a number; "" if one was.
        grace: The silence in seconds that is allowed while there is no period; None for any.
    """

    gauge: Gauge
    value: float | None = None
    received: float | None = None
    period: float | None = None
    unreadable: str = ""
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True if no message came for three periods, at least 2.5 s; False if none ever did.

        While no period is known, `grace` decides.

        Args:
            now: Monotonic time in seconds.
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
