"""What rclpy's wait set counts. There is no wait set here, and so nothing waits in it."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any


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


class Waitable:
    """What one's own things in a wait set derive from. Here none can be made."""

    def __init__(self, callback_group: Any) -> None:
        raise NotImplementedError("the embedded engine has no wait set, and so no waitables")
