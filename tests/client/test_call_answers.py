"""What a service answers is data, to a shell and to Python."""

from __future__ import annotations

import asyncio
import json
import time
from typing import Any

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

import archo_tui
from tests.support.robot import making
from tests.support.shells import raw, served, typed, until

pytestmark = pytest.mark.real_time


class Mapper(Node):
    """Tells where it has saved its map; of a large one never."""

    def __init__(self, **options: Any) -> None:
        super().__init__("mapper", **options)
        self.asked = 0
        self.create_service(Trigger, "save_map", self.save)
        group = ReentrantCallbackGroup()
        self.create_service(Trigger, "save_large_map", self.never, callback_group=group)

    def save(self, _: Any, response: Any) -> Any:
        response.success, response.message = True, "map.pgm"
        return response

    async def never(self, _: Any, response: Any) -> Any:
        self.asked += 1
        await Future[bool]()
        return response


async def test_a_shell_prints_the_answer_and_a_program_gets_its_fields() -> None:
    async with served(Mapper):
        said = await typed("call", "save_map")
        assert said == (0, "success true, message map.pgm\n", "")
        said = await typed("call", "save_map", "--json")
        assert json.loads(said.out)["data"] == {"success": True, "message": "map.pgm"}

        def call() -> Any:
            with archo_tui.connect() as robot:
                return robot.do("call", "save_map")

        assert await asyncio.to_thread(call) == {"success": True, "message": "map.pgm"}


async def test_the_result_of_any_goal_that_was_waited_for_is_data() -> None:
    pytest.importorskip("depot_interfaces")
    from tests.robots.rover import Counting

    async with served(Counting):
        said = await typed("send_goal", "fibonacci", "order=3", "--wait")
        assert (said.code, said.out) == (0, "sequence [0, 1, 1, 2]\n")
        said = await typed("send_goal", "fibonacci", "order=3", "--wait", "--json")
        last = json.loads(said.out.splitlines()[-1])
        assert last["data"]["result"] == {"sequence": [0, 1, 1, 2]}


async def test_who_waits_no_longer_is_told_that_it_may_still_be_done() -> None:
    made: list[Mapper] = []
    async with served(making(made, Mapper)):
        shell = await raw()
        shell.send({"id": 1, "words": ["call", "save_large_map"]})
        await until(lambda: made and made[0].asked)
        shell.send({"give_up": True})
        result = await shell.result()
        assert result["code"] == "cancelled"
        assert result["text"] == "waiting no longer: the robot may still do it"
        shell.close()


async def test_a_time_that_is_over_says_that_it_may_still_be_done() -> None:
    async with served(Mapper):
        began = time.monotonic()
        said = await typed("call", "save_large_map", "--timeout", "0.5")
        assert time.monotonic() - began < 2.5  # s: nothing is called off, so nothing is waited for
        assert said.code == 4
        assert said.err == "archo-tui: call: not within 0.5 s: the robot may still do it\n"
