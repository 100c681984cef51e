"""What a STOP is: one rule for a line that is typed, a shell, the socket and an assistant."""

from __future__ import annotations

import asyncio
import json
import re
import tempfile
from collections.abc import Iterator
from typing import Any

import pytest

from archo_tui.cli import main
from archo_tui.client import protocol, sockets
from archo_tui.client.mcp.connection import ConsoleConnection
from archo_tui.client.mcp.server import make_server
from archo_tui.console import socket as server
from archo_tui.robot.stop import words as lines
from archo_tui.robot.stop.gate import Stops
from tests.assistant.support import INITIALIZE, FakeConsole, fake_console, process
from tests.support.shells import Graph, until
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time

STOPS = [
    *("stop", "STOP", "Stop!", "stop;", '"stop"', "STOP?", " stop", "\N{BOM}stop", "--stop"),
    *("stop now please", "stop --help now", "stop, a person is in the way", "\x1b[Astop", "-stop"),
]
OTHERS = [
    "stopped",
    "stop2",
    "nonstop",
    "don't stop",
    "go stop",
    "stop_it",
    "st op",
    "help stop",
    "stopé",
    "",
]


@pytest.fixture(autouse=True)
def _sockets(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder with a short name, which asyncio takes."""
    with tempfile.TemporaryDirectory() as folder:
        monkeypatch.setenv(sockets.FOLDER_VARIABLE, folder)
        yield


def mouths(text: str) -> dict[str, bool]:
    """Which of them take it for a STOP; of the last two, also word by word."""
    words = json.dumps({"id": 1, "words": [text]}).encode()
    split = json.dumps({"id": 1, "words": text.split()}).encode()
    escaped = "".join(f"\\u{ord(char):04x}" for char in text)
    stops = Stops()
    return {
        "typed": lines.is_stop(text.encode()),
        "request": protocol.is_stop({"words": text.split()}),
        "socket": server._stop_in(words, stops) is not None,
        "socket, word by word": server._stop_in(split, stops) is not None,
        "socket, escaped": server._stop_in(b'{"words": ["%s"]}' % escaped.encode(), stops)
        is not None,
        "socket, no JSON": server._stop_in(text.encode(), stops) is not None,
    }


@pytest.mark.parametrize("text", STOPS)
def test_what_is_a_stop_for_one_is_a_stop_for_all(text: str) -> None:
    assert set(mouths(text).values()) == {True}, mouths(text)


@pytest.mark.parametrize("text", OTHERS)
def test_what_only_looks_like_one_is_none_for_any(text: str) -> None:
    assert set(mouths(text).values()) == {False}, mouths(text)


async def stopped(console: FakeConsole) -> None:
    await until(lambda: console.asked)
    assert console.words() == [["stop"]]
    console.asked.clear()


async def test_a_shell_and_a_model_stop_by_the_same_rule(
    capsys: pytest.CaptureFixture[str],
) -> None:
    async with fake_console() as console:
        console.answer("stop", "done", "confirmed")
        for text in STOPS:
            link = ConsoleConnection("")
            assert await asyncio.to_thread(main, text.split(" ")) == 0, text
            await stopped(console)
            told = await make_server(link, goals=False).call_tool(text, {"now": [1]})
            assert not told.is_error
            assert told.structured_content["summary"].endswith("is ignored: STOP takes nothing.")
            await stopped(console)
            link.close()
        capsys.readouterr()
        await asyncio.to_thread(main, ["stop", "now", "please"])
        assert capsys.readouterr().err == "archo-tui: stop: ignored: now please\nconfirmed\n"
        await stopped(console)
        assert await asyncio.to_thread(main, ["stop", "--help"]) == 0
        assert console.asked == []


@pytest.mark.parametrize(
    ("line", "words", "complaint"),
    [
        ("--to PID stop", ["stop"], ""),
        ("--to=PID --timeout 3 Stop! now", ["stop"], "archo-tui: Stop!: ignored: now\n"),
        ("--engine embedded --json --to PID stop", ["stop"], ""),
        ("--to PID --engine embedded status", ["status"], ""),
        ("--to PID go 12", ["go", "12"], ""),
        ("--to stop", ["stop"], "archo-tui: --to is for a verb: .*: trying to send STOP anyway\n"),
        ("stop --ros-args -r a:=b", ["stop"], ""),
        ("--json stop --ros-args -r a:=b", ["stop"], ""),
        ("--timeout stop", ["stop"], "archo-tui: --timeout is for a verb: .*\n"),
        ("STOP --help", ["stop"], "archo-tui: STOP: ignored: --help\n"),
        ("stop --timeout soon", ["stop"], ""),
        ("stop --json --to", ["stop"], ""),
        ("stop \udcff", ["stop"], ""),
        (
            "--watch stop",
            ["stop"],
            "archo-tui: --watch is for the console, not for stop: trying .*\n",
        ),
        ("--engine rso2 stop", ["stop"], "archo-tui: --engine rso2: there are .*: trying .*\n"),
        (
            "--enigne ros2 stop please",
            ["stop"],
            "(?s).*: trying to send .*\n.*ignored: .*",
        ),
        ("--to 99999 go 12", None, "archo-tui: no console 99999 runs here .*\n"),
        ("--to PID", None, "archo-tui: --to is for a verb: archo-tui VERB --help says which\n"),
        ("--to PID --plain go 12", None, "archo-tui: --plain is for the console, not for go\n"),
    ],
)
async def test_options_of_a_verb_stand_before_it_and_none_keeps_a_stop_away(
    line: str, words: list[str] | None, complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    async with fake_console() as console:
        console.answer("stop", "done", "confirmed")
        console.answer("status", "done", "fine")
        console.answer("go", "done", "fine")
        given = line.replace("PID", str(console.hello["pid"])).split()
        code = await asyncio.to_thread(main, given)
        assert console.words() == ([] if words is None else [words])
        said = capsys.readouterr().err.removesuffix("confirmed\n").removesuffix("fine\n")
        assert re.fullmatch(complaint, said), said
        assert (code == 0) == (words is not None)


@pytest.mark.parametrize(
    ("line", "namespace"),
    [
        ("--engine ros2 --namspace /x stop", "/x"),
        ("--engine=rso2 --namespace=/x stop", "/x"),
        ("--enigne ros2 --watch stop", "/"),
        ("--engine ros2 --namespace /x --frobnicate 3 stop", "/x"),
    ],
)
def test_a_misspelt_option_loses_no_stop_where_no_console_runs(
    line: str, namespace: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    graph, made = Graph(), list[Any]()
    monkeypatch.setattr("archo_tui.session.session.Session", made.append)
    monkeypatch.setattr(
        "archo_tui.console.attached.attached", lambda session: session() or graph.attach()
    )
    assert main(line.split()) == 0
    assert (made[0].engine, made[0].namespace, graph.asked) == ("ros2", namespace, [["stop"]])
    assert "trying to send STOP anyway\n" in capsys.readouterr().err


def test_a_stop_that_nobody_gets_is_never_called_sent(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--namspace", "/x", "stop"]) == 3
    assert "STOP was not sent: no console" in capsys.readouterr().err


async def test_arguments_that_are_none_stop_the_robot_too() -> None:
    async with fake_console() as console:
        console.answer("stop", "done", "confirmed")
        ours = await process(first=INITIALIZE)
        assert ours.stdin is not None
        assert ours.stdout is not None
        await asyncio.wait_for(ours.stdout.readline(), DEADLINE)
        for given in ("now", ["now"], 5, None):
            request = {"name": "Stop!", "arguments": given}
            asked = {"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": request}
            ours.stdin.write(json.dumps(asked).encode() + b"\n")
            await stopped(console)
            answer = json.loads(await asyncio.wait_for(ours.stdout.readline(), DEADLINE))
            assert answer["result"]["isError"] is False
        await asyncio.wait_for(ours.communicate(b""), DEADLINE)
