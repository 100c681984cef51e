"""Processes that are killed in the middle of goals: the robot's, and the console's."""

from __future__ import annotations

import pytest

from tests.ros2.conftest import Processes
from tests.support.archo import go
from tests.support.console import LONG, console
from tests.support.quiet import ended, until
from tests.support.robot import robot

MOTOR = "archo_bringup.motor_controller"
SLOW = ("-p", "feedback_period:=0.1", "-p", "time_scale:=2.0")  # a way of 11 s


@pytest.mark.waits
async def test_a_robot_killed_three_times_loses_its_goal_and_holds_the_queue_each_time(
    processes: Processes,
) -> None:
    motor = processes.start(MOTOR, *LONG)
    async with console(attach=True, domain_id=processes.domain, wait=False) as op:
        for number in range(3):
            await op.until("● IDLE")
            await op.until(lambda: "move_to_shelf" in op.app.view.snapshot.offered)
            # one that was killed stays on the graph for some 20 s, as a second server
            await op.until(lambda: not op.app.view.snapshot.duplicate_servers, deadline=60)
            await op.press("g", *"12 7", "enter")
            await op.until("m left of")
            assert "then 7" in op.text
            processes.kill(motor)
            await op.until("✗ LOST         nothing heard for")
            motor = processes.start(MOTOR, *LONG)
            await op.until("✗ ABORTED      the robot no longer knows this goal", deadline=60)
            await op.until("held: 7 (contact lost)")
            assert len(op.app.view.snapshot.history) == number + 1
            await op.press("escape", "k")
            await op.until(lambda: not op.app.view.waiting)


async def test_a_killed_consoles_goal_goes_on_and_nobody_sends_its_queue(
    processes: Processes,
) -> None:
    processes.start(MOTOR, *SLOW)
    async with robot(attach=True, nodes=1, domain_id=processes.domain) as watching:
        killed = processes.start_console("--attach", "--plain")
        assert killed.stdin is not None
        killed.stdin.write(b"go 12 7 3\n")
        killed.stdin.flush()
        await until(lambda: watching.snapshot.goal and watching.snapshot.goal.remaining)
        processes.kill(killed)
        async with robot(attach=True, nodes=1, domain_id=processes.domain) as it:
            await until(lambda: it.snapshot.goal and it.snapshot.goal.remaining)
            assert it.snapshot.goal is not None
            assert not it.snapshot.goal.mine
            await until(lambda: it.snapshot.history)
            assert it.snapshot.history[0].message.startswith("Arrived at shelf 12")
            # the server answers in the order of what it is sent: whatever the queue had is before
            assert (await ended(go(it, 5))).ok
            assert (await ended(it.cancel())).ok
            for one in (watching, it):
                await until(lambda one=one: len(one.snapshot.history) == 2)  # type: ignore[misc]
            assert [goal.word for goal in it.snapshot.history] == ["CANCELLED", "ARRIVED"]
