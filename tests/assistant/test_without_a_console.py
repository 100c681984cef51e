"""The tools as they are listed, odd arguments, and no console to answer."""

from __future__ import annotations

import asyncio
import math
import subprocess
import sys
from typing import Any

import pytest
from mcp import Client
from mcp.client.stdio import stdio_client

from archo_tui.robot_file.model import NO_STOP
from tests.assistant.support import assistant, fake_console, parameters, process
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time

LOOKING = {"status", "events", "history", "parameters", "echo", "interface"}
NOBODY = "no console runs here: start archo-tui, or archo-tui --plain"


async def test_it_looks_and_stops_unless_goals_are_allowed() -> None:
    async with assistant() as model:
        assert set(await model.tools()) == LOOKING | {"stop"}
        said = await model.call("go", kind="go", values={"shelf_number": 1})
        assert said.failed
        assert said.data["summary"].startswith("no tool 'go': the tools are status, events")


async def test_its_tools_say_what_they_do_to_the_robot() -> None:
    async with assistant("--allow", "goals") as model:
        listed = await model.tools()
    hints = {
        name: (
            tool.annotations.read_only_hint,
            tool.annotations.destructive_hint,
            tool.annotations.idempotent_hint,
            tool.annotations.open_world_hint,
        )
        for name, tool in listed.items()
    }
    assert hints == {
        **dict.fromkeys([*LOOKING, "wait"], (True, False, True, False)),
        **dict.fromkeys(["stop", "cancel"], (False, False, True, False)),
        "go": (False, True, False, True),
    }
    for name, tool in listed.items():
        assert tool.input_schema["additionalProperties"] is (name == "stop"), name
        assert len(tool.description or "") < 500, name
    assert "NOTHING MOVES until a person allows it" in listed["go"].description


async def test_without_a_console_every_tool_says_how_to_start_one() -> None:
    given: dict[str, dict[str, Any]] = {
        "go": {"kind": "go", "values": {"shelf_number": 12}},
        "wait": {"request": 1},
        "interface": {"type": "std_msgs/msg/String"},
        "echo": {"topic": "/battery_level"},
    }
    async with assistant("--allow", "goals") as model:
        for name in await model.tools():
            said = await model.call(name, **given.get(name, {}))
            assert said.failed, name
            assert NOBODY in said.data["summary"], name
            assert "from_the_robot" not in said.data
        assert "hardware stop" in (await model.call("stop")).data["summary"]


async def test_of_several_consoles_none_is_guessed() -> None:
    async with fake_console(7) as first, fake_console(8) as second:
        async with assistant() as model:
            said = await model.call("status")
            assert said.failed
            assert said.data["summary"].startswith("several consoles run here, --to PID")
            assert [line.strip()[:5] for line in said.robot["said"]] == ["pid 7", "pid 8"]
        async with assistant("--to", "/r8") as model:
            second.answer("status", "done", data={})
            assert not (await model.call("status")).failed
        assert (first.words(), second.words()) == ([], [["status"]])


async def test_stop_goes_to_every_console_that_may_be_meant() -> None:
    async with fake_console(7) as first, fake_console(8) as second, assistant() as model:
        first.answer("stop", "done", "confirmed")
        second.answer("stop", "not_confirmed", "no answer yet")
        said = await model.call("stop")
        assert said.failed
        assert "NOT confirmed" in said.data["summary"]
        assert [one["said"] for one in said.robot["consoles"]] == [["confirmed"], ["no answer yet"]]
        assert first.words() == second.words() == [["stop"]]
        assert first.asked[0]["assistant"] is True
        for console in (first, second):
            console.answer("stop", "not_offered", f"Rover {NO_STOP} (cancelling 1)")
        said = await model.call("stop")
        assert said.data["summary"].startswith("The robot has NO STOP.")
        assert (said.failed, "hardware stop" in said.data["summary"]) == (True, True)


ODD: list[tuple[str, dict[str, Any], str]] = [
    ("go", {}, "kind: Field required"),
    ("go", {"kind": "go"}, "values: Field required"),
    (
        "go",
        {"kind": "x" * 1_000_000, "values": {}},
        "kind: String should have at most 200 characters",
    ),
    ("go", {"kind": 5, "values": {}}, "kind: Input should be a valid string"),
    ("go", {"kind": "go", "values": [12]}, "values: Input should be a valid dictionary"),
    ("go", {"kind": "go", "values": {"n": "x" * 5000}}, "values: at most 4096 bytes of JSON"),
    ("go", {"kind": "go", "values": {}, "yes": True}, "unknown argument 'yes': this tool takes"),
    ("wait", {"request": "3"}, "request: Input should be a valid integer"),
    ("wait", {"request": True}, "request: Input should be a valid integer"),
    ("wait", {"request": 1.5}, "request: Input should be a valid integer"),
    ("wait", {"request": 10**300}, "request: Input should be less than"),
    ("wait", {"request": 1, "seconds": 51}, "seconds: Input should be less than"),
    ("wait", {"request": 1, "seconds": -1}, "seconds: Input should be greater than"),
    ("wait", {"request": 1, "seconds": math.nan}, "seconds: "),
    ("events", {"level": "LOUD"}, "level: Input should be 'DEBUG'"),
    ("history", {"minutes": 7}, "unknown argument 'minutes': this tool takes no arguments"),
    ("parameters", {"name": "max_speed"}, "name takes a node too"),
    ("status", {"\x1b[31m": 1}, "unknown argument '\\x1b[31m': this tool takes no arguments"),
    ("release", {}, "no tool 'release': the tools are status"),
    ("allow", {"request": 1}, "no tool 'allow'"),
    ("set", {"node": "n", "name": "n", "value": 1}, "no tool 'set'"),
]


async def test_odd_arguments_are_one_clear_line_and_reach_no_console() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        for name, given, words in ODD:
            said = await model.call(name, **given)
            assert said.failed, given
            assert said.data["code"] == "misuse"
            assert said.data["summary"].startswith(words)
            assert len(said.data["summary"]) < 200
            assert said.data["summary"].isprintable()
        assert console.asked == []


async def test_it_ends_when_its_client_closes_and_prints_nothing_else() -> None:
    ours = await process("--allow", "goals")
    out, err = await asyncio.wait_for(ours.communicate(b""), DEADLINE)
    assert (ours.returncode, out, err) == (0, b"", b"")


async def test_what_is_printed_in_its_process_never_reaches_the_client() -> None:
    code = "import archo_tui.client.mcp.server as s; was = s.make_server\n"
    code += "s.make_server = lambda *g, **k: (print('stray', flush=True), was(*g, **k))[1]"
    async with Client(stdio_client(parameters(code=code))) as client:
        assert len((await client.list_tools()).tools) == 7


def test_without_the_extra_it_is_one_line() -> None:
    code = (
        "import sys; sys.modules['mcp'] = None; sys.modules['mcp_types'] = None;"
        "from archo_tui.cli import main; sys.exit(main(['mcp']))"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    said = "mcp needs another package: pip install '.[mcp]' in a clone of archo-tui"
    assert done.stderr == f"archo-tui: {said}\n"
