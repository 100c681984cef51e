"""Goals at a robot: their answers, ends and cancels, and those that are never sent."""

from __future__ import annotations

import asyncio
import gc
from collections import Counter
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from archo_tui.robot.clients import Requester, on_behalf_of
from archo_tui.robot.goals.client import HISTORY
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.robot_file.model import GoalKind
from tests.support import clock
from tests.support.archo import SHELF, go
from tests.support.by_hand import ByHand
from tests.support.clock import seconds
from tests.support.console import LONG, console
from tests.support.hesitant import Hesitant
from tests.support.night import corners
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot, texts
from tests.support.ros import begin
from tests.support.stand_in import Made, Other, StandIn, beside
from tests.support.states import STATES
from tests.support.stub import StubRobot, stub_station

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


async def test_one_that_is_cancelled_in_the_same_turn_never_leaves_the_desk(
    hesitant: Made[Hesitant],
) -> None:
    async with operated(hesitant) as person:
        station = person._plain._station
        await until(lambda: "move_to_shelf" in station.robot.snapshot.offered)
        goals = [QueuedGoal(SHELF, {"shelf_number": number}) for number in (12, 7)]
        answer = station.goals.drive(goals)
        goal = station.running_goal
        assert goal is not None
        assert (goal.name, goal.phase) == ("shelf 12", Phase.SENT)
        assert await station.goals.cancel() == (Code.ACCEPTED, NEVER_LEFT)
        assert await ended(answer) == (Code.CANCELLED, NEVER_LEFT)
        assert station.queue.hold_reason == "cancelled"
        assert station.running_goal is None
        assert hesitant.node.seen == 0


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


async def test_a_goal_that_a_screen_did_not_send_is_forgotten_by_the_next() -> None:
    station = stub_station(StubRobot(STATES["normal"]))
    face: Any = SimpleNamespace(carry_out=lambda _: None)  # It ends before it begins anything.
    station.attach(face)
    station.goals.drive([QueuedGoal(SHELF, {"shelf_number": 12})])
    assert station.running_goal is not None
    station.detach()
    station.attach(face)
    assert station.running_goal is None


# Nothing is heard of it any more: its server falls silent, or its node has gone.

LOST = "the robot may still be moving"
# The wheels report how they turn and know no goal; a planner takes goals, and is well if it feeds.
Base = partial(Made, StandIn, "base", moving=True)
Planner = partial(Made, StandIn, "planner", goals="drive", feeds=True)


async def test_its_server_falls_silent_and_the_wheels_vouch_for_nothing() -> None:
    planner = Planner()
    async with robot(Base(), planner, offers="move_to_shelf") as it:

        def phase() -> Phase | None:
            return it.snapshot.goal.phase if it.snapshot.goal else None

        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.remaining == 9.0)
        await while_passes(5)
        assert phase() == Phase.MOVING
        planner.node.feeds, began = False, seconds()
        await until(lambda: phase() == Phase.LOST)
        assert 2.5 < seconds() - began < 4.5
        assert it.snapshot.motion.received is not None
        assert seconds() - it.snapshot.motion.received < 1.5
        refused = await ended(go(it, 5))
        assert refused.code is Code.REFUSED
        assert "nothing is heard of the goal" in refused.text
        await while_passes(5)
        assert phase() == Phase.LOST  # the goal is kept
        planner.node.feeds = True
        await until(lambda: phase() == Phase.MOVING)


async def test_a_goal_is_not_lost_while_the_console_was_suspended() -> None:
    if clock.current is None:
        pytest.skip("real time passes for all")
    async with operated(Base(), Planner()) as person:
        person.type("go 3\n")
        await person.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        clock.current.suspend(6.0)
        # The first to go on, before the feedback is read.
        person._plain._station.robot.check_goals()
        await while_passes(5)
        person.type("status\n")
        await person.until("goal MOVING to 3, 9.0 m left")
        assert "LOST" not in person.said


@pytest.mark.waits
async def test_an_action_that_sends_no_feedback_is_judged_by_its_server_alone() -> None:
    async with operated(Base(), Planner(feeds=False)) as person:
        person.type("go 3\n")
        await person.until("accepted")
        await while_passes(20)
        person.type("status\n")
        await person.until("goal MOVING")
        await person.until("served, no feedback")


