"""What an assistant asks for through the socket, and the person who decides."""

from __future__ import annotations

import json
import math
import os
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random
from typing import Any

import pytest
from textual import events

from archo_tui.base.paths import journal_file
from archo_tui.console.printing import Output
from archo_tui.console.typing import Input
from archo_tui.screen.commands import request
from archo_tui.screen.keyed_app import HELD
from archo_tui.session.session import _robots_nodes
from archo_tui.station import approvals
from archo_tui.verbs.goals import Go
from tests.support.clock import seconds
from tests.support.console import AT_ONCE, FAST, LONG, Console, click, console
from tests.support.night import corners
from tests.support.peer import Peer
from tests.support.plain import Typed
from tests.support.robot import making
from tests.support.shells import Raw, guest, heard, own_socket, raw, served, until
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time

ROBOT = [*_robots_nodes(False).values()]
GO = {"kind": "go", "values": {"shelf_number": 12}}


@asynccontextmanager
async def beside(*args: str, **options: Any) -> AsyncIterator[tuple[Console, Raw]]:
    """A console, and an assistant that is connected to it."""
    async with console(*AT_ONCE, *args, remote=True, **options) as op:
        await op.until(own_socket)
        assistant = await raw()
        yield op, assistant
        assistant.close()


@asynccontextmanager
async def at_a_terminal(*args: str, **options: Any) -> AsyncIterator[tuple[Typed, Raw]]:
    """The same where a person reads and types lines."""
    async with served(at_terminal=True, ros_args=args, **options) as person:
        assistant = await raw()
        assert (await assistant.ask("wait", "ready"))["code"] == "done"
        yield person, assistant
        assistant.close()


async def shown(person: Typed, number: int = 1) -> None:
    """Wait until a request was printed for as long as a person needs to read it."""
    await heard(person, f"(allow {number} or deny {number}, within 60 s)")
    since = seconds()
    await until(lambda: seconds() > since + 1.1)


async def allows(person: Typed, number: int = 1) -> None:
    """A person allows it, once it was read."""
    await shown(person, number)
    person.type(f"allow {number}\n")


async def asks(assistant: Raw, wanted: Any = GO) -> dict[str, Any]:
    """What is said at once."""
    assistant.send({"id": 1, "assistant": True, "ask": wanted})
    return await assistant.result()


async def says(assistant: Raw, *words: str, **more: Any) -> dict[str, Any]:
    return await assistant.ask(*words, assistant=True, **more)


async def read(op: Console) -> None:
    """Let the time pass in which a person reads a request: it was drawn that long ago."""
    dialog = op.app.screen
    assert isinstance(dialog, request.AnswerRequest)
    await op.until(lambda: dialog._drawn_at < math.inf)
    dialog._drawn_at -= approvals.READING_TIME
    await op.at(seconds() + 0.4)  # A pause, as no paste has it.


async def opened(op: Console) -> None:
    """The request in its dialog, read."""
    await op.press("A")
    await op.until("An assistant asks")
    await read(op)


async def allowed(op: Console) -> None:
    await opened(op)
    await op.press("tab")
    await op.at(seconds() + 0.4)
    await op.press("enter")


async def test_a_goal_is_driven_only_after_a_person_has_allowed_it() -> None:
    async with beside(*FAST) as (op, assistant):
        said = await asks(assistant)
        assert (said["code"], said["data"]["request"]) == ("asked", 1)
        await op.until("(A answer, ")
        assert f"assistant {os.getpid()} asks: go to shelf 12   (A answer, " in op.text
        assert " assistant " in op.text.splitlines()[0]
        waits = await says(assistant, "wait", "request", "1", timeout=0.01)
        assert waits["code"] == "ran_out"
        assert waits["text"].startswith("request 1 still waits for a person, ")
        assert op.app.view.snapshot.goal is None
        await allowed(op)
        ended = await says(assistant, "wait", "request", "1", timeout=50)
        assert (ended["code"], ended["data"]["values"]) == ("arrived", {"shelf_number": 12})
        await op.until("Arrived at shelf 12")
        line = " ".join(op.line("go to shelf 12: accepted").split())
        assert f"assistant {os.getpid()}: " in line
    told = [json.loads(line) for line in journal_file().read_text().splitlines()]
    texts = [entry["text"] for entry in told if entry["kind"] == "command"]
    assert "asks: go to shelf 12 (request 1)" in texts
    assert f"allowed request 1 of assistant {os.getpid()}: go to shelf 12" in texts


