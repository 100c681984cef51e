"""The module `rclpy.duration`."""

from __future__ import annotations

from dataclasses import dataclass

import builtin_interfaces.msg

S_TO_NS = 1_000_000_000
_INFINITE = 2**63 - 1  # In ns.


@dataclass(frozen=True, order=True, init=False)
class Duration:
    """A span of time in ns, which may be negative."""

    nanoseconds: int

    def __init__(self, *, seconds: float = 0, nanoseconds: int = 0) -> None:
        object.__setattr__(self, "nanoseconds", int(seconds * S_TO_NS) + int(nanoseconds))

    def __str__(self) -> str:
        return "Infinite" if self.nanoseconds == _INFINITE else f"{self.nanoseconds} nanoseconds"

    def __add__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(nanoseconds=self.nanoseconds + other.nanoseconds)

    def __sub__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(nanoseconds=self.nanoseconds - other.nanoseconds)

    def __mul__(self, factor: float) -> Duration:
        if not isinstance(factor, (int, float)):
            return NotImplemented
        return Duration(nanoseconds=int(self.nanoseconds * factor))

    @classmethod
    def from_msg(cls, msg: builtin_interfaces.msg.Duration) -> Duration:
        """Return the span that a message carries; raise TypeError for another type of message."""
        if not isinstance(msg, builtin_interfaces.msg.Duration):
            raise TypeError("Must pass a builtin_interfaces.msg.Duration object")
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec)

    def to_msg(self) -> builtin_interfaces.msg.Duration:
        """Return the span as builtin_interfaces/Duration."""
        sec, nanosec = divmod(self.nanoseconds, S_TO_NS)
        return builtin_interfaces.msg.Duration(sec=sec, nanosec=nanosec)


Infinite = Duration(nanoseconds=_INFINITE)
