"""A STOP whose service takes a request, as the Create 3's: with another one it releases."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.snapshot import Latch
from tests.support.plain import operated
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.stand_in import Made

FILE = """
version: 1
name: Base
stop: {service: e_stop, request: {data: true}, release: e_stop, release_request: {data: false}}
"""


class Base(Node):
    """Stops when it is sent true, and goes on when it is sent false."""

    KIND: Any = SetBool

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self.asked: list[bool] = []
        self.create_service(self.KIND, "e_stop", self.e_stop)

    def e_stop(self, request: Any, response: Any) -> Any:
        self.asked.append(request.data)
        response.success, response.message = True, "stopped" if request.data else "released"
        return response


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "base.yaml"
    made.write_text(FILE)
    return made


async def test_stop_and_release_send_what_the_file_says(file: Path) -> None:
    base = Made(Base)
    async with robot(base, robot=file, offers="e_stop") as it:
        it.stops.register()
        outcome = await ended(it.emergency_stop())
        assert outcome.ok
        assert base.node.asked == [True]
        assert it.snapshot.open_stop is None
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert (await ended(it.release_emergency_stop())).ok
        assert base.node.asked == [True, False]
        assert it.snapshot.latch is Latch.NONE
        commands = [event.command for event in it.snapshot.events if event.command]
        call = "ros2 service call /e_stop std_srvs/srv/SetBool"
        assert commands == [f"{call} '{{data: true}}'", f"{call} '{{data: false}}'"]


async def test_the_line_of_a_call_is_the_stop_or_asks_as_the_release_does(file: Path) -> None:
    base = Made(Base)
    async with operated(base, robot=file) as person:
        person.type("call e_stop data=true\n")
        await person.until("STOP: confirmed")
        person.type("call e_stop\n")
        await person.until("/e_stop needs data=true (stop) or data=false (release)")
        person.type("call e_stop data=false\n")
        await person.until("failed: call: Release the stop?")
        assert base.node.asked == [True]
        person.type("call e_stop data=false --yes\n")
        await person.until("release stop: released")
        assert base.node.asked == [True, False]
        await person.end("")


class Bare(Base):
    """Has the service, and its request no field."""

    KIND = Trigger


@pytest.mark.parametrize(
    ("file_text", "kind", "said"),
    [
        (FILE, Bare, "/e_stop is std_srvs/srv/Trigger, whose request differs: not called"),
        ("stop: e_stop\n", Base, "/e_stop is std_srvs/srv/SetBool, whose request differs"),
        ("stop: {service: e_stop, request: {on: true}}\n", Base, "whose request differs"),
        ("stop: {service: e_stop, request: {data: 1}}\n", Base, "whose data is boolean"),
    ],
)
async def test_a_request_that_does_not_fit_is_said_and_not_sent(
    here: Path, file_text: str, kind: Any, said: str
) -> None:
    file = here / "robot.yaml"
    file.write_text(file_text)
    base = Made(kind)
    async with robot(base, robot=file) as it:
        await until(lambda: said in it.snapshot.faults.get("e_stop", ""))
        it.stops.register()
        outcome = await ended(it.emergency_stop())
        assert outcome.code is Code.REFUSED
        assert said in outcome.text
        assert outcome.text.endswith("use the hardware stop")
        assert not base.node.asked


async def test_a_node_that_starts_behind_a_stop_is_sent_its_request_first(file: Path) -> None:
    made: list[Base] = []
    async with operated(making(made, Base), robot=file) as person:
        person.type("stop\n")
        await person.until("STOP: confirmed")
        person.type("halt base\nstart base\n")
        await person.until("base was told STOP first, and is stopped")
        assert [node.asked for node in made] == [[True], [True]]
        await person.end("")
