"""What becomes of a running goal when the console has to go."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from archo_tui.base.clock import Clock
from archo_tui.base.system import HANG_UP
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.shutdown import CANCEL, LEAVE, RESTART, WAIT, Shutdown, let_go
from tests.support import clock
from tests.support.archo import go
from tests.support.console import console_with
from tests.support.quiet import ended, until
from tests.support.robot import robot as robot_of
from tests.support.stand_in import Made, StandIn
from tests.support.states import MOVING, NORMAL, STATES


class Robot:
    """Cancels at once, or never answers."""

    def __init__(self, snapshot: Snapshot, *, answers: bool = True) -> None:
        self.snapshot, self._answers = snapshot, answers
        self.said: list[str] = []
        self.cancelled = False

    def note(self, level: str, source: str, text: str) -> None:
        self.said.append(f"{level} {text}")

    async def stop_sending_goals(self) -> None:
        pass

    async def cancel(self) -> Outcome:
        self.cancelled = True
        if not self._answers:
            await asyncio.Event().wait()
        self.snapshot = STATES["goal cancelled"]
        return Outcome(Code.DONE, "cancelling")


RUNNING = STATES["motor moving"]


@pytest.mark.parametrize(
    ("snapshot", "policy", "said"),
    [
        (RUNNING, CANCEL, "cancelling the goal to shelf 12"),
        (RUNNING, LEAVE, "the goal to shelf 12 is left running"),
        (RUNNING._replace(goal=MOVING._replace(mine=False)), CANCEL, ""),
        (NORMAL, CANCEL, ""),
    ],
)
async def test_the_consoles_own_goal_is_cancelled_or_left_as_was_chosen(
    snapshot: Snapshot, policy: str, said: str
) -> None:
    it: Any = Robot(snapshot)
    await let_go(it, clock.current or Clock(), policy, "ended by SIGHUP")
    assert it.cancelled == said.startswith("cancelling")
    assert it.said == ([f"WARN ended by SIGHUP: {said}"] if said else [])


async def test_a_robot_that_does_not_answer_is_not_waited_for_long() -> None:
    it: Any = Robot(RUNNING, answers=False)
    before = clock.seconds()
    await ended(let_go(it, clock.current or Clock(), CANCEL, "ended"))
    assert it.said[-1] == "ERROR no answer in 1 s: the goal may be running"
    assert clock.seconds() == pytest.approx(before + WAIT, abs=0.5)


async def test_a_second_signal_does_not_begin_again() -> None:
    it: Any = Robot(RUNNING)
    codes = list[int]()
    shutdown_ = Shutdown(it, Clock(), CANCEL, codes.append)
    shutdown_.begin(143)
    shutdown_.begin(129)
    while not codes:
        await asyncio.sleep(0)
    assert codes == [143]
    assert len(it.said) == 1


async def test_a_terminal_that_is_lost_as_a_restart_begins_ends_the_console() -> None:
    ends: list[int] = []
    ending = Shutdown(Robot(NORMAL), Clock(), CANCEL, ends.append)  # type: ignore[arg-type]
    ending.begin(RESTART)
    ending.begin(HANG_UP)
    ending.begin(RESTART)
    await until(lambda: ends)
    assert ends == [HANG_UP]


def late(**options: Any) -> Made[StandIn]:
    """Make a robot that answers to a goal after a while, and drives until it is cancelled."""
    return Made(StandIn, "late", goals="drive", decides=0.3, **options)


@pytest.mark.parametrize(
    ("accepts", "phase", "cancelled"),
    [(True, Phase.CANCELLED, 1), (False, Phase.REFUSED, 0)],
)
async def test_a_goal_that_is_not_accepted_yet_is_waited_for_and_cancelled(
    accepts: bool, phase: Phase, cancelled: int
) -> None:
    async with robot_of(made := late(), offers="move_to_shelf") as it:
        made.node.accepts = accepts
        going = asyncio.ensure_future(go(it, 12))
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.SENT)
        await ended(let_go(it, clock.current or Clock(), CANCEL, "ended by SIGTERM"))
        assert it.snapshot.goal is not None
        assert (it.snapshot.goal.phase, len(made.node.cancels)) == (phase, cancelled)
        await ended(going)


async def test_a_goal_that_has_not_left_yet_when_the_console_ends_never_does() -> None:
    async with robot_of(made := late(), offers="move_to_shelf") as it:
        going = asyncio.ensure_future(go(it, 12))
        await ended(let_go(it, clock.current or Clock(), CANCEL, "ended by SIGTERM"))
        await ended(going)
        assert len(made.node.asked) == len(made.node.cancels)
        assert await ended(go(it, 7)) == (Code.CANCELLED, "not sent: the console ends")
        assert 7 not in made.node.asked


@pytest.mark.parametrize("keys", [[], ["q", "tab", "enter"]])
async def test_a_goal_that_arrives_as_the_console_ends_is_the_last_that_is_sent(
    keys: list[str],
) -> None:
    made = late(ends="succeed")
    async with console_with(made, "move_to_shelf") as (op, _):
        await op.press("g", *"12 7", "enter")
        await op.until("MOVING to 12")
        if keys:
            await op.press(*keys)
        else:
            op.app._ending.begin(143)
        await op.until(lambda: not op.app.is_running)
        assert made.node.asked == [12]
        goal = op.session.robot.snapshot.goal
        assert goal is not None
        assert (goal.target, goal.phase) == ("12", Phase.ARRIVED)


async def test_quitting_cancels_a_goal_that_is_accepted_after_the_question() -> None:
    async with console_with(late(), "move_to_shelf") as (op, node):
        await op.press("g", *"12", "enter", "q", "tab", "enter")
        await op.until(lambda: not op.app.is_running)
        assert (node.asked, len(node.cancels)) == ([12], 1)
