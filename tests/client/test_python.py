"""`archo_tui.connect()`: every method, the error that each end is, and what is given up."""

from __future__ import annotations

import asyncio
import json
import os
import pydoc
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import Node

import archo_tui
from archo_tui import Aborted, Cancelled, Misused, NotDone, RanOut, Refused, Unconfirmed, Unreached
from archo_tui.base.errors import ArchoError
from archo_tui.client.connection import Connection
from archo_tui.client.errors import data_or_raise
from archo_tui.client.robot import GoalHandle, Robot
from archo_tui.console import session
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from tests.support import chosen, warm
from tests.support.console import FAST, LONG
from tests.support.plain import Typed
from tests.support.script import SLOW, Script
from tests.support.shells import heard, served, typed, until
from tests.support.waiting import DEADLINE

REPORTING = ("-p", "feedback_period:=0.05")


async def does(work: Callable[[Robot], Any]) -> Any:
    """What a program gets from a robot of its own connection."""

    def run() -> Any:
        with archo_tui.connect() as robot:
            return work(robot)

    return await asyncio.to_thread(run)


@pytest.mark.real_time
async def test_the_state_is_typed_and_measured_and_events_come_until_their_time() -> None:
    async with served(ros_args=FAST):
        status = await does(lambda robot: robot.status())
        assert status.robot == "ARCHO"
        assert 0 < status.battery.percentage <= 100
        assert (status.battery.source, status.motion.word) == ("measured", "IDLE")
        assert (status.goal, status.alarms, status.queue.waiting) == (None, [], [])
        goal = await does(lambda robot: robot.go(12, 7).wait())
        assert (goal.name, goal.code, goal.values) == ("shelf 7", "arrived", {"shelf_number": 7})
        assert (await does(lambda robot: robot.status())).goal.code == "arrived"

        def listened(robot: Robot) -> list[str]:
            events = robot.events(timeout=1.5)
            robot.go(12).wait()
            return [event["text"] for event in events]

        # They end with their time, and none behind the call is lacking.
        assert "Arrived at shelf 12" in await does(listened)


class Named(Node):
    """Has a list of texts."""

    def __init__(self, **given: Any) -> None:
        super().__init__("named", **given)
        self.declare_parameter("names", ["one"])
        self.declare_parameter("speed", 0.8)


@pytest.mark.real_time
async def test_parameters_are_set_and_read_in_their_types() -> None:
    names = ["\N{ROBOT FACE}", "caf\N{LATIN SMALL LETTER E WITH ACUTE}"]

    def change(robot: Robot) -> Any:
        robot.set("named", "names", names)
        robot.set("speed", 0.5)  # of the only node that has it
        return robot.get("named", "names"), robot.get("speed", timeout=DEADLINE)

    async with served(Named):
        assert await does(change) == (names, 0.5)


NOT_DONE: list[tuple[Callable[[Any], Any], type[NotDone], str]] = [
    (lambda robot: robot.go(99), Refused, "shelf 99 is not in 1 .. 40"),
    (lambda robot: robot.go("there"), Misused, "there"),
    (lambda robot: robot.go(b"5"), Misused, "b'5': .* bytes"),
    (lambda robot: robot.go(5, kind="stop"), Misused, "use robot.stop()"),
    (lambda robot: robot.go(5, kind="Stop!"), Misused, "use robot.stop()"),
    (lambda robot: robot.go(kind="status"), Misused, "it sends no goals"),
    (lambda robot: robot.go(12, timeout="30 s"), Misused, "not a time in s: 30 s"),
    (lambda robot: robot.do("release"), Misused, "nothing to release|add --yes|no stop"),
    (lambda robot: robot.wait("battery", 100, timeout=0), RanOut, "not yet"),
    (lambda robot: robot.wait("idle", timeout=float("nan")), Misused, "not a time in s"),
    (lambda robot: archo_tui.connect("1"), Unreached, "no console 1"),
]


