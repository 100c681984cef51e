"""What rclpy's wait set counts. There is no wait set here, and so there are no waitables."""

from __future__ import annotations

from dataclasses import astuple, dataclass


@dataclass(eq=False)
class NumberOfEntities:
    """How many there are of each kind."""

    num_subscriptions: int = 0
    num_guard_conditions: int = 0
    num_timers: int = 0
    num_clients: int = 0
    num_services: int = 0
    num_events: int = 0

    def __add__(self, other: NumberOfEntities) -> NumberOfEntities:
        return NumberOfEntities(*map(sum, zip(astuple(self), astuple(other), strict=True)))
