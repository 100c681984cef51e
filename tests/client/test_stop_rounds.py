"""What a STOP is for each mouth; behind one nothing moves until a later release."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import random
import re
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import archo_tui
from archo_tui.cli import main
from archo_tui.client import protocol, shell, sockets
from archo_tui.client.errors import Unreached
from archo_tui.client.mcp.connection import ConsoleConnection
from archo_tui.client.mcp.server import make_server
from archo_tui.client.robot import Robot
from archo_tui.console import socket as server
from archo_tui.robot.stop import words as lines
from archo_tui.robot.stop.gate import Stops
from tests.assistant.support import INITIALIZE, FakeConsole, fake_console, process
from tests.support.night import corners
from tests.support.shells import Graph, reached, until
from tests.support.terminal import Terminal
from tests.support.traced import BEGUN, MOVED, RELEASE, RELEASED, STOP, STOPPED, Trace, code
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time


BRISK = ("--ros-args", "-p", "feedback_period:=0.05", "-p", "time_scale:=10.0")


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ([BEGUN, MOVED, STOP, MOVED, STOPPED], ""),
        ([STOP, STOPPED, MOVED], "moved, behind STOP 1, word 2"),
        ([STOP, STOPPED, RELEASED, BEGUN], "begun, behind STOP 1, word 3"),
        ([RELEASE, STOP, STOPPED, RELEASED, MOVED], "moved, behind STOP 1, word 4"),
        ([STOP, STOPPED, RELEASE, RELEASED, MOVED, STOP, MOVED, STOPPED], ""),
        ([STOPPED, STOP, MOVED], "moved, behind STOP 1, word 2"),
    ],
)
def test_a_trace_is_judged(words: list[str], fault: str) -> None:
    trace = Trace()
    trace.take(words)
    assert trace.fault == fault


class Rounds:
    """A console in a terminal, and whoever else speaks to its robot."""

    def __init__(self, folder: Path, seed: int, *, screen: bool) -> None:
        self._choose, self._path, self._screen = random.Random(seed), folder / "trace", screen
        self._read = self._stops = 0  # words of the trace; STOPs that were said
        self.trace = Trace()
        words = () if screen else ("--plain",)
        self._console = Terminal(*words, *BRISK, code=code(self._path), fresh=True)
        self._pool = ThreadPoolExecutor(16)
        self._has_ended = False
        self._drawing = threading.Thread(target=self._draw, daemon=True)
        self._drawing.start()
        self._said: list[str] = []  # in this round
        self._where = f"seed {seed}"
        self._robot: Robot | None = None  # in Python, connected once

    def _draw(self) -> None:
        while not self._has_ended:
            self._console.read()
            self._console.output = self._console.output[-10_000:]

    def close(self) -> None:
        """Leave nothing behind."""
        os.kill(self._console.pid, signal.SIGCONT)
        os.kill(self._console.pid, signal.SIGKILL)
        self._pool.shutdown()
        self._has_ended = True
        self._drawing.join()
        self._console.exit_code(reading=False)
        self._console.close()

    # mouths; each says it and waits for the end, as long as that takes

    def _by_shell(self, *words: str) -> None:
        shell.run([*words, "--wait"] if words[0] == "go" else words, ())

    def _by_python(self, *words: str) -> None:
        with contextlib.suppress(archo_tui.NotDone):
            if words == ("stop",):
                archo_tui.stop()
                return
            with archo_tui.connect() as robot:
                if words[0] == "go":
                    robot.go(int(words[1])).wait(1.0)
                else:
                    robot.do(*words)

    def _by_robot(self, *words: str) -> None:
        assert words == ("stop",)
        assert self._robot is not None
        with contextlib.suppress(archo_tui.NotDone):
            self._robot.stop()

    def _by_assistant(self, *words: str) -> None:
        assert words == ("stop",)

        async def call() -> None:
            link = ConsoleConnection("")
            with contextlib.suppress(Unreached):
                await link.stop()
            link.close()

        asyncio.run(call())

    def _by_socket(self, *words: str) -> None:
        (path,) = sockets.socket_paths()[:1]
        with contextlib.suppress(OSError), reached(path) as console:
            console.send(json.dumps({"id": 1, "words": words}).encode() + b"\n")

    def _by_text(self, *words: str) -> None:
        assert words == ("stop",)
        with reached(sockets.socket_paths()[0]) as console:
            console.send(b"STOP!")

    def _by_console(self, *words: str) -> None:
        if not self._screen:
            self._console.write(" ".join(words) + "\n")
        elif words == ("stop",):
            self._console.write("\x18")
        elif words[0] == "go":
            self._console.write(f"g{words[1]}\r")
        else:
            self._by_socket(*words)

    def say(self, *words: str, console: bool = True) -> Future[None]:
        """Say it by a mouth at random, on a thread of its own; `console` counts among them."""
        mouths = [self._by_shell, self._by_python, self._by_socket]
        if words == ("stop",):
            mouths += [self._by_assistant, self._by_text, self._by_robot]
        if console:
            mouths.append(self._by_console)
        mouth = self._choose.choice(mouths)
        self._said.append(f"{' '.join(words)} {mouth.__name__}")
        self._stops += words == ("stop",)
        return self._pool.submit(mouth, *words)

    def _until(self, holds: Callable[[], object]) -> None:
        end = time.monotonic() + DEADLINE
        while not holds():
            assert time.monotonic() < end, self._about()
            time.sleep(0.005)
            self.judge()

    def judge(self) -> None:
        """Judge what the console and its robot have written since."""
        words = self._path.read_text().splitlines() if self._path.exists() else []
        self.trace.take(words[self._read :])
        self._read = len(words)
        assert not self.trace.fault, self._about()

    def _about(self) -> str:
        written = self._path.read_text() if self._path.exists() else ""
        last = written.splitlines()[-60:]
        seen = self._console.text[-3000:]
        return f"{self._where}: {self.trace.fault}\n{self._said}\n{' '.join(last)}\n{seen}"

    def ready(self) -> None:
        """Wait until a goal can be sent."""
        self._until(sockets.socket_paths)
        assert shell.run(["wait", "ready", "--timeout", str(DEADLINE)], ()) == 0
        self._robot = archo_tui.connect()

    def round(self, number: int) -> None:
        """Say this and that, suspend the console perhaps, say STOP, and see what holds."""
        choose, self._said = self._choose, []
        self._where = f"{self._where.partition(',')[0]}, round {number}"
        others = [
            ["go", "12"],
            ["go", "7"],
            ["cancel"],
            ["continue"],
            ["skip"],
            ["release", "--yes"],
        ]
        underway = []
        if choose.random() < 0.7:
            underway.append(self.say("release", "--yes", console=False))
            # a STOP of the round before that arrives behind this release keeps it stopped
            end = time.monotonic() + 2.0
            self._until(lambda: not self.trace.is_stopped or time.monotonic() > end)
            moves = self.trace.moves
            underway.append(self.say("go", "12", console=False))
            if choose.random() < 0.7:  # else the STOP comes as it is sent
                self._until(lambda: self.trace.moves > moves or underway[-1].done())
        for words in choose.choices(others, k=choose.randrange(1, 4)):
            underway.append(self.say(*words))
            time.sleep(choose.choice([0.0, 0.01, 0.1]))
        sleeps = choose.random() < 0.5
        if sleeps:
            os.kill(self._console.pid, signal.SIGSTOP)
        for _ in range(choose.choice([1, 1, 1, 2])):
            underway.append(self.say("stop"))
            if choose.random() < 0.3:
                underway.append(self.say(*choose.choice(others)))
        if sleeps:
            time.sleep(choose.choice([0.0, 0.05, 0.2, 0.2, 1.3]))
            os.kill(self._console.pid, signal.SIGCONT)
        self._until(lambda: self.trace.stops >= self._stops)
        self._until(lambda: self.trace.is_stopped or not self.trace.is_final)
        self._until(lambda: all(one.done() for one in underway))
        for one in underway:
            one.result()


@pytest.mark.parametrize("screen", corners([False], [True]), ids=["plain", "screen"])
def test_behind_a_stop_nothing_moves_until_a_later_release(
    screen: bool, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    far = request.config.getoption("--night")
    seed, rounds = (random.randrange(10**6), 1000) if far else (1, 8)
    walk = Rounds(tmp_path, seed, screen=screen)
    try:
        walk.ready()
        for number in range(10 * rounds):
            walk.round(number)
            # On a busy machine many a STOP comes before the goal has moved.
            if number >= rounds - 1 and walk.trace.moves > rounds:
                break
        assert walk.trace.moves > rounds
    finally:
        walk.close()


STOPS = [
    *("stop", "STOP", "Stop!", "stop;", '"stop"', "STOP?", " stop", "\N{BOM}stop", "--stop"),
    *("stop now please", "stop --help now", "stop, a person is in the way", "\x1b[Astop", "-stop"),
]
OTHERS = [
    *("stopped", "stop2", "nonstop", "don't stop", "go stop", "stop_it", "st op", ""),
    *("help stop", "stopé"),
]


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
