"""What becomes of a running goal when the console has to go."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from archo_tui.clock import Clock
from archo_tui.robot.state import Outcome, Snapshot
from archo_tui.shutdown import CANCEL, LEAVE, WAIT, Shutdown, let_go
from tests.console.states import MOVING, NORMAL, STATES
from tests.support import clock
from tests.support.quiet import ended


class Robot:
    """Cancels at once, or never answers."""

    def __init__(self, snapshot: Snapshot, *, answers: bool = True) -> None:
        self.snapshot, self._answers = snapshot, answers
        self.said: list[str] = []
        self.cancelled = False

    def note(self, level: str, source: str, text: str) -> None:
        self.said.append(f"{level} {text}")

    async def cancel(self) -> Outcome:
        self.cancelled = True
        if not self._answers:
            await asyncio.Event().wait()
        self.snapshot = STATES["goal cancelled"]
        return Outcome(True, "cancelling")


def robot(**options: Any) -> Any:
    return Robot(STATES["motor moving"], **options)


async def test_a_running_goal_is_cancelled_and_its_end_waited_for() -> None:
    it = robot()
    await let_go(it, clock.current or Clock(), CANCEL, "ended by SIGHUP")
    assert it.cancelled
    assert it.said == ["WARN ended by SIGHUP: cancelling the goal to shelf 12"]


async def test_the_goal_of_another_client_is_neither_cancelled_nor_spoken_of() -> None:
    it: Any = Robot(STATES["motor moving"]._replace(goal=MOVING._replace(mine=False)))
    await let_go(it, clock.current or Clock(), CANCEL, "ended by SIGHUP")
    assert not it.cancelled
    assert it.said == []


async def test_a_robot_that_does_not_answer_is_not_waited_for_long() -> None:
    it = robot(answers=False)
    before = clock.seconds()
    await ended(let_go(it, clock.current or Clock(), CANCEL, "ended"))
    assert it.said[-1] == "ERROR no answer in 1 s: the goal may be running"
    assert clock.seconds() == pytest.approx(before + WAIT, abs=0.5)


async def test_a_goal_is_left_running_when_that_was_chosen() -> None:
    it = robot()
    await let_go(it, clock.current or Clock(), LEAVE, "ended by SIGHUP")
    assert not it.cancelled
    assert it.said == ["WARN ended by SIGHUP: the goal to shelf 12 is left running"]


async def test_without_a_goal_nothing_is_said() -> None:
    it: Any = Robot(NORMAL)
    await let_go(it, clock.current or Clock(), CANCEL, "ended")
    assert it.said == []


async def test_a_second_signal_does_not_begin_again() -> None:
    it, codes = robot(), list[int]()
    shutdown_ = Shutdown(it, Clock(), CANCEL, codes.append)
    shutdown_.begin(143)
    shutdown_.begin(129)
    while not codes:
        await asyncio.sleep(0)
    assert codes == [143]
    assert len(it.said) == 1
