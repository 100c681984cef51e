"""A question and its answer, which is for what was asked; a toggle that asks which way."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.screen.commands.base import asking_first
from archo_tui.verbs.verb import Question
from tests.support.console import Console, console
from tests.support.stand_in import Made
from tests.support.states import goal


async def test_an_answer_is_for_the_values_and_the_goal_that_were_asked_about() -> None:
    now, sent = [0.0], list[Any]()
    station = SimpleNamespace(clock=SimpleNamespace(monotonic=lambda: now[0]), running_goal=None)
    console: Any = SimpleNamespace(station=station)

    async def send(values: Any) -> Outcome:
        sent.append(values)
        return Outcome(Code.DONE, "")

    station.running_goal = goal(Phase.MOVING).running_goal

    def ask(_: Any) -> Question:
        return Question("", "Sure?", "No", "Yes", station.running_goal)

    ask_or_send = asking_first(console, ask, send)
    for now[0], values in ((0.0, {"x": 1}), (1.0, {"x": 5}), (1.1, {"x": 5})):
        assert (await ask_or_send(values)).text == "Sure? Then send it again."
    now[0], station.running_goal = 2.0, None  # It has ended since.
    assert not (await ask_or_send({"x": 5})).ok
    now[0] = 3.0
    assert (await ask_or_send({"x": 5})).ok
    assert sent == [{"x": 5}]


FILE = """
name: Lamp
battery: {topic: b, types: {std_msgs/msg/Float32: {percentage: data}}}
commands:
  - {id: light, title: Light, key: l, service: light, ask: ASK, toggle: {data: battery.charging}}
"""


class Lamp(Node):
    """`asked` holds what it was sent."""

    def __init__(self, **options: Any) -> None:
        super().__init__("lamp", **options)
        self.asked: list[bool] = []
        self.create_service(SetBool, "light", self.light)

    def light(self, request: Any, response: Any) -> Any:
        self.asked.append(request.data)
        response.success = True
        return response


@asynccontextmanager
async def lamp(
    folder: Path, ask: str = "never", reading: str = "battery.charging"
) -> AsyncIterator[tuple[Console, Lamp]]:
    file, made = folder / "lamp.yaml", Made(Lamp)
    file.write_text(FILE.replace("ASK", ask).replace("battery.charging", reading))
    async with console(robot=file, node_makers=[made], wait=False) as op:
        await op.until(lambda: "light" in op.app.view.snapshot.offered)
        yield op, made.node


async def test_it_is_asked_on_or_off_and_the_safe_answer_changes_nothing(here: Path) -> None:
    async with lamp(here) as (op, node):
        sent: list[bool] = []
        for keys, is_on in ((["enter"], None), (["right"], True), (["right", "right"], False)):
            await op.press("l")
            await op.until("The robot does not report battery.charging: Light or Light off?")
            assert node.asked == sent
            await op.press(*keys, *["enter"] * (is_on is not None))
            sent.extend([] if is_on is None else [is_on])
            await op.until(lambda: node.asked == sent)
            await op.until(lambda: op.app.screen is op.app.main)


async def test_a_toggle_of_no_reading_asks_which_way_and_then_what_the_command_asks(
    here: Path,
) -> None:
    async with lamp(here, "always", reading="ask") as (op, node):
        await op.press("l")
        await op.until("Light or Light off?")
        assert "does not report" not in op.text
        await op.press("right", "right", "enter")
        await op.until("Light off now?")
        assert node.asked == []
        await op.press("y")
        await op.until(lambda: node.asked == [False])
