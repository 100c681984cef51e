"""Its process and its connection: odd consoles, whatever a model says, and each end."""

from __future__ import annotations

import asyncio
import json
import random
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from mcp import Client
from mcp.client.stdio import stdio_client

from archo_tui.client.errors import Unreached
from archo_tui.client.mcp.connection import SILENT, ConsoleConnection
from archo_tui.client.mcp.server import make_server
from archo_tui.robot.stop.words import is_stop_text
from tests.assistant.support import (
    INITIALIZE,
    FakeConsole,
    assistant,
    fake_console,
    parameters,
    process,
)
from tests.support.shells import until
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time


WAIT = (
    b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": '
    b'{"name": "wait", "arguments": {"request": 3}}}\n'
)


async def test_all_calls_go_through_one_connection_that_closes_at_the_end() -> None:
    async with fake_console() as console:
        console.answer("status", "done", data={})
        async with assistant() as model:
            for _ in range(3):
                assert not (await model.call("status")).failed
            both = asyncio.gather(*(model.call("status") for _ in range(5)))
            assert not any(said.failed for said in await both)
            assert (console.connections, console.closed) == (1, 0)
        await until(lambda: console.closed == 1)
        numbers = [request["id"] for request in console.asked]
        assert len(set(numbers)) == len(numbers) == 8


async def waiting(console: FakeConsole) -> asyncio.subprocess.Process:
    """The process, while a call of it waits for a request."""
    made = await process("--allow", "goals", first=INITIALIZE + WAIT)
    await until(lambda: console.asked)
    return made


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL, signal.SIGINT])
async def test_killed_in_the_middle_its_connection_closes(number: signal.Signals) -> None:
    async with fake_console() as console:
        ours = await waiting(console)
        assert ours.stdout is not None
        first = await asyncio.wait_for(ours.stdout.readline(), DEADLINE)
        ours.send_signal(number)
        await until(lambda: console.closed == 1)
        rest, err = await asyncio.wait_for(ours.communicate(), DEADLINE)
        out = first + rest
        assert ours.returncode == -number
        assert (out.count(b"\n"), err) == (1, b"")  # the answer to initialize


async def test_closed_in_the_middle_it_ends_without_a_word() -> None:
    async with fake_console() as console:
        ours = await waiting(console)
        _, err = await asyncio.wait_for(ours.communicate(b""), DEADLINE)
        assert (ours.returncode, err) == (0, b"")
        await until(lambda: console.closed == 1)


async def test_a_client_that_no_longer_reads_ends_it() -> None:
    async with fake_console() as console:
        ours = await waiting(console)
        transport = ours._transport  # type: ignore[attr-defined]
        transport.get_pipe_transport(1).close()
        assert ours.stdin is not None
        ours.stdin.write(WAIT.replace(b'"wait"', b'"no_such"').replace(b'"id": 1', b'"id": 2'))
        ours.stdin.close()
        await asyncio.wait_for(ours.wait(), DEADLINE)
        await until(lambda: console.closed == 1)


async def test_a_console_that_was_restarted_is_found_again_and_that_is_said() -> None:
    async with assistant() as model:
        async with fake_console(7) as first:
            first.answer("status", "done", data={})
            assert "news" not in (await model.call("status")).data
        said = await model.call("status")
        assert said.data["summary"].startswith("no console runs here")
        async with fake_console(8) as second:
            second.answer("status", "done", data={})
            said = await model.call("status")
            assert not said.failed
            assert said.data["news"].startswith("The console was restarted")
            assert "news" not in (await model.call("status")).data


async def test_a_console_that_goes_in_the_middle_is_said() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        waits = asyncio.ensure_future(model.call("wait", request=3))
        await until(lambda: console.asked)
        console.drop()
        said = await waits
        assert said.failed
        assert said.data["summary"] == "the console is gone; the robot may still be moving"


async def test_an_old_client_that_shakes_hands_is_served_too() -> None:
    async with fake_console() as console:
        console.answer("status", "done", data={})
        async with Client(stdio_client(parameters()), mode="legacy") as client:
            assert len((await client.list_tools()).tools) == 7
            assert not (await client.call_tool("status", {})).is_error