@pytest.mark.real_time
async def test_each_end_is_an_error_of_its_own(unlimited: Path) -> None:
    async with served(robot=unlimited, ros_args=FAST) as person:
        for work, error, said in NOT_DONE:
            if said.startswith("nothing to release"):
                await does(lambda robot: robot.stop())
            with pytest.raises(error, match=said) as raised:
                await does(work)
            assert isinstance(raised.value, ArchoError)
            assert error.__name__ in archo_tui.__all__
        assert "goal MOVING" not in person.said


@asynccontextmanager
async def driving(*args: Any, **given: Any) -> AsyncIterator[tuple[Typed, Robot, Any]]:
    """A console, its robot in Python, and a goal with a long way."""
    async with served(ros_args=(*LONG, *REPORTING)) as person:
        robot = await asyncio.to_thread(archo_tui.connect)
        goal = await asyncio.to_thread(lambda: robot.go(*(args or (12,)), **given))
        yield person, robot, goal
        await asyncio.to_thread(robot.close)


def left(goal: Any) -> float:
    """Return the metres left of what the robot has reported; infinite where it has not."""
    state = goal.feedback()
    return float("inf") if state is None or state.remaining is None else float(state.remaining)


@pytest.mark.real_time
async def test_a_handle_reports_waits_and_cancels() -> None:
    async with driving(12, 7) as (person, robot, goal):
        await until(lambda: left(goal) < 1000.0)
        first = goal.feedback()
        assert (first.name, first.code, first.mine) == ("shelf 12", None, True)
        await until(lambda: 0.0 < left(goal) < first.remaining)
        with pytest.raises(RanOut, match="the goal still runs"):
            await asyncio.to_thread(goal.wait, 0.01)
        with pytest.raises(Misused):
            await asyncio.to_thread(goal.wait, -1)
        assert not goal.done()
        status: Any = await asyncio.to_thread(robot.status)
        assert (status.goal.code, status.queue.waiting) == (None, ["7"])
        await asyncio.to_thread(goal.cancel)
        assert goal.done()
        with pytest.raises(Cancelled):
            goal.wait()
        await asyncio.to_thread(goal.cancel)  # once more changes nothing
        await heard(person, "CANCELLED")
        assert (await asyncio.to_thread(robot.status)).queue.waiting == []


@pytest.mark.real_time
async def test_a_goal_that_ends_otherwise_raises() -> None:
    async with driving() as (_, robot, goal):
        await typed("cancel")
        with pytest.raises(Cancelled, match="Cancelled mid-route"):
            await asyncio.to_thread(goal.wait)
        goal = await asyncio.to_thread(robot.go, 5)
        await asyncio.to_thread(robot.stop, "a person is in the way", at=3)
        with pytest.raises(Aborted):
            await asyncio.to_thread(goal.wait)
        with pytest.raises(Refused):
            await asyncio.to_thread(robot.go, 5)


@pytest.mark.real_time
@pytest.mark.pure
@pytest.mark.parametrize(
    ("code", "error"),
    [
        *((code, Unconfirmed) for code in (Code.TIMEOUT, Code.NOT_CONFIRMED)),
        *((code, Refused) for code in (Code.REFUSED, Code.NOT_OFFERED, Code.WATCHING)),
    ],
)
def test_only_what_was_surely_not_done_counts_as_refused(code: Code, error: type[NotDone]) -> None:
    with pytest.raises(error):
        data_or_raise({"code": code.value, "text": ""})


@pytest.mark.real_time
def test_a_cancel_of_a_goal_that_is_lost_says_that_the_robot_may_move() -> None:
    replies = [{"said": "accepted"}, {"code": "timeout", "text": "goal lost"}]
    console: Any = SimpleNamespace(close=lambda: None, give_up=lambda: None)
    with pytest.raises(Unconfirmed, match="goal lost"):
        GoalHandle(console, iter(replies)).cancel()


