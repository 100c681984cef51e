"""Goals at a robot: their answers, ends and cancels, and those that are never sent."""

from __future__ import annotations

import asyncio
import gc
from collections import Counter
from functools import partial
from typing import Any

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.robot.goals.client import HISTORY
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.robot_file.model import GoalKind
from tests.support import clock
from tests.support.archo import SHELF, go
from tests.support.by_hand import ByHand
from tests.support.console import console
from tests.support.hesitant import Hesitant
from tests.support.night import corners
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot
from tests.support.ros import begin
from tests.support.stand_in import Made, Other, StandIn, beside

PACE = 1.2  # s: as 500 goals in ten minutes
Arriving = partial(Made, StandIn, goals="arrive")
Driving = partial(Made, StandIn, goals="drive")


# Its answer and its end.


async def test_a_cancel_that_the_server_rejects_is_said_and_the_goal_goes_on() -> None:
    driving = Driving(heeds=False)
    async with robot(driving, offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        await until(lambda: driving.node.running)
        outcome = await ended(it.cancel())
        assert not outcome.ok
        assert outcome.text.startswith("the robot rejected the cancel")
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.MOVING


async def test_a_goal_whose_sending_raises_is_refused_and_the_next_one_goes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shelves = Arriving()
    async with robot(shelves, offers="move_to_shelf") as it:
        with monkeypatch.context() as patched:

            def raises(*_: Any, **__: Any) -> None:
                raise RuntimeError("rcl: out of memory")

            patched.setattr(ActionClient, "send_goal_async", raises)
            outcome = await ended(go(it, 7))
        reason = "not sent: RuntimeError: rcl: out of memory"
        assert outcome == (Code.REFUSED, reason)
        await until(lambda: it.snapshot.goal is not None)
        goal: Any = it.snapshot.goal
        assert (goal.phase, goal.message) == (Phase.REFUSED, reason)
        assert it.snapshot.running == 0
        assert (await ended(go(it, 8))).text == "accepted"
        await until(lambda: shelves.node.shelves == [8])
        await until(lambda: [goal.phase for goal in it.snapshot.history][-1:] == [Phase.REFUSED])


async def test_a_refusal_in_the_log_counts_only_from_the_node_that_moves() -> None:
    class Liar(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("liar", **options)
            self.create_timer(0.01, lambda: self.get_logger().info("Goal refused: I say so"))

    class Refusing(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("refusing", **options)
            self.asked = 0
            self.action = ActionServer(
                self, MoveToShelf, "move_to_shelf", lambda _: None, goal_callback=self.refuse
            )

        def refuse(self, _: Any) -> Any:
            if not self.asked:
                self.get_logger().warning("Goal refused: the road is wet")
            self.asked += 1

    async with robot(Liar, Refusing, offers="move_to_shelf") as it:
        await until(lambda: any("I say so" in e.text for e in it.snapshot.events))
        outcome = await ended(go(it, 3))
        assert (outcome.ok, outcome.text) == (False, "the road is wet")
        assert (await ended(go(it, 4))).text == "refused, no reason given"


class Sluggish(ByHand):
    """Answers the first goal only at last, and knows nothing of it meanwhile; the next at once."""

    def __init__(self, **options: Any) -> None:
        super().__init__("sluggish", **options)
        self.at_last: Future[bool] = Future()
        self.answered = 0
        self.create_timer(0.2, self.tell)

    def tell(self) -> None:
        if len(self.goal_ids) > 1:
            self.feed(self.goal_ids[1], 5.0)

    async def accept(self, request: Any, response: Any) -> Any:
        await super().accept(request, response)
        if len(self.goal_ids) == 1:
            await self.at_last
        self.answered += 1
        return response

    async def result(self, request: Any, response: Any) -> Any:
        if bytes(request.goal_id.uuid) != self.goal_ids[0]:
            await self.never
        return response  # its status is UNKNOWN


async def test_an_old_goal_that_is_accepted_late_is_cancelled() -> None:
    made = Made(Sluggish)
    async with robot(made, offers="move_to_shelf") as it:
        assert not (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert (await ended(go(it, 7))).ok
        before: Any = it.snapshot.goal
        begin(made.node, lambda: made.node.at_last.set_result(True))
        await until(lambda: made.node.answered == 2)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.heard > before.heard)
        await until(lambda: made.node.cancelled == made.node.goal_ids[:1])  # else it is driven
        goal: Any = it.snapshot.goal
        assert (goal.target, goal.phase, goal.started) == ("7", Phase.MOVING, before.started)
        assert [goal.target for goal in it.snapshot.history] == ["3"]


# Several servers of one name: a stale launch, two robots.


async def test_a_goal_is_not_sent_to_an_action_with_two_servers() -> None:
    made = Driving("a"), Driving("b")
    async with robot(*made) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.duplicate_servers)
        outcome = await ended(go(it, 3))
        assert not outcome.ok
        assert outcome.text == (
            "move_to_shelf is served by /a and /b: each would drive; stop all but one"
        )
        assert it.snapshot.faults["move_to_shelf"] == outcome.text
        assert [drive.node.shelves for drive in made] == [[], []]


@pytest.mark.waits
async def test_a_server_that_does_not_know_the_goal_is_not_believed_beside_another() -> None:
    a = Driving("a")
    async with robot(a, offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        late = beside(a.node, StandIn("b", goals="drive", context=a.node.context))
        await until(lambda: "move_to_shelf" in it.snapshot.duplicate_servers)
        await while_passes(20.0)  # it sends no feedback
        assert it.snapshot.running == 1, it.snapshot.goal
        await ended(it.cancel())  # Either may answer first.
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.CANCELLED)
        begin(a.node, late.leave)


@pytest.mark.parametrize("is_cancelled", [False, True])
async def test_a_goal_of_a_restarted_server_does_not_run_for_ever(is_cancelled: bool) -> None:
    a, base = Driving("a"), Made(StandIn, "base", moving=True)
    async with robot(a, base, offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        leaving = begin(base.node, a.node.leave)
        again = beside(base.node, StandIn("a", goals="drive", context=base.node.context))
        end = clock.seconds() + 20.0
        if is_cancelled:
            await until(leaving.done)  # else the cancel may reach the one that knows the goal
            await until(lambda: it.snapshot.duplicate_servers == {})
            assert not (await ended(it.cancel())).ok
            if clock.current is not None:  # on real ROS 2 the answer itself may come late
                end = clock.seconds() + 0.5
        await until(lambda: clock.seconds() > end or it.snapshot.history)
        assert it.snapshot.history
        assert it.snapshot.history[0].message.startswith("the robot no longer knows this goal")
        begin(base.node, again.leave)


# Goals without end, of this console and of others.


def kinds_kept() -> Counter[str]:
    """How many objects there are of each kind of the console's robot, but for the event log's."""
    gc.collect()
    ours = [type(it).__name__ for it in gc.get_objects() if "archo_tui.robot" in str(type(it))]
    # of those a thousand are kept, some with a record
    return Counter(name for name in ours if name not in ("Event", "AuditRecord"))


@pytest.mark.parametrize("count", corners([24], [100]))
async def test_of_goals_without_end_only_the_last_are_kept(count: int) -> None:
    other, kept = Made(Other), list[Counter[str]]()
    async with robot(Arriving(), other) as it:
        await until(lambda: other.node.client.server_is_ready())
        for number in range(1, count + 1):
            due = clock.seconds() + (0.0 if clock.current is None else PACE)
            other.node.go()
            await until(lambda number=number: other.node.ended == number)  # type: ignore[misc]
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
    made = Made(Backward)
    async with robot(made, offers="move_to_shelf") as it:
        assert (await ended(go(it, 1))).ok
        await until(lambda: it.snapshot.history)
        published = made.node.published
        await until(lambda: made.node.published > published + 1)  # and one before it was taken in
        assert [(goal.mine, goal.phase) for goal in it.snapshot.history] == [(True, Phase.ARRIVED)]


# A goal that is cancelled before the robot has taken it is not driven, wherever it is then.


@pytest.fixture
def hesitant() -> Made[Hesitant]:
    return Made(Hesitant)


@pytest.mark.parametrize("late", [0.5, 3.0])
async def test_it_is_cancelled_as_soon_as_the_robot_takes_it_however_late(
    hesitant: Made[Hesitant], late: float
) -> None:
    async with robot(hesitant, offers="move_to_shelf") as it:
        going = asyncio.ensure_future(go(it, 3))
        await until(lambda: hesitant.node.seen)
        cancelling = asyncio.ensure_future(it.cancel())
        await while_passes(late)
        hesitant.node.answer()
        await until(lambda: going.done() and cancelling.done())
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.CANCELLED)
        if late < 2.0:
            assert cancelling.result().ok  # Where time is real, its end may come before the answer.
            assert going.result().ok  # how it ended is the goal's to say
        else:
            said = "the goal is not accepted yet: it is cancelled when it is"
            assert cancelling.result() == (Code.TIMEOUT, said)


async def test_one_that_the_robot_refuses_meanwhile_leaves_nothing_to_cancel(
    hesitant: Made[Hesitant],
) -> None:
    async with robot(hesitant, offers="move_to_shelf") as it:
        going = asyncio.ensure_future(go(it, 3))
        await until(lambda: hesitant.node.seen)
        cancelling = asyncio.ensure_future(it.cancel())
        await until(lambda: it.goals.ours is not None and it.goals.ours.is_cancelled)
        hesitant.node.answer(taken=False)
        await until(lambda: going.done() and cancelling.done())
        said = "the goal was not driven: refused, no reason given"
        assert cancelling.result() == (Code.DONE, said)


async def test_one_whose_server_is_still_looked_for_is_never_sent(hesitant: Made[Hesitant]) -> None:
    async with robot(hesitant, offers="move_to_shelf") as it:
        kind = GoalKind("send_goal", "Reach", "reach", SHELF.type)
        going = asyncio.ensure_future(it.send(kind, {"shelf_number": 3}))
        await until(lambda: it.goals._coming)
        assert await ended(it.cancel()) == (Code.ACCEPTED, NEVER_LEFT)
        assert await ended(going) == (Code.CANCELLED, NEVER_LEFT)


async def test_a_key_cancels_a_goal_that_is_not_taken_yet_and_questions_know_it(
    hesitant: Made[Hesitant],
) -> None:
    async with console(node_makers=[hesitant], wait=False) as op:
        await op.until(lambda: "move_to_shelf" in op.session.robot.snapshot.offered)
        await op.press("g", *"12 7", "enter")
        await op.until(lambda: hesitant.node.seen)
        await op.press("escape", "ctrl+z")
        await op.until("on its way to shelf 12; its nodes would pause")
        await op.press("escape", "ctrl+c")
        assert "No goal is running" not in op.text
        hesitant.node.answer()
        await op.until("held: 7 (cancelled)")
        assert op.app.view.snapshot.history[0].phase == Phase.CANCELLED
