"""A goal that is cancelled before the robot has taken it is not driven, wherever it is then."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from functools import partial
from typing import Any, cast

import pytest

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.robot_file.model import GoalKind
from archo_tui.station.goal_driver import Frontend
from tests.support.archo import SHELF, go
from tests.support.clock import seconds
from tests.support.console import console
from tests.support.hesitant import Hesitant
from tests.support.plain import operated
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.shells import served, typed
from tests.support.shells import until as really
from tests.support.states import STATES
from tests.support.stub import StubRobot, stub_station


@pytest.fixture
def made() -> list[Hesitant]:
    return []


@pytest.fixture
def hesitant(made: list[Hesitant]) -> Any:
    return making(made, Hesitant)


def offered(it: Any) -> bool:
    return "move_to_shelf" in it.snapshot.offered


@pytest.mark.parametrize("late", [0.5, 1.5, 3.0])
async def test_it_is_cancelled_as_soon_as_the_robot_takes_it_however_late(
    hesitant: Any, made: list[Hesitant], late: float
) -> None:
    async with robot(hesitant) as it:
        await until(lambda: offered(it))
        going = asyncio.ensure_future(go(it, 3))
        await until(lambda: made[0].seen)
        began = seconds()
        cancelling = asyncio.ensure_future(it.cancel())
        await until(lambda: seconds() >= began + late)
        made[0].answer()
        await until(lambda: going.done() and cancelling.done())
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.CANCELLED)
        if late < 2.0:
            assert cancelling.result() == (Code.ACCEPTED, "accepted")
            assert going.result().ok  # how it ended is the goal's to say
        else:
            said = "the goal is not accepted yet: it is cancelled when it is"
            assert cancelling.result() == (Code.TIMEOUT, said)


async def test_one_that_the_robot_refuses_meanwhile_leaves_nothing_to_cancel(
    hesitant: Any, made: list[Hesitant]
) -> None:
    async with robot(hesitant) as it:
        await until(lambda: offered(it))
        going = asyncio.ensure_future(go(it, 3))
        await until(lambda: made[0].seen)
        cancelling = asyncio.ensure_future(it.cancel())
        await until(lambda: it.goals.ours is not None and it.goals.ours.is_cancelled)
        made[0].answer(taken=False)
        await until(lambda: going.done() and cancelling.done())
        said = "the goal was not driven: refused, no reason given"
        assert cancelling.result() == (Code.DONE, said)


async def test_one_whose_server_is_still_looked_for_is_never_sent(
    hesitant: Any, made: list[Hesitant]
) -> None:
    async with robot(hesitant) as it:
        await until(lambda: offered(it))
        kind = GoalKind("send_goal", "Reach", "reach", SHELF.type)
        going = asyncio.ensure_future(it.send(kind, {"shelf_number": 3}))
        await until(lambda: it.goals._coming)
        assert await ended(it.cancel()) == (Code.ACCEPTED, NEVER_LEFT)
        assert await ended(going) == (Code.CANCELLED, NEVER_LEFT)


async def test_one_that_is_cancelled_in_the_same_turn_never_leaves_the_desk(
    hesitant: Any, made: list[Hesitant]
) -> None:
    async with operated(hesitant) as person:
        station = person._plain._station
        await until(lambda: offered(station.robot))
        goals = [QueuedGoal(SHELF, {"shelf_number": number}) for number in (12, 7)]
        answer = station.goals.drive(goals)
        goal = station.running_goal
        assert goal is not None
        assert (goal.name, goal.phase) == ("shelf 12", Phase.SENT)
        assert await station.goals.cancel() == (Code.ACCEPTED, NEVER_LEFT)
        assert await ended(answer) == (Code.CANCELLED, NEVER_LEFT)
        assert station.queue.hold_reason == "cancelled"
        assert station.running_goal is None
        assert made[0].seen == 0


async def test_a_key_cancels_a_goal_that_is_not_taken_yet_and_questions_know_it(
    hesitant: Any, made: list[Hesitant]
) -> None:
    async with console(node_makers=[hesitant], wait=False) as op:
        await op.until(lambda: offered(op.session.robot))
        await op.press("g", *"12 7", "enter")
        await op.until(lambda: made[0].seen)
        await op.press("escape", "ctrl+z")
        await op.until("on its way to shelf 12; its nodes would pause")
        await op.press("escape", "ctrl+c")
        assert "No goal is running" not in op.text
        made[0].answer()
        await op.until("held: 7 (cancelled)")
        assert op.app.view.snapshot.history[0].phase == Phase.CANCELLED


@pytest.mark.real_time
async def test_a_shells_cancel_ends_when_that_goals_cancel_is_answered(
    hesitant: Any, made: list[Hesitant]
) -> None:
    async with served(hesitant) as person:
        await really(lambda: offered(person._plain._robot))
        going = asyncio.ensure_future(typed("go", "12", "--wait"))
        await really(lambda: made and made[0].seen)
        cancelling = asyncio.ensure_future(typed("cancel"))
        goals = person._plain._robot.goals
        await really(lambda: goals.ours is not None and goals.ours.is_cancelled)
        assert not cancelling.done()
        made[0].answer()
        assert (await cancelling).code == 0
        assert (await going).code == 5


async def test_a_goal_that_a_screen_did_not_send_is_forgotten_by_the_next() -> None:
    class Ends:
        """A face that ends before it begins what it is given."""

        def carry_out(self, work: partial[Coroutine[Any, Any, None]]) -> None:
            """Begin nothing."""

    station = stub_station(StubRobot(STATES["normal"]))
    face = cast("Frontend", Ends())
    station.attach(face)
    station.goals.drive([QueuedGoal(SHELF, {"shelf_number": 12})])
    assert station.running_goal is not None
    station.detach()
    station.attach(face)
    assert station.running_goal is None
