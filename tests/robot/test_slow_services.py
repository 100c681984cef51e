"""A service that takes its time: its answer is waited for, or told when it comes."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

from archo_tui.robot.outcome import Code, answer_of
from tests.support.console import console
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot
from tests.support.ros import begin
from tests.support.stand_in import Made

KIND = "std_srvs/srv/Trigger"
FILE = """
name: Mapper
commands:
  - {id: save_map, title: Save map, key: m, service: save_map}
"""


class Mapper(Node):
    """Saves its map when it is woken, and stops at once."""

    def __init__(self, **options: Any) -> None:
        super().__init__("mapper", **options)
        self.asked, self.stopped = 0, False
        self.awake: Future[bool] = Future()
        group = ReentrantCallbackGroup()
        self.create_service(Trigger, "save_map", self.save, callback_group=group)
        self.create_service(SetBool, "e_stop", self.stop, callback_group=group)
        self.create_timer(0.1, lambda: None)  # rclpy looks at what waits when it is awake

    async def save(self, _: Any, response: Any) -> Any:
        self.asked += 1
        await self.awake
        response.success, response.message = True, "map.pgm"
        return response

    def stop(self, request: Any, response: Any) -> Any:
        self.stopped = response.success = request.data
        return response

    def wake(self) -> None:
        begin(self, lambda: self.awake.set_result(True))


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "mapper.yaml"
    made.write_text(FILE + "stop: {service: e_stop, request: {data: true}}\n")
    return made


async def test_an_answer_after_five_seconds_is_the_outcome_and_a_stop_waits_for_none(
    file: Path,
) -> None:
    mapper = Made(Mapper)
    async with robot(mapper, robot=file, offers="e_stop save_map") as it:
        call = asyncio.ensure_future(it.call("/save_map", KIND, {}))
        await until(lambda: mapper.node.asked == 1)
        it.stops.register()
        assert (await ended(it.emergency_stop())).ok
        assert mapper.node.stopped
        await while_passes(5.0)
        assert not call.done()
        mapper.node.wake()
        outcome = await ended(call)
        assert outcome == (Code.DONE, "success true, message map.pgm")
        assert answer_of(outcome).message == "map.pgm"


@pytest.mark.parametrize("how", ["by its name", "by its key"])
async def test_an_answer_that_comes_too_late_is_told(file: Path, how: str) -> None:
    mapper = Made(Mapper)
    async with robot(mapper, robot=file, offers="save_map") as it:
        if how == "by its name":
            outcome = await ended(it.call("/save_map", KIND, {}, wait=2.0))
        else:
            outcome = await ended(it.command(it.file.commands[0]))
        assert outcome == (Code.TIMEOUT, "no answer in 2 s: the robot may still do it")
        mapper.node.wake()
        await until(lambda: any("answered late: " in e.text for e in it.snapshot.events))
        told = next(e.text for e in it.snapshot.events if "answered late: " in e.text)
        assert told.startswith(("call save_map, ", "save map, "))
        assert told.endswith("map.pgm")


@pytest.mark.parametrize("key", ["escape", "ctrl+c"])
async def test_a_key_stops_waiting_and_the_answer_is_told(file: Path, key: str) -> None:
    mapper = Made(Mapper)
    text = FILE.replace("service: save_map", "service: other")
    file.write_text(text)
    async with console(robot=file, node_makers=[mapper], wait=False) as op:
        await op.until(lambda: "/save_map" in op.app.view.snapshot.services)
        await op.press("C")
        await op.until("/save_map")
        await op.press(*"save_map", "enter")
        await op.until("It takes no values.")
        await op.press("enter")
        await op.until("esc stops waiting")
        await until(lambda: mapper.node.asked == 1)
        await op.press(key)
        await op.until("waiting no longer: the")
        mapper.node.wake()
        await op.until("success true, message map.pgm")


@pytest.fixture
def bare(here: Path) -> Path:
    """Return a robot file that does not name the service."""
    made = here / "bare.yaml"
    made.write_text("name: Mapper\nstop: {service: e_stop, request: {data: true}}\n")
    return made


async def test_a_call_that_runs_is_an_event_and_the_next_line_waits_for_it(bare: Path) -> None:
    mapper = Made(Mapper)
    async with operated(mapper, robot=bare) as person:
        person.type("call save_map\nnodes\nquit\n")
        await person.until("YOU console: call save_map: running, no answer yet (waited for up to ")
        assert "mapper up" not in person.said
        mapper.node.wake()
        assert await person.end("") == 0
    _, after = person.said.split("YOU console: call save_map: success true, message map.pgm\n")
    assert "mapper up" in after
    assert person.said.count("running") == 1


@pytest.mark.waits
async def test_a_slow_call_that_fails_behind_other_lines_counts_at_the_end(bare: Path) -> None:
    mapper = Made(Mapper)
    async with operated(mapper, robot=bare) as person:
        person.type("call save_map\nnodes\n")
        await person.until("mapper up")
        assert await person.end("") == 1
    assert "failed: call: no answer in 30 s: the robot may still do it" in person.said
