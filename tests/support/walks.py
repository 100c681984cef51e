"""What the random walks with STOPs have in common, on the screen and in `--plain`."""

from __future__ import annotations

import random
from typing import Any

import pytest
from archo_bringup.motor_controller import MotorController

_ROUNDS, _FAR = 5, 80


def length(which: int, request: pytest.FixtureRequest) -> tuple[int, int]:
    """The seed and how many rounds: by night another walk each time, and a long one."""
    far = request.config.getoption("--night")
    return (random.randrange(10**6), _FAR) if far else (which, _ROUNDS)


class Counting(MotorController):
    """Counts its goals: a walk in which nothing drives shows nothing."""

    driven = 0

    async def execute_move(self, goal: Any) -> Any:
        self.driven += 1
        return await super().execute_move(goal)
