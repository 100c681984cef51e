"""A goal that is followed, by itself: when silence means that it is lost."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.task import Future

from archo_tui.robot.followed import Followed
from archo_tui.robot.state import Goal, Motion, Phase
from tests.support.archo import SHELF
from tests.support.stub import StandingClock


class ServedAction:
    """An action whose server is there, and does not say how its goals end."""

    is_served = True

    def ask_result(self, goal_id: bytes) -> Future[Any]:
        return Future()


class Feedback:
    distance_remaining = 5.0


@pytest.mark.parametrize(
    ("period", "longest"),
    [(0.5, 3.0), (2.0, 6.0)],
    ids=["three seconds", "three periods"],
)
def test_it_is_lost_after_so_long_without_feedback_where_no_motion_is_told(
    period: float, longest: float
) -> None:
    clock = StandingClock()
    goal = Goal(SHELF, {"shelf_number": 3}, Phase.MOVING, clock.monotonic(), clock.now())
    followed = Followed(goal, b"1", ServedAction(), clock, lambda *_: None)
    for _ in range(3):
        clock.passed += period
        followed.on_feedback(Feedback())
    seen: list[Phase] = []
    for passed in (longest - 0.1, longest + 0.1):
        followed.check(clock.monotonic() + passed, Motion())
        seen.append(followed.goal.phase)
    assert seen == [Phase.MOVING, Phase.LOST]
