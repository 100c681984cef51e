"""The console attached to nodes that run elsewhere, and processes that are killed amid goals."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys

from tests.ros2.conftest import Processes
from tests.support.archo import go
from tests.support.console import LONG, console
from tests.support.quiet import ended, until
from tests.support.robot import robot

MOTOR = "archo_bringup.motor_controller"
FAST = ("-p", "feedback_period:=0.05", "-p", "time_scale:=75.0")
SLOW = ("-p", "feedback_period:=0.1", "-p", "time_scale:=2.0")  # a way of 11 s
TEXTBOOK = "tests.contract.textbook"


async def test_what_nobody_offers_is_said_and_lights_up_when_it_comes(
    processes: Processes,
) -> None:
    async with console(attach=True, domain_id=processes.domain, wait=False) as op:
        await op.until("move_to_shelf is not offered by any node")
        await op.press("r")
        await op.until("reset_encoder is not offered")
        assert op.app.query_one("#stop").has_class("-blocked")
        processes.start(MOTOR, *FAST)
        await op.until("● IDLE")
        await op.until(lambda: not op.app.query_one("#stop").has_class("-blocked"))
        await op.until("No goal yet.")


async def test_a_killed_robot_is_lost_and_holds_the_queue_until_a_new_one_drives(
    processes: Processes,
) -> None:
    motor = processes.start(MOTOR, *LONG)
    async with console(attach=True, domain_id=processes.domain, wait=False) as op:

        def value(name: str) -> object:
            parameter = op.app.view.snapshot.parameter(name)
            return parameter and parameter.value

        await op.until("● IDLE")
        assert "ROS 2" in op.text
        assert f"domain {processes.domain}" in op.text
        await op.until(lambda: "move_to_shelf" in op.app.view.snapshot.offered)
        await op.press("g", *"12 7", "enter")
        await op.until("m left of")
        assert "then 7" in op.text
        # of one that was heard for a moment only, silence is not judged for 90 s
        await op.until(lambda: op.app.view.snapshot.motion.period is not None)
        processes.kill(motor)
        await op.until("✗ LOST         nothing heard for")
        goal = op.app.view.snapshot.goal
        assert goal is not None
        assert goal.heard is not None
        assert op.app.view.now - goal.heard < 8.0  # 3 s of silence, and a busy machine
        await op.until("CONTACT LOST for")
        await op.until("held: 7 (contact lost)")
        await op.press("escape", "k")
        await op.until(lambda: not op.app.view.waiting)
        await op.press("ctrl+x")  # ends, too
        # it is on the graph for 20 s: on a busy machine these may be over
        await op.until(lambda: "no answer in 2 s" in op.text or "is not offered" in op.text)
        processes.start(MOTOR, *FAST)
        await op.until("✗ ABORTED      the robot no longer knows this goal", deadline=60)
        await op.until("✗ STOPPED")  # the STOP was sent again until a robot had it
        await op.until(lambda: not op.app.view.snapshot.duplicate_servers, deadline=60)
        await op.press("escape", "R", "y")
        await op.until("● IDLE")
        await op.press("g", "7", "enter")
        await op.until("Arrived at shelf 7", deadline=30)
        await op.until(lambda: value("feedback_period") == 0.05)  # the new one's parameters, too
        await op.until("● IDLE")  # and nothing more of that STOP


async def test_the_textbooks_own_nodes_are_operated(processes: Processes) -> None:
    for listing in ("battery_publisher", "reset_service", "move_action_server"):
        processes.start(f"{TEXTBOOK}.{listing}")
    async with console(attach=True, domain_id=processes.domain, wait=False) as op:
        wanted = {"battery_level", "reset_encoder", "move_to_shelf"}
        await op.until(lambda: wanted <= op.app.view.snapshot.offered)
        await op.until("charging: not reported")
        assert "-- V" in op.text
        await op.press("r")
        await op.until("reset encoder: Encoder reset to zero")
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.press("ctrl+c")
        await op.until("the robot rejected the cancel")
        await op.until("✓ ARRIVED      Arrived at shelf 12")
        await op.press("ctrl+x")
        await op.until("emergency_stop is not offered by any node")


async def test_without_archo_interfaces_another_robot_is_still_operated(
    processes: Processes,
) -> None:
    processes.start(MOTOR, *FAST)
    code = (
        "import sys; sys.modules['archo_interfaces'] = None\n"
        "from archo_tui.cli import main\n"
        "sys.exit(main(['--engine', 'ros2', '--attach', '--plain']))"
    )
    done = await asyncio.to_thread(
        subprocess.run,
        [sys.executable, "-c", code],
        input="release\nparams\nstatus\n",
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        env=os.environ | {"ROS_DOMAIN_ID": str(processes.domain)},
    )
    assert "Traceback" not in done.stderr, done
    assert "motor_controller max_speed is 0.8" in done.stdout, done
    said = "motor_status is archo_interfaces/msg/MotorStatus, which is not installed here"
    assert said in done.stdout


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