RANDOM_CALLS = 5000
NAMES = ("status", "events", "history", "parameters", "stop", "go", "wait", "cancel")
OTHERS = ("release", "set", "allow", "answer", "go --yes", "", "Stop", "\x1b[31m", "call" * 999)
ARGUMENTS = ("kind", "values", "request", "seconds", "level", "node", "name", "words")
VALUES: tuple[Any, ...] = (
    *("go", "stop", "release", "WARN", "--yes", "", "\ud800", "x" * 10_000, "motor_controller"),
    *(None, True, False, 0, 1, 3, 12, -1, 50, 60, 10**400, 0.5, 1e308, float("nan"), float("inf")),
    *([], [12], {}, {"shelf_number": 12}, {"shelf_number": {"a": [1]}}, {"a": float("nan")}),
)


@asynccontextmanager
async def linked(to: str = "") -> AsyncIterator[ConsoleConnection]:
    link = ConsoleConnection(to)
    try:
        yield link
    finally:
        link.close()


def is_allowed(request: dict[str, Any]) -> bool:
    """True for what an assistant may say to a console."""
    own = {name: value for name, value in request.items() if name not in ("id", "assistant")}
    if "ask" in own:
        asked = own.pop("ask")
        return not own and set(asked) == {"kind", "values"}
    words = own.pop("words")
    timeout = own.pop("timeout", 0.5)
    looks = words[0] in ("status", "events", "history", "params", "get", "goals")
    waits = words[:2] == ["wait", "request"] and words[2].isdecimal()
    return not own and 0 < timeout <= 1 and (looks or waits or words in (["stop"], ["cancel"]))


async def test_whatever_a_model_calls_only_what_it_may_is_sent() -> None:
    dice = random.Random(7)
    async with fake_console() as console, linked() as link:
        server = make_server(link, goals=True)
        tools = await server.list_tools()
        known = {tool.name: tool.input_schema["properties"] for tool in tools}
        console.answer("wait", "denied", "request 3 is denied")
        for word in ("status", "history", "params", "events", "get", "stop", "cancel"):
            console.answer(word, "done", "", data=[])
        console.answer("ask", "refused", "not now")
        for _ in range(RANDOM_CALLS):
            name = dice.choice((*NAMES, *OTHERS))
            schema = known.get(name, {})
            some = [one for one in (*schema, *ARGUMENTS) if one in schema or dice.random() < 0.05]
            given = {one: dice.choice(VALUES) for one in some if dice.random() < 0.8}
            result = await server.call_tool(name, given)
            told, failed = result.structured_content, result.is_error
            json.dumps(told, allow_nan=False).encode()
            assert failed or name in NAMES or is_stop_text(name)
            assert told["summary"].isprintable()
            assert len(told["summary"]) < 300
        stops = [request for request in console.asked if request.get("words") == ["stop"]]
        assert console.connections == 1 + len(stops)  # Each STOP has one of its own.
        assert [request for request in console.asked if not is_allowed(request)] == []
        assert all(request["assistant"] is True for request in console.asked)
        spoken = {request["words"][0] for request in console.asked if "words" in request}
        assert {"status", "params", "get", "stop", "wait", "cancel"} <= spoken


async def test_a_console_that_does_not_answer_is_said_and_the_link_stays() -> None:
    async with fake_console() as console, linked() as link:
        with pytest.raises(Unreached, match="is it suspended"):
            await link.request(0.05, words=["status"])
        console.answer("status", "done", data={})
        assert (await link.request(words=["status"]))["data"] == {}
        assert console.connections == 1
    assert "may still be moving" in SILENT


async def test_what_a_console_says_beside_results_is_passed_over() -> None:
    async with fake_console() as console, linked() as link:

        async def chats(request: dict[str, Any]) -> dict[str, Any]:
            for said in (
                {"id": 999, "code": "done"},
                {"id": None, "code": "misuse"},
                {"id": [1], "code": "done"},
                {"id": request["id"], "said": "accepted"},
                {"id": request["id"], "code": 7},
            ):
                console.say(said)
            return {"code": "done", "text": "at last"}

        console.answers["status"] = chats
        assert (await link.request(words=["status"]))["text"] == "at last"


@pytest.mark.parametrize("line", [b"no JSON\n", b"[1]\n", b'{"id": 1, "code": "done"'])
async def test_a_console_that_speaks_no_protocol_is_one_that_has_gone(line: bytes) -> None:
    async with fake_console() as console, linked() as link:

        async def babbles(_: dict[str, Any]) -> None:
            console.write(line)
            if not line.endswith(b"\n"):
                console.drop()

        console.answers["status"] = babbles
        with pytest.raises(Unreached, match="the console is gone"):
            await link.request(words=["status"])
