"""Programs that say what they should not, or leave when they should not: the console goes on."""

from __future__ import annotations

import asyncio
import json
import os
import re
import socket
import stat
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from archo_tui.client import connection, sockets
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import GONE
from archo_tui.console.socket import MAX_CLIENTS, MAX_CONNECTIONS
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.stop import sender
from tests.support.console import FAST, LONG
from tests.support.night import corners
from tests.support.plain import Typed, operated
from tests.support.shells import guest, heard, own_socket, raw, reached, served, typed, until
from tests.support.stand_in import Made, StandIn
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time


async def goes_on(person: Typed) -> None:
    """The console answers another program, and its own operator."""
    assert (await typed("status", "--line")).code == 0
    person.type("status\n")
    await heard(person, "battery ")
    assert not person.is_over


def _nested(depth: int) -> bytes:
    return b'{"id": ' + b"[" * depth + b"]" * depth + b', "words": ["status"]}\n'


NO_REQUESTS: list[Any] = [
    b"garbage\n",
    b"\xff\xfe\x00\n",
    b"[]\n",
    b"null\n",
    b"[" * 50_000 + b"\n",
    b'{"a":' * 10_000 + b"\n",
    b"{}\n",
    b"x" * 70_000 + b"\n",
    *(_nested(depth) for depth in (*range(900, 1000, 9), 5000)),
    {"words": "status"},
    {"words": []},
    {"words": [1]},
    {"words": [["status"]]},
    {"words": ["\ud800"]},
    {"words": ["wait", "idle"], "timeout": float("nan")},
    {"words": ["wait", "idle"], "timeout": 10**400},
    {"words": ["wait", "idle"], "timeout": True},
    {"words": ["wait", "idle"], "timeout": {}},
    {"words": ["status"], "id": [1]},
    {"words": ["status"], "id": 1.5},
    {"words": ["status"], "id": "x" * 5000},
    {"answer": True},
]


async def test_whatever_is_no_request_is_misuse_and_a_line_without_an_end_costs_nothing() -> None:
    async with served(ros_args=FAST) as person, guest() as one:
        for said in NO_REQUESTS:
            one.send(said)
            assert (await one.result())["code"] == "misuse", said
            assert (await one.ask("get", "motor_controller", "max_speed"))["code"] == "done"
        piece = b"x" * 2**20
        before = _memory()
        for _ in range(40):
            one.send(piece)
            await asyncio.wait_for(one.writer.drain(), 30)
            async with guest() as other:
                assert (await other.ask("status"))["code"] == "done"
        assert _memory() - before < 8 * 2**20
        assert (await one.result())["text"] == "a line of more than 64 kB"
        await goes_on(person)


def _memory() -> int:
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


async def test_one_that_never_reads_is_dropped_and_delays_nobody() -> None:
    async with served(ros_args=FAST) as person:
        deaf = await asyncio.to_thread(reached)
        request = json.dumps({"id": 1, "words": ["params"]}).encode() + b"\n"
        deaf.settimeout(0.0)

        def is_dropped() -> bool:
            try:
                deaf.send(request * 20)
            except BlockingIOError:
                return False
            except OSError:
                return True
            return False

        await until(is_dropped)
        deaf.close()
        await goes_on(person)


async def test_more_than_enough_clients_may_stop_and_nothing_else() -> None:
    async with served(ros_args=FAST) as person:
        ours = [await raw() for _ in range(MAX_CLIENTS)]
        for one in ours:
            await one.line()
        async with guest() as late:
            assert (await late.ask("status"))["text"] == (
                "16 clients are connected: only stop is taken"
            )
            assert (await late.ask("stop"))["code"] == "done"
            ours[0].close()
            while (said := await late.ask("status"))["code"] == "refused":
                assert "only stop" in said["text"]
            assert said["code"] == "done"  # a place is free
        for one in ours:
            one.close()
        while (await typed("status")).code:  # until they are seen to have gone
            pass
        await goes_on(person)


@pytest.mark.parametrize("count", corners([200], [10_000]))
async def test_thousands_of_connections_leave_a_way_for_stop_and_no_descriptors(count: int) -> None:
    async with served(ros_args=FAST) as person:
        held: list[socket.socket] = []
        files = len(os.listdir("/proc/self/fd"))
        for _ in range(count):
            held.append(await asyncio.to_thread(reached))
            if len(held) > 100:
                held.pop(0).close()
        async with guest() as late:
            assert (await late.ask("stop"))["code"] == "done"
        await until(lambda: len(os.listdir("/proc/self/fd")) < files + MAX_CONNECTIONS + 310)
        for one in held:
            one.close()
        await until(lambda: len(os.listdir("/proc/self/fd")) < files + 10)
        await goes_on(person)


