"""Which console is meant: environments and states of consoles by mouths, and STOPs that arrive."""

from __future__ import annotations

import asyncio
import json
import signal
import socket
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple
from unittest.mock import patch

import pytest

import archo_tui
from archo_tui.client import find, shell, sockets
from archo_tui.client.errors import Unreached
from archo_tui.client.mcp.connection import ConsoleConnection
from archo_tui.client.mcp.server import make_server
from archo_tui.client.shell import print_consoles
from archo_tui.console import socket as server
from tests.assistant.support import FakeConsole, fake_console, listening
from tests.support.night import corners
from tests.support.script import SLOW, Script
from tests.support.shells import Graph, client, heard, reached, said, served, typed, until
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time

STATUS = {"robot": "R", "namespace": "/", "watching": False, "alarms": [], "stop": "", "line": ""}


@pytest.fixture(autouse=True)
def _place(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Give this user a place of the test's own; nothing else is looked into."""
    for name in (sockets.FOLDER_VARIABLE, find.CHOSEN):
        monkeypatch.delenv(name, raising=False)
    with TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setattr(sockets, "_TEMPORARY", folder)
        yield


@asynccontextmanager
async def answering(namespace: str, pid: int = 7, **more: Any) -> AsyncIterator[FakeConsole]:
    """A console that says which one it is, and whatever is asked is done."""
    async with fake_console(pid, namespace, **more) as console:
        console.answer("stop", "done", "confirmed")
        console.answer("status", "done", "fine", tells=True, data=STATUS)
        yield console


# mouths: each ends with an exit code, or as an assistant's tool does


def by_shell(verb: str = "status") -> int:
    return said(verb).code


def by_python() -> int:
    try:
        archo_tui.connect().close()
    except Unreached:
        return 3
    return 0


def by_consoles() -> int:
    return print_consoles(as_json=False)


def by_assistant(tool: str = "status") -> int:
    async def ask() -> bool:
        link = ConsoleConnection("")
        try:
            return bool((await make_server(link, goals=False).call_tool(tool, {})).is_error)
        finally:
            link.close()

    return 3 if asyncio.run(ask()) else 0


stop_by_shell = partial(by_shell, "stop")
Mouth = Callable[[], int]
VERBS: tuple[Mouth, ...] = (by_shell, by_python, by_assistant)
STOPS: tuple[Mouth, ...] = (stop_by_shell, partial(by_assistant, "stop"))
MOUTHS = (*VERBS, *STOPS, by_consoles)


ONE_FOLDER: dict[str, str | None] = {sockets.FOLDER_VARIABLE: "odd"}
LOGIN: dict[str, str | None] = {"XDG_RUNTIME_DIR": "odd", "XDG_STATE_HOME": "odd"}
# The variables of a console, and those of whoever looks for it.
WHERE: dict[str, tuple[dict[str, str | None], dict[str, str | None]]] = {
    "a desktop": (LOGIN, LOGIN),
    "cron": (LOGIN, {"HOME": None, "PATH": None}),
    "cron, and the other way round": ({"HOME": None}, LOGIN),
    "su, which leaves another's": (LOGIN, {"XDG_RUNTIME_DIR": "no/such", "HOME": "elsewhere"}),
    "temporary files elsewhere": ({"TMPDIR": "odd"}, {"TMPDIR": None}),
    "one folder": (ONE_FOLDER, ONE_FOLDER),
}


def chosen(patch: pytest.MonkeyPatch, folder: Path, given: dict[str, str | None]) -> None:
    for name, value in given.items():
        if value is None:
            patch.delenv(name, raising=False)
        else:
            patch.setenv(name, str(folder / value))


@pytest.mark.parametrize("where", WHERE)
async def test_a_console_is_found_in_every_environment_by_every_mouth(
    where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with TemporaryDirectory(dir="/tmp") as odd:
        (Path(odd) / "elsewhere").mkdir()
        with monkeypatch.context() as patch:
            chosen(patch, Path(odd), WHERE[where][0])
            entered = answering("/")
            console = await entered.__aenter__()
        monkeypatch.chdir(Path(odd) / "elsewhere")
        chosen(monkeypatch, Path(odd), WHERE[where][1])
        for mouth in MOUTHS:
            assert await asyncio.to_thread(mouth) == 0, (where, mouth)
        assert console.words() == [["status"], ["status"], ["stop"], ["stop"]]
        await entered.__aexit__(None, None, None)
        assert sockets.socket_paths() == []
        monkeypatch.undo()


class State(NamedTuple):
    """Who runs, how verbs end then, and how STOP and the list do."""

    awake: tuple[str, ...]
    silent: tuple[str, ...]
    verb: int
    stop: int
    listed: int


STATES = {
    "none": State((), (), 3, 3, 3),
    "one": State(("/",), (), 0, 0, 0),
    "suspended": State((), ("/",), 3, 3, 3),
    "two": State(("/north", "/south"), (), 3, 0, 0),
    "one of two suspended": State(("/north",), ("/south",), 3, 3, 3),
    "both suspended": State((), ("/north", "/south"), 3, 3, 3),
}


@pytest.mark.parametrize("state", STATES)
async def test_a_verb_goes_to_the_only_one_and_a_stop_to_all(
    state: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(find, "HELLO_TIMEOUT", 0.4)
    monkeypatch.setattr(find, "WAKE_TIMEOUT", 0.5)
    awake, silent, *codes = STATES[state]
    entered = [listening(name, 90 + n) for n, name in enumerate(silent)]
    listen = [one.__enter__()[0] for one in entered]
    answers = [answering(name, 7 + n) for n, name in enumerate(awake)]
    running = [await one.__aenter__() for one in answers]
    killed = socket.socket(socket.AF_UNIX)  # of a console that is gone
    Path(sockets.folder()).mkdir(mode=0o700, exist_ok=True)
    killed.bind(f"{sockets.folder()}/5-gone.sock")
    killed.close()
    for mouths, code in zip((VERBS, STOPS, (by_consoles,)), codes, strict=True):
        for mouth in mouths:
            assert await asyncio.to_thread(mouth) == code, (state, mouth)
    reached = ["status", "status"] if codes[0] == 0 else []
    assert not [path for path in sockets.socket_paths() if "gone" in path]
    for console in running:
        assert console.words() == [[word] for word in (*reached, "stop", "stop")]
    for made in listen:  # what waits to be read when it wakes
        assert [json.loads(line)["words"] for line in unread(made)] == [["stop"], ["stop"]]
    for one in entered:
        one.__exit__(None, None, None)
    for answer in answers:
        await answer.__aexit__(None, None, None)


def unread(made: socket.socket) -> list[bytes]:
    """Take all that wait to be taken; return the lines that they have sent."""
    made.setblocking(False)
    found = b""
    with suppress(BlockingIOError):
        while True:
            connected, _ = made.accept()
            with connected, suppress(BlockingIOError):
                connected.setblocking(False)
                found += connected.recv(65536)
    return found.splitlines()


async def test_a_suspended_console_that_is_not_meant_is_in_nobodys_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(find, "WAKE_TIMEOUT", 1.0)
    async with answering("/north") as north:
        with listening("/south", 9) as (south, _):
            assert (await typed("status", "--to", "/north")).code == 0
            assert (await typed("stop", "--to", "7")).code == 0
            assert unread(south) == []
            told = await typed("status")
            assert told.code == 3
            assert "the console of pid 9, /south, does not answer" in told.err
            told = await typed("stop")
            assert told.code == 3
            assert "pid 9, /south, does not answer yet: STOP waits for it" in told.err
            assert "/south, embedded: not confirmed: the robot may be moving" in told.err
            assert "/north, embedded: confirmed" in told.err
        assert north.words() == [["status"], ["stop"], ["stop"]]


async def test_a_verb_goes_to_the_console_that_can_act_and_a_stop_to_both() -> None:
    async with answering("/") as acting, answering("/", 8, watching=True) as watching:
        assert [await asyncio.to_thread(verb) for verb in VERBS] == [0, 0, 0]
        assert (acting.words(), watching.words()) == ([["status"]] * 2, [])
        assert (await typed("status", "--to", "8")).code == 0  # it is named
        assert await asyncio.to_thread(stop_by_shell) == 0
        assert acting.words()[-1] == ["stop"]
        both = [["status"], ["stop"]]
        await until(lambda: watching.words() == both, lambda: f"{watching.words()}")
        with listening("/", 9, watching=True):  # suspended, and in nobody's way
            assert (await typed("status")).code == 0
        with listening("/", 9):
            assert (await typed("status")).code == 3
    async with answering("/north") as north, answering("/south", 8, watching=True):
        assert (await typed("status")).code == 3  # another robot may be meant
        assert north.words() == []
    async with answering("/", watching=True):
        assert (await typed("status")).code == 0


async def test_the_refusal_of_one_that_watches_does_not_fail_a_stop() -> None:
    refusal = "watching only: start archo-tui without --watch to operate the robot"
    async with answering("/") as acting, answering("/", 8, watching=True) as watching:
        watching.answer("stop", "watching", refusal)
        assert [await asyncio.to_thread(stop) for stop in STOPS] == [0, 0]
        assert acting.words() == [["stop"]] * 2
        # Its answer is not waited for.
        await until(lambda: watching.words() == [["stop"]] * 2, lambda: f"{watching.words()}")
        acting.answer("stop", "timeout", "no answer")
        assert await asyncio.to_thread(stop_by_shell) == 1
    async with answering("/", 8, watching=True) as watching:
        watching.answer("stop", "watching", refusal)
        assert await asyncio.to_thread(stop_by_shell) == 1


async def test_where_a_console_only_watches_a_verb_on_ros2_acts_by_itself() -> None:
    graph = Graph()

    def verb(*words: str) -> int:
        return shell.run(words, (), graph.attach)

    async with answering("/", watching=True) as watching:
        for word in ("stop", "go"):
            watching.answer(word, "watching", "watching only")
        for words in (["stop"], ["go", "3"], ["status"]):
            assert await asyncio.to_thread(verb, *words) == 0, words
        assert graph.asked == [["stop"], ["go", "3"]]
        assert await asyncio.to_thread(verb, "go", "3", "--to", "7") == 1  # it is named
        assert len(graph.asked) == 2


async def test_two_consoles_of_one_number_are_told_apart_and_end_apart() -> None:
    async with answering("/north", 1) as north:
        async with answering("/south", 1) as south:
            both = await typed("status", "--to", "1")
            assert (both.code, "--to 1 fits several consoles" in both.err) == (3, True)
            name = south.hello["name"]
            assert f"--to {name}  pid 1: ARCHO /south" in both.err
            assert (await typed("status", "--to", name)).code == 0
            assert (await typed("stop", "--to", "1")).code == 0
        assert (await typed("status", "--to", "1")).code == 0
        assert north.words() == [["stop"], ["status"]]
        assert south.words() == [["status"], ["stop"]]


async def test_an_engine_and_a_domain_that_are_named_choose() -> None:
    async with answering("/a") as embedded, answering("/b", 8, engine="ros2", domain=5) as ros:
        for asked, at in (
            ({"engine": "ros2"}, [ros]),
            ({"engine": "ros2", "domain": 5}, [ros]),
            ({"engine": "embedded"}, [embedded]),
            ({"engine": "", "to": ""}, [embedded, ros]),
        ):
            before = [len(one.asked) for one in (embedded, ros)]
            ended = await asyncio.to_thread(find.stop, asked, print)
            assert [one.code for one in ended] == ["done"] * len(at)
            after = [len(one.asked) for one in (embedded, ros)]
            assert [
                one
                for one, was, now in zip((embedded, ros), before, after, strict=True)
                if now > was
            ] == at
        for asked in ({"engine": "ros2", "domain": 6}, {"engine": "embedded", "to": "/b"}):
            with pytest.raises(Unreached):
                await asyncio.to_thread(find.stop, asked, print)
            with pytest.raises(Unreached):
                await asyncio.to_thread(find.choose, asked)


async def test_a_variable_that_names_no_console_holds_up_no_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(find.CHOSEN, "4711")
    async with answering("/") as console:
        verb = await typed("status")
        assert (verb.code, "which ARCHO_TUI_CONSOLE names" in verb.err) == (3, True)
        stopped = await typed("stop")
        assert stopped.code == 0
        assert "no console 4711 runs here, which ARCHO_TUI_CONSOLE names: STOP went to all" in (
            stopped.err
        )
        assert (await typed("stop", "--to", "4711")).code == 3  # said, and not left behind
        assert console.words() == [["stop"]]


async def test_who_may_not_speak_to_a_console_is_told_who_may() -> None:
    folder = Path(sockets._TEMPORARY) / "archo-tui-4711"
    folder.mkdir()
    (folder / "7-0.sock").touch()
    told = await typed("stop")
    here = "a console of user 4711 runs here: run this as user 4711"
    assert (told.code, here in told.err) == (3, True)


# the console's own side


@contextmanager
def held() -> Iterator[None]:
    """The threads of a console's clients do nothing meanwhile."""
    go_on, run, line = threading.Event(), server.SocketClient.run, server.SocketClient.on_line

    def wait(client: server.SocketClient) -> None:
        go_on.wait(DEADLINE)
        run(client)

    def wait_with(client: server.SocketClient, data: bytes) -> None:
        go_on.wait(DEADLINE)
        line(client, data)

    with (
        patch.object(server.SocketClient, "run", wait),
        patch.object(server.SocketClient, "on_line", wait_with),
    ):
        try:
            yield
        finally:
            go_on.set()


STOP = b'{"id": 1, "words": ["stop"]}\n'
STATUS_LINE = b'{"id": 2, "words": ["status"]}\n'


SENT: list[list[bytes]] = [
    [STOP],
    [STATUS_LINE, STOP],  # the answer to the first has nobody to go to
    [STATUS_LINE * 3000, STOP],
    [b'{"words": ["st\\u006fp"]}\n'],
    [STOP[:-1]],
    [b"stop\n"],
    [b"STOP!"],
    [b'{"id": 1, "words": ["Stop;", "now"]}\n'],
    [b'{"id": 1, "words": "stop"}\n'],
    [b'{"id": {"a": []}, "words": ["stop", 1, null], "wait": [], "timeout": "x"}\n'],
    [b'{"id": 1, "words": ["", "stop"], "to": 0, "engine": [], "domain": null}\n'],
]


async def test_a_stop_of_a_client_that_has_gone_is_carried_out() -> None:
    async with served() as person:
        stops = person.station.robot.stops
        for number, sent in enumerate(SENT, 1):
            await typed("status")  # greeted: what comes is not the first
            with held():
                with reached() as gone:
                    for data in sent:
                        gone.send(data)
            await until(lambda n=number: stops.count == n, lambda sent=sent: repr(sent[0][:80]))  # type: ignore[misc]
        for _ in range(50):
            with reached() as gone:
                gone.send(STOP)
        await until(lambda: stops.count == len(SENT) + 50)
        await heard(person, "STOP: confirmed")


# processes


@contextmanager
def begun(*words: str) -> Iterator[Script]:
    with Script(*words, *SLOW, fresh=True) as script:  # it may be suspended
        script.ready()
        yield script


@pytest.fixture
def one_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes look nowhere else."""
    monkeypatch.setenv(sockets.FOLDER_VARIABLE, f"{sockets._TEMPORARY}/s")


@pytest.mark.usefixtures("one_folder")
def test_no_verb_is_guessed_and_a_stop_waits_for_one_that_sleeps() -> None:
    with begun("--namespace", "/north") as north, begun("--namespace", "/south") as south:
        south.signal(signal.SIGSTOP)
        go, listed = client("go", "3", "--wait"), client("consoles", "--json")
        _, err = go.communicate(timeout=DEADLINE)
        assert (go.returncode, "/south, does not answer: is it suspended?" in err) == (3, True)
        out, _ = listed.communicate(timeout=DEADLINE)
        rows = [json.loads(line) for line in out.splitlines()]
        assert [(row["namespace"], row["answers"]) for row in rows] == [
            ("/north", True),
            ("/south", False),
        ]
        assert listed.returncode == 3
        stop = client("stop")
        north.until("STOP: confirmed")
        assert stop.stderr is not None
        assert "/south, does not answer yet: STOP waits for it" in stop.stderr.readline()
        south.signal(signal.SIGCONT)
        south.until("STOP: confirmed")
        _, err = stop.communicate(timeout=DEADLINE)
        assert (stop.returncode, err.count(": confirmed")) == (0, 2)
        assert "goal MOVING" not in north.said


@pytest.mark.usefixtures("one_folder")
@pytest.mark.parametrize("killed", corners([signal.SIGKILL], [signal.SIGINT, signal.SIGTERM]))
def test_a_console_that_wakes_stops_though_whoever_said_so_was_killed(killed: int) -> None:
    with begun() as script:
        script.signal(signal.SIGSTOP)
        stop = client("stop")
        assert stop.stderr is not None
        assert "STOP waits for it" in stop.stderr.readline()
        stop.send_signal(killed)
        stop.communicate(timeout=DEADLINE)
        script.signal(signal.SIGCONT)
        script.until("STOP: confirmed")


async def test_a_name_that_another_console_has_is_not_taken() -> None:
    with listening("/") as (made, hello):
        (path,) = sockets.socket_paths()
        assert sockets.read_card(path) == hello
        with pytest.raises(FileExistsError):
            server.open_socket(hello)
        connected = reached(path)
        made.setblocking(True)
        made.accept()[0].close()
        connected.close()
