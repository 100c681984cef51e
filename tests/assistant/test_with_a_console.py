"""The whole way: a client of the protocol, the assistant's process, and a console that runs."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from archo_tui.client import sockets
from archo_tui.station.approvals import READING_TIME
from tests.assistant.support import Assistant, assistant
from tests.support.shells import until
from tests.support.terminal import Terminal
from tests.support.waiting import DEADLINE, Waited

pytestmark = pytest.mark.real_time


@asynccontextmanager
async def beside(terminal: Terminal) -> AsyncIterator[Assistant]:
    """An assistant beside a console whose output is read meanwhile."""

    async def read_on() -> None:
        while True:
            terminal.read(0.0)
            await asyncio.sleep(0.01)

    terminal.until(lambda: sockets.socket_paths())
    reading = asyncio.ensure_future(read_on())
    try:
        async with assistant("--allow", "goals") as model:
            yield model
    finally:
        reading.cancel()


async def told(model: Assistant, tool: str, holds: Callable[[Any], object], **given: Any) -> Any:
    """What the robot says as soon as that holds."""
    waited = Waited(DEADLINE)
    while not holds(robot := (await model.call(tool, **given)).robot):
        assert not waited.too_long(), robot
    return robot


async def read() -> None:
    """As long as a person needs until an answer counts."""
    end = time.monotonic() + 1.5 * READING_TIME
    await until(lambda: time.monotonic() > end)


async def test_a_console_is_read_a_goal_is_driven_once_allowed_and_stopped(
    terminals: list[Terminal],
) -> None:
    fast = ("--ros-args", "-p", "time_scale:=75.0", "-p", "feedback_period:=0.05")
    terminals.append(Terminal("--plain", *fast))
    async with beside(terminals[0]) as model:
        status = await told(model, "status", lambda robot: robot["battery"]["age"] is not None)
        assert (status["robot"], status["battery"]["source"]) == ("ARCHO", "measured")
        events = (await told(model, "events", lambda robot: "Dashboard sees" in str(robot)))[
            "events"
        ]
        assert all(0 <= event["age"] < 600 for event in events)
        charge = (await model.call("history")).robot["charge"]["readings"]
        assert charge[0]["value"] == pytest.approx(status["battery"]["percentage"], abs=5)
        one = await model.call("parameters", node="motor_controller", name="max_speed")
        assert one.robot["parameters"][0]["value"] == 0.8

        said = await model.call("go", kind="go", values={"shelf_number": 12})
        assert (said.failed, said.data["code"]) == (False, "asked")
        waits = await model.call("wait", request=1, seconds=0)
        assert waits.data["code"] == "ran_out"
        await until(lambda: "wants: go to shelf 12 (allow 1" in terminals[0].text)
        await read()
        terminals[0].write("allow 1\r")
        await until(lambda: "allowed request 1" in terminals[0].text)
        ended = await model.call("wait", request=1, seconds=50)
        assert (ended.failed, ended.data["code"]) == (False, "arrived")

        said = await model.call("stop")
        assert said.data["summary"].startswith("STOP is confirmed by the robot")
        assert (await model.call("status")).robot["motion"]["stopped"] is True
        await until(lambda: "STOP: confirmed" in terminals[0].text)
