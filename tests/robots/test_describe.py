"""Describe this robot: the file that is written from the graph operates the robot."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("depot_interfaces")

from std_msgs.msg import Float32

from archo_tui.robot_file.load import load
from archo_tui.verbs import topics
from tests.robots.cart import Cart
from tests.robots.test_rover import rover
from tests.support.console import console_with

CART = Path(__file__).with_name("cart.yaml")


@pytest.fixture(autouse=True)
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(topics, "LISTENING", 0.3)


@pytest.mark.waits
async def test_the_palette_writes_a_file_that_shows_the_robots_data(here: Path) -> None:
    async with console_with(Cart, "blink", robot=CART) as (op, _):
        await op.press("ctrl+p")
        await op.type("Describe this robot")
        await op.press("enter")
        await op.until("listens for")
        await op.press("enter")
        await op.until("Saved to robot.yaml.")
    path = here / "robot.yaml"
    made = load(path)
    assert made.battery is not None
    assert made.battery.topic == "battery_level"
    assert [goal.action for goal in made.goals] == ["move_to_shelf"]
    assert [command.service for command in made.commands] == ["blink"]
    assert made.stop is None
    assert "# stop: {service: emergency_stop}" in path.read_text()
    async with console_with(Cart, "blink", robot=path) as (op, _):
        await op.until("Go to shelf")


async def test_goals_of_types_that_it_never_saw_get_their_forms(tmp_path: Path) -> None:
    async with rover() as (op, _):
        await op.until(lambda: "/dock" in op.app.view.snapshot.actions)
        path = tmp_path / "rover.yaml"
        text = asyncio.create_task(topics.robot_file_text(op.session.station))
        await op.until(text.done)
        path.write_text(text.result())
    made = load(path)
    assert {goal.action for goal in made.goals} >= {"go_to", "dock", "undock"}


async def test_a_ros_thread_that_answers_too_late_leaves_no_subscription(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with console_with(Cart, "blink", robot=CART) as (op, _):
        robot = op.session.robot

        async def run_too_late(work: Callable[[], Any], _deadline: float) -> None:
            robot.thread.submit(work)
            raise TimeoutError

        with monkeypatch.context() as patch:
            patch.setattr(robot.thread, "run", run_too_late)
            with pytest.raises(TimeoutError):
                async with robot.inspect("/sampled", Float32):
                    pass
        done = asyncio.create_task(robot.wait_for_events())
        await op.until(done.done)
        assert "/sampled" not in [s.topic_name for s in robot.node.subscriptions]
