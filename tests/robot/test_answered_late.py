"""A goal whose server takes long to decide is not over before the server has decided."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from archo_tui.robot.goals.machine import NEVER_TAKEN
from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from tests.support.archo import go
from tests.support.clock import seconds
from tests.support.hesitant import Hesitant
from tests.support.quiet import ended, until
from tests.support.robot import making, robot


def phase(it: Robot) -> Phase | None:
    return None if it.snapshot.goal is None else it.snapshot.goal.phase


@asynccontextmanager
async def undecided() -> AsyncIterator[tuple[Robot, Hesitant]]:
    """A goal has been sent, and its server has not answered in time."""
    made: list[Hesitant] = []
    async with robot(making(made, Hesitant), offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).code == Code.TIMEOUT
        yield it, made[0]


async def test_it_is_unknown_until_then_though_the_robot_does_not_know_it_yet() -> None:
    async with undecided() as (it, server):
        began = seconds()
        await until(lambda: seconds() >= began + 5.0)  # it has been asked for twice
        assert phase(it) == Phase.UNKNOWN
        server.answer()
        await until(lambda: phase(it) == Phase.MOVING)


@pytest.mark.waits
async def test_one_that_is_never_taken_is_over_in_the_end_and_never_driven() -> None:
    async with undecided() as (it, server):
        began = seconds()
        await until(lambda: phase(it) == Phase.ABORTED)
        assert seconds() - began > NEVER_TAKEN - 3.0
        said = "the robot does not know this goal: it did not take it in 20 s"
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message == said
        server.answer()
        await until(lambda: server.cancelled.done())
