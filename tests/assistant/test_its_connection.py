"""One connection for the life of the process: it ends with it, however that is."""

from __future__ import annotations

import asyncio
import signal

import pytest
from mcp import Client
from mcp.client.stdio import stdio_client

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
