"""Goals without end: what is kept of them stays bounded."""

from __future__ import annotations

import gc
from collections import Counter
from typing import Any

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node

from archo_tui.robot.goals.client import HISTORY
from archo_tui.robot.state.goal import Phase
from tests.support import clock
from tests.support.archo import go
from tests.support.by_hand import ByHand
from tests.support.night import corners
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.ros import begin

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
    # of those a thousand are kept, some with a record
    return Counter(name for name in ours if name not in ("Event", "AuditRecord"))


@pytest.mark.parametrize("count", corners([24], [100]))
async def test_of_goals_without_end_only_the_last_are_kept(count: int) -> None:
    made: list[Busy] = []
    async with robot(making(made, Busy)) as it:
        await until(lambda: made[0].client.server_is_ready())
        kept = []
        for number in range(1, count + 1):
            due = clock.seconds() + (0.0 if clock.current is None else PACE)
            begin(made[0], made[0].go)
            await until(lambda number=number: made[0].ended == number)  # type: ignore[misc]
            await until(lambda due=due: clock.seconds() >= due)  # type: ignore[misc]
            await until(lambda: it.snapshot.history and it.snapshot.running == 0)
            if number % (count // 2) == 0:
                kept.append(kinds_kept())
        assert len(it.snapshot.history) == HISTORY
        grown = kept[1] - kept[0]  # a reading may be under way
        assert {kind: more for kind, more in grown.items() if more >= min(count // 2, 11)} == {}


class Backward(ByHand):
    """Tells the result of a goal first, and its status later."""

    def __init__(self, **options: Any) -> None:
        super().__init__("backward", **options)
        self.later = self.create_timer(0.2, self.tell)
        self.told = GoalStatusArray()
        self.published = 0

    async def accept(self, request: Any, response: Any) -> Any:
        status = GoalStatus(status=GoalStatus.STATUS_SUCCEEDED)
        status.goal_info.goal_id = request.goal_id
        status.goal_info.stamp = self.get_clock().now().to_msg()
        self.told.status_list = [*self.told.status_list, status]
        return await super().accept(request, response)

    async def result(self, _: Any, response: Any) -> Any:
        response.status = GoalStatus.STATUS_SUCCEEDED
        response.result.success = True
        self.later.reset()
        return response

    def tell(self) -> None:
        self.status.publish(self.told)
        self.published += len(self.told.status_list)


async def test_an_own_goal_whose_status_comes_behind_its_result_is_not_taken_for_anothers() -> None:
    made: list[Backward] = []
    async with robot(making(made, Backward), offers="move_to_shelf") as it:
        assert (await ended(go(it, 1))).ok
        await until(lambda: it.snapshot.history)
        published = made[0].published
        await until(lambda: made[0].published > published + 1)  # and one before it was taken in
        assert [(goal.mine, goal.phase) for goal in it.snapshot.history] == [(True, Phase.ARRIVED)]


async def test_a_short_goal_is_history_and_one_before_the_console_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants
    made: list[Busy] = []
    async with robot(making(made, Busy)) as first:
        await until(lambda: made[0].client.server_is_ready())
        begin(made[0], made[0].go)
        await until(lambda: len(first.snapshot.history) == 1)
        over = first.snapshot.history[0]
        assert (over.phase, over.mine) == (Phase.ARRIVED, False)
        now = clock.seconds()
        await until(lambda: clock.seconds() > now)
        domain = made[0].context.get_domain_id()
        async with robot(only=True, nodes=1, domain_id=domain, offers="move_to_shelf") as second:
            begin(made[0], made[0].go)
            await until(lambda: len(first.snapshot.history) == 2 and second.snapshot.history)
            assert len(second.snapshot.history) == 1