@pytest.mark.real_time
def test_a_goal_that_ends_at_once_is_accepted_all_the_same() -> None:
    replies = [{"said": "go to shelf 12: accepted"}, {"code": "aborted", "text": "it slipped"}]
    console: Any = SimpleNamespace(close=lambda: None)
    handle = GoalHandle(console, iter(replies))
    assert handle._has_ended.wait(DEADLINE)
    with pytest.raises(Aborted, match="it slipped"):
        handle.wait()


@pytest.mark.real_time
async def test_of_a_robot_that_brakes_for_long_the_time_is_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(session, "_CALL_OFF_TIMEOUT", 0.5)
    async with served(ros_args=("-p", "feedback_period:=5.0")):
        await typed("wait", "ready")
        with pytest.raises(RanOut, match="not within 1 s; what was sent may still be done"):
            await does(lambda robot: robot.go(12, timeout=1.0).wait())


@pytest.mark.real_time
async def test_leaving_cancels_what_still_runs_and_what_is_called_then_is_refused() -> None:
    async with driving() as (person, robot, goal):
        events = await asyncio.to_thread(robot.events)
        await asyncio.to_thread(robot.close)
        assert goal.done()
        await heard(person, "CANCELLED")
        with pytest.raises(NotDone):
            await asyncio.to_thread(list, events)
        with pytest.raises(Misused, match="connect"):
            await asyncio.to_thread(robot.status)
        await asyncio.to_thread(robot.stop)
        await heard(person, "STOP: confirmed")


@pytest.mark.real_time
async def test_leaving_waits_for_the_cancel_of_a_goal_that_is_not_answered_yet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served(ros_args=LONG) as person:
        await typed("wait", "ready")
        send, is_sent, go_on = person.station.robot.send, asyncio.Event(), asyncio.Event()

        async def slow(*given: Any, **more: Any) -> Any:
            is_sent.set()
            await go_on.wait()
            return await send(*given, **more)

        monkeypatch.setattr(person.station.robot, "send", slow)
        robot = await asyncio.to_thread(archo_tui.connect)
        going = asyncio.ensure_future(asyncio.to_thread(robot.go, 12))
        await is_sent.wait()
        closing = asyncio.ensure_future(asyncio.to_thread(robot.close))
        await until(lambda: robot._is_closed)
        go_on.set()
        await closing
        goal = person.station.robot.snapshot.goal
        assert goal is not None
        assert goal.phase is Phase.CANCELLED
        with pytest.raises(Cancelled):
            (await going).wait()