@pytest.mark.parametrize(
    ("unanswered", "gives_up", "asked", "said"),
    [
        (1, False, 2, "CANCELLED"),
        (3, False, 3, "which has left, may still run: no answer to the cancel in 2 s"),
        # ROS rejects a second cancel while a goal winds down: the accepted one is the only one.
        (0, True, 1, "CANCELLED"),
    ],
)
async def test_a_cancel_for_one_that_has_left_is_repeated_until_answered_then_said(
    unanswered: int, gives_up: bool, asked: int, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with served(ros_args=LONG) as person, guest() as one:
        robot, cancels = person.station.robot, list[bool]()
        cancel = robot.cancel

        async def counted(*, another: bool = False) -> Outcome:
            cancels.append(another)
            if len(cancels) > unanswered:
                return await cancel(another=another)
            return Outcome(Code.TIMEOUT, "no answer to the cancel in 2 s")

        monkeypatch.setattr(robot, "cancel", counted)
        one.send({"id": 1, "words": ["go", "12"], "wait": True})
        assert (await one.line())["said"] == "accepted"
        if gives_up:
            one.send({"give_up": True})  # And again, as it leaves.
        one.close()
        await heard(person, said)
        assert (len(cancels), "may still run" in person.said) == (asked, "may" in said)


async def test_a_result_and_wait_arrived_tell_of_the_goal_of_the_same_program() -> None:
    async with served(ros_args=FAST), guest() as one, guest() as other:
        one.send({"id": 1, "words": ["go", "12"], "wait": True})
        assert (await one.line())["said"] == "accepted"
        other.send({"id": 1, "words": ["go", "7"], "wait": True})
        for program, shelf in ((one, 12), (other, 7)):
            data = (await program.result())["data"]
            assert (data["name"], data["code"]) == (f"shelf {shelf}", "arrived")
        for words, code in (
            ("go 12", "accepted"),
            ("wait idle", "done"),
            ("wait arrived", "arrived"),
        ):
            assert (await one.ask(*words.split()))["code"] == code
        one.send({"give_up": True})
        assert (await one.result())["text"] == "it had ended"


async def test_of_a_flood_all_stops_are_answered_and_other_surplus_is_refused() -> None:
    async with served(ros_args=FAST) as person, guest() as one, guest() as other:
        one.send(*({"id": n, "words": ["stop"]} for n in range(1000)))
        for number in range(1000):
            said = await one.result()
            assert (said["id"], said["code"]) == (number, "done")
        assert person.said.count("STOP: confirmed") < 20
        one.send(*({"id": n, "words": ["status"]} for n in range(10_000)))
        assert (await other.ask("stop"))["code"] == "done"
        assert (await other.ask("get", "motor_controller", "max_speed"))["code"] == "done"
        while (said := await one.result())["code"] == "done":
            assert said["id"] < 100
        assert said["text"] == "too many requests wait"
        await goes_on(person)


async def test_a_stop_does_not_wait_for_the_answer_to_anothers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sender, "DEADLINE", 60.0)  # on a busy machine 2 s are soon over
    brake = Made(StandIn, "brake", "nothing")
    async with served(brake), guest() as one, guest() as other:
        for number, guest_ in enumerate((one, other), 1):
            guest_.send({"id": 1, "words": ["stop"]})
            await until(lambda number=number: len(brake.node.stops) == number)  # type: ignore[misc]
        brake.node.wake()
        for guest_ in (one, other):
            assert (await guest_.result())["code"] == "done"


@pytest.mark.parametrize("fault", ["mode", "file"])
async def test_a_folder_that_others_can_use_has_no_socket_and_is_not_looked_into(
    fault: str,
) -> None:
    folder = Path(sockets.folder())
    folder.parent.mkdir(parents=True, exist_ok=True)
    if fault == "mode":
        folder.mkdir()
        folder.chmod(0o777)
    else:
        folder.write_text("")
    async with operated(ros_args=FAST, remote=True) as person:
        await heard(person, "no socket for other programs: ")
        assert not sockets.socket_paths()
    said = await typed("status")
    assert said.code == 3
    assert str(folder) in said.err