async def test_denied_it_is_not_driven_and_the_assistant_is_told() -> None:
    async with beside(*FAST) as (op, assistant):
        await asks(assistant)
        await opened(op)
        await op.press("enter")
        await op.at(seconds() + 0.4)
        said = await says(assistant, "wait", "request", "1")
        assert (said["code"], said["text"]) == ("denied", "request 1 is denied")
        assert op.app.view.snapshot.goal is None


def waiting(person: Console | Typed) -> list[int]:
    """The numbers of the requests that nobody has answered."""
    station = person.session.station if isinstance(person, Console) else person.station
    return [request.number for request in station.approvals.waiting]


async def is_unread(op: Console) -> None:
    """What was typed answered nothing, and that is said."""
    await op.until("Read it first, then answer.")
    assert waiting(op) == [1]
    op.app.clear_notifications()


def busy(op: Console, span: float) -> None:
    """Have the console do nothing else for so long (s), once it has taken what was typed before."""
    op.app.call_later(lambda: time.sleep(span))


async def test_what_was_not_read_is_answered_by_no_key_paste_or_click(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with beside(*LONG) as (op, assistant):
        await op.press("5")
        await asks(assistant)
        await op.until("asks: go to shelf 12")
        assert op.focused_panel == 5
        await op.press("y", "enter", "escape", "a", "n", "space")
        await op.press("A", "tab", "enter")  # sooner than anybody has read it
        await is_unread(op)
        await read(op)
        op.send("left", "right", "enter")  # as from a paste: all at once
        await op.settle()
        op.app.post_message(events.Paste("\t\r"))
        await op.settle()
        await is_unread(op)
        op.send("tab")
        busy(op, 0.5)
        op.send("enter")  # read at the same time, and taken later
        await is_unread(op)
        await op.press("escape")
        await op.at(seconds() + HELD)
        since = seconds()
        await op.press("A")
        await op.until("An assistant asks")
        op.send("tab")
        await op.at(seconds() + 0.4)
        busy(op, 1.0)
        op.send("enter")  # too soon, however late it is taken
        with monkeypatch.context() as patch:  # also where all of it took longer
            patch.setattr(request, "READING_TIME", seconds() - since)
            await is_unread(op)
        await op.press("escape")
        await op.at(seconds() + HELD)
        await op.press("A")
        await op.until("An assistant asks")
        button = op.app.screen.query_one("#allow")
        click(op.app, button.region.x + 2, button.region.y)
        await is_unread(op)
        assert op.app.view.snapshot.goal is None
        await read(op)
        click(op.app, button.region.x + 2, button.region.y)
        await op.until("MOVING to 12")


async def is_read_anew(op: Console, monkeypatch: pytest.MonkeyPatch, since: float) -> None:
    """What was drawn after that time is answered by the second enter, a second later."""
    with monkeypatch.context() as patch:
        patch.setattr(request, "READING_TIME", seconds() - since)
        await op.press("enter")
        await op.until("Read it first, then answer.")
    await read(op)
    await op.at(seconds() + HELD)
    await op.press("enter")
    await op.until("MOVING to 12")


@pytest.mark.parametrize("way", corners(["covered"], ["resized", "suspended"]))
async def test_what_was_away_is_read_anew(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    async with beside(*LONG) as (op, assistant):
        await asks(assistant)
        await opened(op)
        since = seconds()
        await op.press("tab")
        if way == "covered":
            await op.press("f1")
            await op.until("┏━ Keys ━")
            await op.press("f1")
        elif way == "resized":
            await op.pilot.resize_terminal(100, 30)
        else:
            op.app.app_resume_signal.publish(op.app)
        await op.until("An assistant asks")
        await op.at(seconds() + 0.4)
        await is_read_anew(op, monkeypatch, since)


async def test_what_the_terminal_does_not_show_is_read_once_it_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with beside(*LONG) as (op, assistant):
        await asks(assistant)
        monkeypatch.setattr(type(op.app), "is_stuck", True)
        await opened(op)
        since = seconds()
        await op.press("tab")
        await op.at(seconds() + 0.4)
        await op.press("enter")
        await op.until("Read it first, then answer.")
        await op.at(seconds() + HELD)
        op.app.tick()
        monkeypatch.setattr(type(op.app), "is_stuck", False)
        op.app.clear_notifications()
        await is_read_anew(op, monkeypatch, since)


@pytest.mark.parametrize("size", corners([(20, 4)], [(30, 6), (40, 10)]))
async def test_what_is_not_all_in_view_is_allowed_only_once_it_was_scrolled(
    size: tuple[int, int],
) -> None:
    async with beside(*LONG) as (op, assistant):
        await asks(assistant)
        await op.press("A")
        await op.until("An assistant asks")
        await op.pilot.resize_terminal(*size)
        await op.press("tab")
        await read(op)
        await op.press("enter")
        await op.until("▲ Not all of it")
        assert waiting(op) == [1]
        op.app.clear_notifications()
        await op.pilot.resize_terminal(40, 10)
        await op.until("Allow once")
        assert "expires in" not in op.text
        await op.press("down", "down")
        await op.until("expires in")
        await read(op)
        await op.press("enter")
        await op.until(lambda: op.app.view.snapshot.running_goal is not None)


@pytest.mark.parametrize("way", ["stop", "goal", "time", "gone"])
async def test_a_request_is_void_once_it_may_mean_something_else(
    way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with at_a_terminal(*LONG) as (person, assistant), guest() as other:
        await asks(assistant)
        if way == "stop":
            assert (await other.ask("stop"))["code"] == "done"
        elif way == "goal":
            assert (await other.ask("go", "3"))["code"] == "accepted"
        elif way == "time":
            monkeypatch.setattr(approvals, "LIFETIME", 0.0)
        else:
            assistant.close()
        await until(lambda: not waiting(person))
        refused = person.station.approvals.answer(1, allowed=True)
        assert refused.text.startswith("request 1 is ")
        if way != "gone":
            said = await says(assistant, "wait", "request", "1")
            assert said["code"] == ("expired" if way == "time" else "void")
        snapshot = person.station.robot.snapshot
        goals = [*snapshot.history, snapshot.goal]
        assert all(goal is None or goal.target == "3" for goal in goals)


async def test_a_stop_of_another_console_voids_though_it_was_released_at_once() -> None:
    made: list[Peer] = []
    async with beside(*LONG, node_makers=[*ROBOT, making(made, Peer)]) as (op, assistant):
        await op.until("2 consoles")
        await asks(assistant)
        made[0].tell("stop")
        made[0].tell("release")
        said = await says(assistant, "wait", "request", "1", timeout=10)
        assert (said["code"], said["text"]) == ("void", "request 1 is void: a STOP came")
        await asks(assistant)
        made[0].tell("release")
        await op.until("release: done")
        assert waiting(op) == [2]


async def test_an_answer_to_a_request_that_is_over_acts_nowhere_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # On a busy machine, too, it is soon.
    monkeypatch.setattr("archo_tui.screen.keyed_app.HELD", DEADLINE)
    async with beside(*LONG) as (op, assistant):
        await op.press("g", "7")
        await asks(assistant)
        op.app.action_command("alarms")  # as a click on the request does: the field has the focus
        await op.until("An assistant asks")
        monkeypatch.setattr(approvals, "LIFETIME", 0.0)
        await op.until(lambda: "An assistant asks" not in op.text)
        await op.press("enter")  # for the answer
        await op.until("The request is over: press the key again.")
        assert op.app.view.snapshot.goal is None


async def test_a_no_is_followed_by_a_pause_and_hides_no_alarm() -> None:
    low = ("-p", "low_battery_threshold:=90.0")
    async with beside(*FAST, *low) as (op, assistant):
        await op.until("LOW BATTERY")
        await asks(assistant)
        await op.until("▲ low battery")
        await opened(op)
        await op.press("enter")
        refused = await asks(assistant)
        assert refused["text"].startswith("a person has just said no: wait ")
        await op.until("LOW BATTERY")


async def test_each_request_tells_of_its_own_goal_and_once_allowed_is_once() -> None:
    async with at_a_terminal(*FAST) as (person, assistant):
        for number, shelf in ((1, 5), (2, 6)):
            await asks(assistant, {"kind": "go", "values": {"shelf_number": shelf}})
            await allows(person, number)
            told = await says(assistant, "wait", "request", str(number), timeout=DEADLINE)
            assert told["code"] == "arrived"
        for number, shelf in ((1, 5), (2, 6)):
            told = await says(assistant, "wait", "request", str(number))
            assert told["data"]["values"] == {"shelf_number": shelf}
        again = person.station.approvals.answer(1, allowed=True)
        assert again.text == "request 1 is allowed"
        assert len(person.station.robot.snapshot.history) == 2


async def test_at_most_three_wait_and_the_oldest_is_asked_first() -> None:
    async with beside(*FAST) as (op, assistant):
        for shelf in (1, 2, 3):
            said = await asks(assistant, {"kind": "go", "values": {"shelf_number": shelf}})
            assert said["code"] == "asked"
        assert (await asks(assistant))["text"] == "3 requests wait for a person already"
        await op.until("asks: go to shelf 1 ")
        await op.until("+2 requests")


async def test_it_cancels_its_own_goals_only_and_the_last_by_leaving() -> None:
    async with at_a_terminal(*LONG) as (person, assistant):
        person.type("go 3\n")
        await heard(person, "MOVING to 3")
        refused = await says(assistant, "cancel")
        assert refused["code"] == "refused"
        assert "no goal of this assistant runs" in refused["text"]
        assert (await asks(assistant))["text"].startswith("another goal runs")
        person.type("cancel\n")
        await heard(person, "CANCELLED")
        await until(lambda: person.station.robot.snapshot.running_goal is None)
        await asks(assistant)
        await allows(person)
        await heard(person, "MOVING to 12")
        assert (await says(assistant, "cancel"))["code"] == "accepted"
        ended = await says(assistant, "wait", "request", "1")
        assert ended["code"] == "cancelled"
        await asks(assistant)
        await allows(person, 2)
        await until(lambda: person.said.count("MOVING to 12") == 2)
        assistant.close()
        await until(lambda: person.said.count("goal CANCELLED") == 3)


async def test_limits_hold_that_come_before_the_answer_and_are_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with at_a_terminal(*LONG) as (person, assistant), guest() as other:
        robot = person.station.robot
        await until(lambda: robot.snapshot.parameter("shelf_count"))
        count = "set", "motor_controller", "shelf_count"
        await asks(assistant)
        assert (await other.ask(*count, "10"))["code"] == "done"
        await allows(person)
        await heard(person, "Shelf: at most 10, not 12")
        assert (await other.ask(*count, "40"))["code"] == "done"
        known = threading.Event()
        monkeypatch.setattr(Go, "is_found", lambda *_: known.is_set())  # not reported yet
        assistant.send({"id": 1, "assistant": True, "ask": GO})
        assert (await other.ask(*count, "10"))["code"] == "done"
        known.set()
        assert (await assistant.result())["text"] == "Shelf: at most 10, not 12"
        assert (robot.snapshot.goal, robot.snapshot.history) == (None, ())


async def test_of_a_stopped_robot_nothing_is_asked_and_its_stop_is_its_own() -> None:
    async with at_a_terminal(*FAST) as (person, assistant):
        assert (await says(assistant, "status"))["code"] == "done"
        assert (await says(assistant, "stop"))["code"] == "done"
        await heard(person, f"assistant {os.getpid()}: STOP: confirmed")
        await until(lambda: person.station.robot.snapshot.is_stopped)
        said = await asks(assistant)
        assert said["text"] == "the robot is stopped: a person has to release it first"


async def test_nobody_is_asked_who_only_watches() -> None:
    async with beside(*FAST, watch=True) as (_, assistant):
        said = await asks(assistant)
        assert said["code"] == "refused"
        assert said["text"].startswith("watching only")


OTHERS = [
    ["go", "12"],
    ["release", "--yes"],
    ["set", "motor_controller", "max_speed", "1"],
    ["charge"],
    ["allow", "1"],
    ["call", "/reset_encoder"],
    ["continue"],
    ["cancel", "--all"],
    ["save", "x"],
    ["halt", "motor_controller"],
    ["status", "--yes"],
]
MISUSED = [
    (None, "kind: the goals of this robot are go"),
    ({"kind": "fly"}, "kind: the goals of this robot are go"),
    ({"kind": "go"}, "values: expected an object, by name"),
    ({"kind": "go", "values": {}}, "Shelf: type a value"),
    ({"kind": "go", "values": {"place": 1}}, "expected shelf=..., not place=1"),
    ({"kind": "go", "values": {"shelf_number": 1, "Shelf": 2}}, "not Shelf=2"),
    ({"kind": "go", "values": {"shelf_number": [1]}}, "not a whole number: [1]"),
    ({"kind": "go", "values": {"shelf_number": None}}, "not a whole number"),
    ({"kind": "go", "values": {"shelf_number": 1.5}}, "Shelf: not a whole number: 1.5"),
    ({"kind": "go", "values": {"shelf_number": True}}, "Shelf: not a whole number"),
    ({"kind": "go", "values": {"shelf_number": 99}}, "Shelf: at most 40, not 99"),
    ({"kind": "go", "values": {"shelf_number": 0}}, "Shelf: at least 1, not 0"),
]
WORDS = [
    *(["go", "12"], ["cancel"], ["status"], ["release", "--yes"], ["continue"], ["goals"]),
    *(["wait", "request", "1"], ["allow", "1"], ["yes"], ["set", "a", "b", "c"], ["events"]),
]
VALUES: list[Any] = [12, 1.5, "12", None, True, [], {}, -1, 40, "y", 10**400]


async def test_without_a_yes_nothing_moves_whatever_is_said(request: pytest.FixtureRequest) -> None:
    async with at_a_terminal(*FAST) as (person, assistant):
        await until(lambda: person.station.robot.snapshot.parameter("shelf_count"))
        for wanted, why in MISUSED:
            said = await asks(assistant, wanted)
            assert (said["code"], why in said["text"]) == ("misuse", True), said
            assert waiting(person) == []  # nobody is asked
        (goal,) = (await says(assistant, "goals"))["data"]
        about = {"type": "int32", "label": "Shelf", "low": 1, "high": 40}
        assert (goal["kind"], goal["values"]) == ("go", {"shelf_number": about})
        await asks(assistant)
        for words in OTHERS:
            for said in (await says(assistant, *words), await assistant.ask(*words)):
                # what was an assistant once is one to its end
                assert said["code"] in ("refused", "misuse"), words
        assert waiting(person) == [1]
        said = await says(assistant, "cancel")
        assert (said["code"], said["text"]) == ("done", "withdrawn: go to shelf 12")
        assert person.station.approvals.answer(1, allowed=True).text == "request 1 is void"
        choose = Random(11)
        for _ in range(10_000 if request.config.getoption("--night") else 100):
            if choose.random() < 0.5:
                kind, value = choose.choice(["go", "fly", None]), choose.choice(VALUES)
                await asks(assistant, {"kind": kind, "values": {"shelf_number": value}})
            else:
                await says(assistant, *choose.choice(WORDS), timeout=0.001)
        snapshot = person.station.robot.snapshot
        assert (snapshot.goal, snapshot.history) == (None, ())


UNREAD = "failed: allow: read the request first, then answer it in a line of its own"


async def test_in_plain_a_person_at_the_terminal_answers() -> None:
    async with at_a_terminal(*FAST) as (person, assistant):
        await asks(assistant)
        await heard(person, "wants: go to shelf 12 (allow 1 or deny 1, within 60 s)")
        person.type("deny 1\n")
        await heard(person, "read the request first")
        await shown(person)
        person.type("status\nallow 1\n")  # as a paste comes
        await until(lambda: person.said.count("read the request first") == 2)
        since = seconds()
        await until(lambda: seconds() > since + 0.5)
        person.type("allow 1\n")
        await heard(person, "Arrived at shelf 12")


async def test_where_a_program_types_nobody_can_allow_anything() -> None:
    async with served() as person:
        assistant = await raw()
        assert (await assistant.ask("wait", "ready"))["code"] == "done"
        said = await asks(assistant)
        assert (said["code"], said["text"]) == (
            "refused",
            "nobody can allow it: this console has no screen and no terminal",
        )
        person.type("allow 1\n")
        await heard(person, "only a person at a terminal answers an assistant")
        assistant.close()


@pytest.mark.parametrize("behind", ["status", "stop"])
async def test_in_plain_what_stands_behind_an_answer_is_read_first(
    behind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    reads, goes_on = Input._read_chunk, threading.Event()

    def chunk(of: Input) -> bytes:
        goes_on.wait()
        return reads(of)

    async with at_a_terminal() as (person, assistant):
        await asks(assistant)
        await shown(person)
        since = seconds()
        monkeypatch.setattr(Input, "_read_chunk", chunk)  # from the next on: a terminal gives lines
        person.type(f"allow 1\n{behind}\n")
        await until(lambda: person._plain._input.last_line_timing[0] > since)
        await until(lambda: not person._plain._input._waiting)
        goes_on.set()
        await heard(person, UNREAD)
        assert "accepted" not in person.said


async def test_in_plain_nothing_is_answered_that_the_terminal_has_not_taken_yet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with at_a_terminal() as (person, assistant):
        await asks(assistant)
        await shown(person)
        with monkeypatch.context() as patch:
            patch.setattr(Output, "is_done", False)  # as after ctrl+s
            person.type("allow 1\n")
            await heard(person, UNREAD)
        assert "accepted" not in person.said
