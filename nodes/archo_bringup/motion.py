"""A model of ARCHO's drive along a route, in m and s; it knows nothing of ROS."""

from __future__ import annotations

import math

START_TICKS = 15420  # The textbook's reading before the first reset.

_NOTHING = 1e-9  # In m; a smaller rest comes from adding floats.


class Drive:
    """A drive with its encoder, and the route that is being driven, if any."""

    def __init__(self) -> None:
        self.remaining = 0.0  # In m.
        self._ticks = float(START_TICKS)

    @property
    def encoder_ticks(self) -> int:
        """Return the whole ticks since the last reset."""
        return int(self._ticks)

    def reset_encoder(self) -> int:
        """Zero the encoder, and return the ticks it had."""
        ticks, self._ticks = self.encoder_ticks, 0.0
        return ticks

    def begin(self, length: float) -> None:
        """Start a route of `length` m."""
        self.remaining = length

    def advance(self, distance: float, ticks_per_metre: float) -> bool:
        """Drive up to `distance` m further, and return True if the route's end is reached."""
        driven = min(distance, self.remaining)
        self.remaining -= driven
        if self.remaining < _NOTHING:
            self.remaining = 0.0
        self._ticks += driven * ticks_per_metre
        return self.remaining == 0.0


def ticks_per_metre(wheel_radius: float, ticks_per_revolution: int) -> float:
    """Return the encoder ticks for each metre driven on a wheel of that radius (m)."""
    return ticks_per_revolution / (2 * math.pi * wheel_radius)


# Seconds that a timer may be late on a busy machine. After a longer gap the process was suspended.
LATE = 0.5


class Steps:
    """A counter of the control periods that have passed since the last call.

    A late timer makes up for the periods that it missed. A process that was suspended does not: it
    could have taken no cancel and no stop meanwhile, and goes on with one step.
    """

    def __init__(self, start_ns: int, period_ns: int) -> None:
        self._start_ns = start_ns
        self._period_ns = period_ns
        self._taken = 0

    def due(self, now_ns: int) -> int:
        """Return how many periods to drive now. 1 % early counts as passed."""
        passed = int((now_ns - self._start_ns) / self._period_ns + 0.01)
        new, self._taken = passed - self._taken, max(passed, self._taken)
        longest = max(LATE * 1e9 / self._period_ns, 1)
        return 1 if new > longest else max(new, 0)
