"""The link to the console, in the test's own process: odd consoles, and whatever a model says."""

from __future__ import annotations

import asyncio
import json
import random
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from archo_tui.client.errors import Unreached
from archo_tui.client.mcp.connection import SILENT, ConsoleConnection
from archo_tui.client.mcp.server import make_server
from archo_tui.robot.stop.words import is_stop_text
from tests.assistant.support import fake_console

pytestmark = pytest.mark.real_time

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


async def test_two_calls_at_once_make_one_connection() -> None:
    async with fake_console() as console, linked() as link:
        console.answer("status", "done")
        await asyncio.gather(link.request(words=["status"]), link.request(words=["status"]))
        assert console.connections == 1


async def test_a_stop_waits_for_no_connection_that_another_call_makes() -> None:
    async with fake_console() as console, linked() as link:
        console.answer("status", "done")
        console.answer("stop", "done", "confirmed")
        _, stopped = await asyncio.gather(link.request(words=["status"]), link.stop())
        assert (stopped, console.connections) == ([{"code": "done", "text": "confirmed"}], 2)