async def test_the_socket_is_this_users_alone_and_lives_as_long_as_it_listens(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    listen, seen = socket.socket.listen, []

    def watched(made: socket.socket, *given: int) -> None:
        # whoever looks now would take it for one of a killed console
        seen.append(sockets.socket_paths())
        listen(made, *given)

    monkeypatch.setattr(socket.socket, "listen", watched)
    async with served(ros_args=FAST) as person:
        assert seen[0] == []
        path = Path(own_socket())
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
        with monkeypatch.context() as patch:  # Another user's program.
            patch.setattr(
                "archo_tui.console.socket._pid_and_uid", lambda _: (4711, os.getuid() + 1)
            )
            one = await raw()
            one.send({"id": 1, "words": ["stop"]})
            assert await one.line() == {}  # It is not even greeted.
        assert "STOP" not in person.said
        await goes_on(person)
    assert not path.exists()


def _listens(name: str) -> socket.socket:
    """A console that takes connections, and no more."""
    folder = sockets.folder()
    os.makedirs(folder, 0o700, exist_ok=True)
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    made.bind(f"{folder}/{name}")
    made.listen()
    return made


WHOLE = {
    **{"protocol": 1, "pid": 1, "robot": "R", "namespace": "/north", "engine": "embedded"},
    "name": "1",
}


CARDS = [(name, value) for name in WHOLE for value in (None, ["x"]) if name != "protocol"]


@pytest.mark.parametrize(("lacks", "instead"), corners(CARDS[::4], CARDS))
async def test_a_console_whose_card_names_nothing_holds_up_no_stop(
    lacks: str, instead: Any
) -> None:
    card = {**WHOLE, lacks: instead} if instead else {k: WHOLE[k] for k in WHOLE if k != lacks}

    def greet(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(json.dumps(WHOLE).encode() + b"\n")
        writer.close()

    async with await asyncio.start_unix_server(greet, sock=_listens("1.sock")):
        Path(sockets.folder(), "1.json").write_text(json.dumps(card))
        for words in (["status"], ["stop", "--to", "/north"]):
            code, _, err = await typed(*words)
            assert code == 3
            assert ("not confirmed" if "stop" in words else "does not say which robot") in err
        async with served(ros_args=FAST) as person:
            stopped = await typed("stop")
            assert (stopped.code, "not confirmed" in stopped.err) == (3, True)
            await heard(person, "STOP: confirmed")
            assert (await typed("status")).code == 3  # it may be the one that is meant


@pytest.mark.parametrize(
    ("timeout", "error"),
    [(0.2, connection.UNANSWERED), (None, GONE)],
    ids=["until its time", "up to a length"],
)
def test_a_console_whose_line_never_ends_holds_up_no_verb_and_no_stop(
    timeout: float | None, error: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "_LONGEST_LINE", 10**9 if timeout else 10**6)
    ours, theirs = socket.socketpair()

    def flood() -> None:
        with theirs, suppress(OSError):
            while True:
                theirs.sendall(b"x" * 65536)

    flooding = threading.Thread(target=flood, daemon=True)
    flooding.start()
    with connection.Connection("", ours) as console, pytest.raises(Unreached, match=error):
        next(console.replies(timeout))
    flooding.join(DEADLINE)
    assert not flooding.is_alive()


@pytest.mark.parametrize("rest", ['"code": "done"', '"code": 7, "text": ""'])
def test_a_result_that_is_none_counts_as_an_end(rest: str) -> None:
    ours, theirs = socket.socketpair()
    with theirs, connection.Connection("", ours) as console:
        theirs.sendall(f'{{"id": 1, {rest}}}\n'.encode())
        with pytest.raises(Unreached, match=GONE):
            console.result(words=["status"])


@pytest.mark.parametrize("hello", [{"protocol": 2, "pid": 7}, {}, [], "hello"])
def test_another_protocol_is_said(hello: Any) -> None:
    ours, theirs = socket.socketpair()
    theirs.sendall(json.dumps(hello).encode() + b"\n")
    console = connection.Connection("7.sock")
    console.socket.close()
    console.socket = ours
    assert re.search(r"protocol|does not answer", console.fault(1.0))
    for one in (ours, theirs):
        one.close()


async def test_what_waits_of_one_that_left_is_not_carried_out_and_nobody_stays_connected() -> None:
    async with served(ros_args=LONG) as person:
        one = await raw()
        one.send(
            *(
                {"id": n, "words": ["set", "motor_controller", "max_speed", f"1.{n}"]}
                for n in range(9)
            )
        )
        await heard(person, "max_speed 1.0")
        one.close()
        station = person.station
        await until(lambda: not station.clients)
        for _ in range(20):
            await typed("status")
        assert "max_speed 1.8" not in person.said
        await until(lambda: not station.clients)