async def test_who_waits_for_its_end_is_told_that_it_is_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.robot.state.goal.GIVEN_UP", 5.0)  # s
    planner = Planner()
    async with operated(Base(), planner) as person:
        station, shell = person._plain._station, Requester("SHELL", "pid 1")
        await until(lambda: "move_to_shelf" in station.robot.snapshot.offered)
        with on_behalf_of(shell):
            assert (await ended(station.goals.drive([QueuedGoal(SHELF, {"shelf_number": 3})]))).ok
        await person.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        planner.node.feeds, began = False, seconds()
        await person.until("NO WORD FROM GO TO SHELF for")
        (end,) = shell.ends
        outcome = await ended(end)
        assert outcome.code is Code.TIMEOUT
        assert outcome.text.startswith("goal lost: no word from it for ")
        assert 8 <= seconds() - began < 12
        assert station.running_goal is not None
        assert "no word of the goal" in {alarm.name for alarm in station.view.alarms}


async def test_input_that_is_over_waits_for_it_no_longer_and_ends_with_1(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.robot.state.goal.GIVEN_UP", 5.0)  # s
    planner = Planner()
    async with operated(Base(), planner) as person:
        person.type("go 3\n")
        await person.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        planner.node.feeds = False
        assert await person.end() == 1
        assert "goal lost: no word from it for " in person.said


# Its node has gone: one rule, wherever the goal came from.


class Server(ByHand):
    """Takes every goal, and says nothing of it until it is told to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("server", **options)

    async def cancel(self, request: Any, response: Any) -> Any:
        await super().cancel(request, response)
        await self.never
        return response

    def feeds(self, goal_id: bytes) -> None:
        """Tell how far it is from now on, and no status."""
        self.create_timer(0.2, lambda: self.feed(goal_id, 9.0))

    def drives(self, goal_id: bytes) -> None:
        """Tell that it does."""
        status = GoalStatus(status=GoalStatus.STATUS_EXECUTING)
        status.goal_info.goal_id = UUID(uuid=list(goal_id))
        self.status.publish(GoalStatusArray(status_list=[status]))


@pytest.mark.parametrize("tells", [Server.drives, Server.feeds], ids=["status", "feedback"])
async def test_elsewhere_it_is_lost_soon_and_ours_again_when_its_node_is_seen_again(
    tells: Any,
) -> None:
    host = Made(Node, "somebody")
    async with robot(host) as it:
        await until(lambda: host.node.executor is not None)
        executor: Any = host.node.executor
        server = beside(host.node, Server(context=host.node.context))
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok
        (goal_id,) = server.goal_ids

        def leave(node: Node) -> None:
            executor.remove_node(node)
            node.destroy_node()

        executor.create_task(leave, server)
        began = seconds()
        await until(lambda: it.snapshot.goal and not it.snapshot.goal.is_running)
        assert seconds() - began < 3.0
        goal: Any = it.snapshot.goal
        assert (goal.phase, goal.word, goal.message) == (Phase.GONE, "LOST", LOST)
        assert goal.outcome_at(seconds()) == Outcome(Code.TIMEOUT, f"goal lost: {LOST}")
        it.stops.register()
        back = beside(host.node, Server(context=host.node.context))
        executor.create_task(tells, back, goal_id)
        await until(lambda: it.snapshot.running_goal)
        goal = it.snapshot.running_goal
        assert (goal.name, goal.mine) == ("shelf 3", True)
        await until(lambda: back.cancelled)  # A STOP since then ends it, confirmed or not.
        again = "shelf 3 was not lost: its node is heard again"
        await until(lambda: again in texts(it))
        said = [event.text for event in it.snapshot.events if event.level == "GOAL"]
        assert said == [f"shelf 3 lost: {LOST}", again]
        executor.create_task(leave, back)
        await until(lambda: it.snapshot.running_goal is None)


async def test_of_a_halted_node_it_is_lost_at_once_and_the_rest_is_held() -> None:
    async with operated(ros_args=LONG) as person:
        person.type("go 12 7\n")
        await person.until("m left of")
        began = seconds()
        person.type("halt motor_controller --yes\n")
        await person.until(f"goal LOST, shelf 12, {LOST}")
        assert seconds() - began < 0.5
        assert await person.end() == 1
        assert "queue held: 7 (lost)" in person.said
        assert "not driven: 7 (lost)" in person.said


async def test_a_copy_that_is_halted_takes_no_goal_of_the_other_one_along() -> None:
    async with operated(ros_args=LONG) as person:
        person.type("go 12\n")
        await person.until("m left of")
        host = person._plain._station.host
        assert (await asyncio.to_thread(host.copy_node, "/motor_controller")).ok
        person.type("halt motor_controller_2 --yes\nnodes\n")
        await person.until("motor_controller_2 stopped")
        goal = person._plain._robot.snapshot.goal
        assert goal is not None
        assert goal.is_running
