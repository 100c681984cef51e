"""Goals without end: what is kept of them stays bounded."""

from __future__ import annotations

import gc
from collections import Counter
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node

from archo_tui.robot.goals import HISTORY
from archo_tui.robot.state import Phase
from tests.support import clock
from tests.support.quiet import until
from tests.support.robot import robot

PACE = 1.2  # s: as 500 goals in ten minutes


class Busy(Node):
    """Serves the action, and sends it one goal after the other."""

    def __init__(self, **options: Any) -> None:
        super().__init__("busy", **options)
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
        self.client = ActionClient(self, MoveToShelf, "move_to_shelf")
        self.ended = 0

    def execute(self, goal: Any) -> MoveToShelf.Result:
        goal.succeed()
        return MoveToShelf.Result(success=True)

    def go(self) -> None:
        sent = self.client.send_goal_async(MoveToShelf.Goal(shelf_number=1))
        sent.add_done_callback(
            lambda done: done.result().get_result_async().add_done_callback(self._count)
        )

    def _count(self, _: Any) -> None:
        self.ended += 1


def kinds_kept() -> Counter[str]:
    """How many objects there are of each kind of the console's robot, but for the event log's."""
    gc.collect()
    ours = [type(it).__name__ for it in gc.get_objects() if "archo_tui.robot" in str(type(it))]
    return Counter(name for name in ours if name != "Event")  # of those a thousand are kept


async def test_of_goals_without_end_only_the_last_are_kept() -> None:
    made: list[Busy] = []

    def busy(**options: Any) -> Busy:
        made.append(Busy(**options))
        return made[0]

    async with robot(busy) as it:
        await until(lambda: made[0].client.server_is_ready())
        kept = []
        for number in range(1, 101):
            due = clock.seconds() + (0.0 if clock.current is None else PACE)
            made[0].go()
            await until(lambda number=number: made[0].ended == number)  # type: ignore[misc]
            await until(lambda due=due: clock.seconds() >= due)  # type: ignore[misc]
            await until(lambda: it.snapshot.history and it.snapshot.running == 0)
            if number % 50 == 0:
                kept.append(kinds_kept())
        assert len(it.snapshot.history) == HISTORY
        assert kept[1] == kept[0]


async def test_a_goal_that_ends_at_once_is_history_and_one_before_the_console_came_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants
    made: list[Busy] = []

    def busy(**options: Any) -> Busy:
        made.append(Busy(**options))
        return made[0]

    async with robot(busy) as first:
        await until(lambda: made[0].client.server_is_ready())
        made[0].go()
        await until(lambda: len(first.snapshot.history) == 1)
        ended = first.snapshot.history[0]
        assert (ended.phase, ended.mine) == (Phase.ARRIVED, False)
        now = clock.seconds()
        await until(lambda: clock.seconds() > now)
        domain = made[0].context.get_domain_id()
        async with robot(only=True, nodes=1, domain_id=domain) as second:
            await until(lambda: "move_to_shelf" in second.snapshot.offered)
            made[0].go()
            await until(lambda: len(first.snapshot.history) == 2 and second.snapshot.history)
            assert len(second.snapshot.history) == 1