@pytest.mark.real_time
async def test_a_signal_handler_may_close_the_robot_in_the_middle_of_go(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served(ros_args=LONG):
        await typed("wait", "ready")
        robot = await asyncio.to_thread(archo_tui.connect)
        request = Connection.request

        def interrupted(*given: Any, **fields: Any) -> Any:
            replies = request(*given, **fields)
            robot.close()  # On the same thread, as a handler runs.
            return replies

        monkeypatch.setattr(Connection, "request", interrupted)
        with pytest.raises(Unreached):
            await asyncio.to_thread(robot.go, 12)
        await typed("wait", "idle")


# ctrl+c and threads


@pytest.mark.real_time
async def test_calls_of_many_threads_and_within_a_loop_over_events_are_answered() -> None:
    async with driving() as (_, robot, goal):

        def within() -> list[str]:
            found = []
            for event in robot.events(timeout=DEADLINE):
                found.append(event["text"])
                assert robot.status().goal is not None
                if "log" in event["text"]:
                    break
            return found

        looping = asyncio.ensure_future(asyncio.to_thread(within))
        waiting = asyncio.ensure_future(asyncio.to_thread(goal.wait))
        many = [asyncio.to_thread(robot.get, "motor_controller", "max_speed") for _ in range(8)]
        assert set(await asyncio.gather(*many)) == {0.8}
        while not looping.done():
            await asyncio.to_thread(robot.do, "log_level", "motor_controller", "debug")
            await asyncio.to_thread(robot.do, "log_level", "motor_controller", "unset")
        assert await looping
        await asyncio.to_thread(robot.stop)
        with pytest.raises(Aborted):
            await waiting
        assert len(robot._handles) == 1


REPL = """
import json, signal, sys, threading, archo_tui
from archo_tui.client import connection, find
connection._SILENCE = find.WAKE_TIMEOUT = 1.0
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background ignores it
robot = archo_tui.connect()
for line in sys.stdin:
    try:
        told = repr(eval(line))
    except BaseException as error:
        sys.last_value = error  # as the REPL does, with all that its frames hold
        told = f"{type(error).__name__}: {error}"
    print(json.dumps(told), flush=True)
"""


@contextmanager
def beside_console(code: str, *, fresh: bool = False) -> Iterator[tuple[Script, Any]]:
    """A console in a process of its own, and beside it Python that runs the code."""
    with Script(*SLOW, fresh=fresh) as script:
        script.ready()
        python = subprocess.Popen(
            warm.python("-c", code), stdin=-1, stdout=-1, text=True, env=os.environ | {}
        )
        try:
            yield script, python
        finally:
            python.kill()
            python.communicate()


@pytest.mark.real_time
def test_in_a_real_interpreter_ctrl_c_and_a_suspended_console_end_each_call() -> None:
    with beside_console(REPL, fresh=True) as (script, python):

        def enter(line: str) -> None:
            python.stdin.write(f"{line}\n")
            python.stdin.flush()

        def told() -> str:
            return str(json.loads(python.stdout.readline()))

        for call in ("robot.go(12).wait()", "robot.do('go', '12', wait=True)"):
            seen = script.said.count("goal CANCELLED")
            moved = script.said.count("goal MOVING to 12")
            enter(call)
            script.until("goal MOVING to 12", moved + 1)
            python.send_signal(signal.SIGINT)
            assert told().startswith("KeyboardInterrupt")
            script.until("goal CANCELLED", seen + 1)
            enter("robot.cancel()")
            assert told() == "Refused: no goal is running"
        script.signal(signal.SIGSTOP)
        for call in ("robot.status()", "archo_tui.connect()"):
            enter(call)
            assert "does not answer: is it suspended?" in told()
        for call in ("archo_tui.stop()", "robot.stop()"):
            enter(call)
            silent = "not confirmed: the robot may be moving; the console does not answer"
            assert silent in told()
        script.signal(signal.SIGCONT)
        script.until("STOP: confirmed")


# a worker of a program, as multiprocessing makes it: it lives on when the program is killed
FORKS = """
import os, sys, time
import archo_tui
def told(call):
    try:
        return call()
    except archo_tui.NotDone as error:
        return type(error).__name__
with archo_tui.connect() as robot:
    goal = robot.go(12)
    if not os.fork():
        with robot:
            said = told(lambda: goal.wait(9)), told(goal.cancel), robot.status().goal.name
            os.write(1, f"{' '.join(said)}\\n".encode())
        sys.stdin.read()
        os._exit(0)
    os.write(1, b"forked\\n")
    time.sleep(600)
"""
FORKS_WITHOUT_ITS_ROBOT = """
import os, sys, time
import archo_tui
goal = archo_tui.connect().go(12)
if not os.fork():
    try:
        goal.wait(9)
    except archo_tui.Unreached:
        os.write(1, b"Unreached\\n")
    sys.stdin.read()
    os._exit(0)
os.write(1, b"forked\\n")
time.sleep(600)
"""


@pytest.mark.real_time
@pytest.mark.parametrize(
    ("program", "told"),
    [(FORKS, "Unreached Unreached shelf 12\n"), (FORKS_WITHOUT_ITS_ROBOT, "Unreached\n")],
    ids=["robot", "goal alone"],
)
def test_a_goal_ends_with_its_program_and_not_with_a_forked_one(program: str, told: str) -> None:
    with beside_console(program) as (script, python):
        said = {python.stdout.readline(), python.stdout.readline()}
        assert said == {"forked\n", told}
        script._read()
        assert "goal CANCELLED" not in script.said
        python.kill()
        script.until("goal CANCELLED")


@pytest.mark.real_time
async def test_a_cancel_is_not_confirmed_by_the_end_of_the_console() -> None:
    async with served(ros_args=LONG) as person:
        await typed("wait", "ready")
        goal = await asyncio.to_thread(archo_tui.connect().go, 12)
        await heard(person, "goal MOVING")
    await until(goal.done)
    with pytest.raises(Unreached, match="may still be moving"):
        await asyncio.to_thread(goal.cancel)


# consoles that hang or go


@pytest.mark.real_time
async def test_a_stop_reaches_the_console_that_came_in_the_place_of_another() -> None:
    domain = chosen.next_domain()
    async with served(ros_args=LONG, domain_id=domain):
        robot = await asyncio.to_thread(archo_tui.connect)
    with pytest.raises(Unreached, match="no console"):
        await asyncio.to_thread(robot.stop)
    with pytest.raises(Unreached, match="gone"):
        await asyncio.to_thread(robot.status)
    with pytest.raises(Unreached, match="no console runs here"):
        await asyncio.to_thread(archo_tui.stop)
    async with served(ros_args=LONG, domain_id=domain) as person:
        await asyncio.to_thread(robot.do, "stop", "now")
        await heard(person, "STOP: confirmed")
        await asyncio.to_thread(archo_tui.stop, str(os.getpid()))
        await until(lambda: person.said.count("STOP: confirmed") == 2)


@pytest.mark.real_time
@pytest.mark.pure
def test_help_explains_each_argument_that_is_public() -> None:
    assert "/north" in pydoc.render_doc(archo_tui.connect)
    for kind in (Robot, GoalHandle):
        for name, method in vars(kind).items():
            if name.startswith("_") or not callable(method):
                continue
            names = method.__code__.co_varnames[1 : method.__code__.co_argcount]
            for argument in names:
                assert f"{argument}: " in (method.__doc__ or ""), (name, argument)
    with pytest.raises(AttributeError):
        archo_tui.nothing  # noqa: B018
    assert set(archo_tui.__all__) - {"__version__", "connect", "stop"} <= set(dir(archo_tui))


# The console's own rules that a client shares; none of them imports a library.
OURS = (
    *("archo_tui", "archo_tui.client", "archo_tui.base", "archo_tui.base.errors"),
    *("archo_tui.base.nearest",),
    *("archo_tui.base.safe_text", "archo_tui.base.surrogates", "archo_tui.robot_file"),
    *("archo_tui.robot_file.reserved", "archo_tui.robot", "archo_tui.robot.stop"),
    "archo_tui.robot.stop.words",
)


def loaded(statement: str) -> set[str]:
    """The modules that Python has after a statement, site's own not counted."""
    code = f"import sys; before = set(sys.modules); {statement}; print(*set(sys.modules) - before)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("module", "most"),
    [("shell", 23), ("find", 16), ("protocol", 12), ("robot", 45)],
)
def test_a_client_loads_few_modules_beside_socket_and_json(module: str, most: int) -> None:
    name = f"archo_tui.client.{module}"
    found: Any = loaded(f"import {name}") - loaded("import socket, json")
    own = {other for other in found if other.startswith("archo_tui")}
    strange = {other for other in own if not other.startswith("archo_tui.client.")} - {*OURS}
    assert strange == set()  # nothing of the console
    others = {other.partition(".")[0].lstrip("_") for other in found - own}
    assert others <= {*(std.lstrip("_") for std in sys.stdlib_module_names)}
    assert len(found) <= most, sorted(found)
