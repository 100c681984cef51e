"""The module `rclpy.time`: a point in time of one kind of clock."""

from __future__ import annotations

from functools import total_ordering
from typing import overload

import builtin_interfaces.msg
from rclpy.clock_type import ClockType
from rclpy.duration import S_TO_NS, Duration

_LAST_SECOND = 2**31 - 1  # `sec` of builtin_interfaces/Time is an int32.


@total_ordering
class Time:
    """A point in time, in ns since its clock's epoch.

    Comparing times of two kinds of clock, also by `==`, or subtracting them raises TypeError.
    A time below 0 raises ValueError.
    """

    def __init__(
        self,
        *,
        seconds: float = 0,
        nanoseconds: int = 0,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
    ) -> None:
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        self._nanoseconds = int(seconds * S_TO_NS) + int(nanoseconds)
        if self._nanoseconds < 0:
            raise ValueError("a time must not be negative")
        self._clock_type = clock_type

    @property
    def nanoseconds(self) -> int:
        """Return the nanoseconds since the epoch."""
        return self._nanoseconds

    @property
    def clock_type(self) -> ClockType:
        """Return the kind of clock that told this time."""
        return self._clock_type

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Return whole seconds since the epoch, and the nanoseconds left."""
        return divmod(self._nanoseconds, S_TO_NS)

    def __repr__(self) -> str:
        return f"Time(nanoseconds={self._nanoseconds}, clock_type={self._clock_type.name})"

    def __add__(self, other: Duration) -> Time:
        if not isinstance(other, Duration):
            return NotImplemented
        total = self._nanoseconds + other.nanoseconds
        return Time(nanoseconds=total, clock_type=self._clock_type)

    __radd__ = __add__

    @overload
    def __sub__(self, other: Time) -> Duration: ...

    @overload
    def __sub__(self, other: Duration) -> Time: ...

    def __sub__(self, other: Time | Duration) -> Time | Duration:
        if isinstance(other, Duration):
            left = self._nanoseconds - other.nanoseconds
            return Time(nanoseconds=left, clock_type=self._clock_type)
        if not isinstance(other, Time):
            return NotImplemented
        self._check(other, "subtract")
        return Duration(nanoseconds=self._nanoseconds - other._nanoseconds)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        self._check(other)
        return self._nanoseconds == other._nanoseconds

    def __lt__(self, other: Time) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        self._check(other)
        return self._nanoseconds < other._nanoseconds

    def _check(self, other: Time, doing: str = "compare") -> None:
        if self._clock_type != other._clock_type:
            raise TypeError(f"Can't {doing} times with different clock types")

    def to_msg(self) -> builtin_interfaces.msg.Time:
        """Return the time as builtin_interfaces/Time, which ends in January 2038.

        Unlike in rclpy, the seconds of a later time become the last possible ones.
        """
        sec, nanosec = self.seconds_nanoseconds()
        sec = min(sec, _LAST_SECOND)
        return builtin_interfaces.msg.Time(sec=sec, nanosec=nanosec)

    @classmethod
    def from_msg(
        cls, msg: builtin_interfaces.msg.Time, clock_type: ClockType = ClockType.ROS_TIME
    ) -> Time:
        """Return the time that a message carries."""
        if not isinstance(msg, builtin_interfaces.msg.Time):
            raise TypeError("Must pass a builtin_interfaces.msg.Time object")
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec, clock_type=clock_type)
