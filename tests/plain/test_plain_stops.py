"""`--plain` and STOP: it overtakes, and voids what was typed before it and has not left yet."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.base.clock import Clock
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.session.session import _robots_nodes
from tests.robots.cart import Cart
from tests.support import clock
from tests.support.console import BRISK
from tests.support.peer import Peer
from tests.support.plain import operated, typing
from tests.support.quiet import Quiet, until
from tests.support.robot import making
from tests.support.script import Script, shell
from tests.support.stand_in import Made, StandIn
from tests.support.states import NORMAL, goal
from tests.support.stub import Willing, stub_station
from tests.support.waiting import DEADLINE

CART = Path(__file__).parent.parent / "robots" / "cart.yaml"
VOID = "not sent: STOP came after it"


async def test_what_waits_when_a_stop_comes_is_not_sent_afterwards(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.verbs.verb.DISCOVERY_TIME", 60.0)  # The call waits.
    async with operated() as person:
        await person.enter("stop", "STOP: confirmed")
        person.type("status\ncall /nosuch\nrelease --yes\n")
        await person.until("\ngoal No goal yet")
        began = clock.seconds()
        await until(lambda: clock.seconds() > began + 2.0)
        await person.enter("stop", f"failed: call: {VOID}")
        assert clock.seconds() < began + 4.0  # it would have waited for 5 s
        assert await person.end("status\n") == 1
    assert f"failed: release: {VOID}" in person.said
    assert "console: release stop" not in person.said
    assert "motor STOPPED" in person.said.split(f"failed: release: {VOID}")[1]


async def test_a_goal_typed_before_a_stop_that_does_not_latch_is_not_driven() -> None:
    async with operated(Cart, robot=CART) as person:
        await person.enter("go 12", "drives to 12")
        assert await person.end("cancel\ngo 7\ngo 3 4\nstop\n") == 1
    assert person.said.count(f"failed: go: {VOID}") == 2
    assert "STOP: confirmed" in person.said
    assert person.said.count("drives to") == 1
    assert "not driven" not in person.said


async def test_a_goal_typed_behind_a_stop_that_does_not_latch_is_driven() -> None:
    async with operated(Cart, robot=CART) as person:
        person.type("go 7\nstop\ngo 3\n")
        await person.until("drives to 3")
        person.type("cancel\n")
        await person.end()
    assert "drives to 7" not in person.said


async def test_a_void_goal_is_a_failure_even_when_a_later_one_arrives() -> None:
    async with operated() as person:
        assert await person.end("go 12\nstop\nrelease --yes\ngo 7\n") == 1
    assert f"failed: go: {VOID}" in person.said
    assert "ARRIVED, Arrived at shelf 7" in person.said


class Slow(Willing):
    """Answers a STOP when the test says so."""

    def __init__(self, snapshot: Snapshot = NORMAL) -> None:
        super().__init__(snapshot)
        self.answers: list[asyncio.Future[Outcome]] = []

    async def emergency_stop(self) -> Outcome:
        self.told.append("stop")
        self.answers.append(asyncio.get_running_loop().create_future())
        return await self.answers[-1]


async def test_a_cancel_typed_before_a_stop_still_goes() -> None:
    robot: Any = Slow()
    async with typing(stub_station(robot)) as person:
        person.type("call /nosuch\ncancel\nstop\n")
        await until(lambda: robot.told == ["stop", "cancel"])
        robot.answers[0].set_result(Outcome(Code.DONE, "Stopped"))
        assert await person.end() == 1
    assert "failed: cancel" not in person.said


async def test_stops_that_come_before_the_answer_are_covered_by_one_more() -> None:
    robot: Any = Slow()
    async with typing(stub_station(robot)) as person:
        person.type("stop\n")
        await until(lambda: robot.told == ["stop"])
        person.type("stop\nSTOP!\nstop now\nstop\n")
        # The loop waits, too: otherwise the second may leave before the last is read.
        while not (robot.stops.count == 5 and person._plain._input.is_quiet):
            time.sleep(clock.LOOK)
        robot.answers[0].set_result(Outcome(Code.DONE, "Stopped"))
        await until(lambda: len(robot.answers) == 2)
        robot.answers[1].set_result(Outcome(Code.DONE, "Stopped"))
        assert await person.end() == 0
    assert robot.told == ["stop", "stop"]


class Quick(Willing):
    """Stops and releases at once."""

    async def emergency_stop(self) -> Outcome:
        return self._say("stop", stopped=True)

    async def release_emergency_stop(self) -> Outcome:
        return self._say("release", stopped=False)

    def _say(self, told: str, *, stopped: bool) -> Outcome:
        self.told.append(told)
        self.stops.superseded = not stopped
        self.put(self.snapshot._replace(motion=replace(self.snapshot.motion, stopped=stopped)))
        return Outcome(Code.DONE, told)


async def in_no_time(holds: Callable[[int], object], number: int) -> None:
    """Wait until it holds for the number, while a virtual clock stands still."""
    end = time.monotonic() + DEADLINE
    while not holds(number):
        assert time.monotonic() < end
        await asyncio.sleep(clock.LOOK)


async def test_every_stop_behind_a_release_is_sent_at_once() -> None:
    robot: Any = Quick(NORMAL)
    async with typing(stub_station(robot, clock.current or Clock())) as person:
        for count in range(1, 6):
            person.type("stop\nrelease --yes\n")
            await in_no_time(lambda n: robot.told == ["stop", "release"] * n, count)


async def test_of_a_flood_of_stops_two_a_second_reach_the_robot() -> None:
    robot: Any = Quick(NORMAL)
    async with typing(stub_station(robot, clock.current or Clock())) as person:
        began = clock.seconds()
        for count in range(1, 101):
            person.type("stop\n")
            await in_no_time(lambda n: robot.stops.count == n, count)
            await Quiet().settle()
        assert len(robot.told) <= 2 + 2 * (clock.seconds() - began)
        before = len(robot.told)
        assert await person.end() == 0
    assert len(robot.told) == before + 1


async def test_a_line_behind_a_stop_waits_for_its_answer() -> None:
    robot: Any = Slow()
    async with typing(stub_station(robot)) as person:
        person.type("stop\ncancel\n")
        await until(lambda: robot.told)
        await Quiet().settle()
        assert robot.told == ["stop"]
        robot.answers[0].set_result(Outcome(Code.DONE, "Stopped"))
        await until(lambda: robot.told == ["stop", "cancel"])
        await person.end()


async def test_a_line_read_for_a_question_waits_for_the_stop_before_it() -> None:
    robot: Any = Slow(goal(Phase.MOVING, mine=False))
    async with typing(stub_station(robot, clock.current or Clock()), at_terminal=True) as person:
        await person.enter("cancel", "Another client sent this goal. Cancel it? [y/N]")
        person.type("stop\nreset\n")
        while not person._plain._input._waiting:  # Both are there when the loop goes on.
            time.sleep(clock.LOOK)
        await until(lambda: robot.told == ["stop"])
        robot.put(NORMAL)
        await person.until("failed: cancel: the goal that was asked about has ended")
        await Quiet().settle()
        assert robot.told == ["stop"]
        robot.answers[0].set_result(Outcome(Code.DONE, "Stopped"))
        await until(lambda: robot.told == ["stop", "command"])


@pytest.mark.parametrize("typed", ["stop", "quit\nstop\n", "quit\nstop"])
async def test_the_end_waits_for_the_answer_to_a_stop(typed: str) -> None:
    robot: Any = Slow()
    async with typing(stub_station(robot)) as person:
        person.type_last(typed)
        await until(lambda: robot.told)
        for _ in range(20):
            await Quiet().settle()
        assert not person.is_over
        robot.answers[0].set_result(Outcome(Code.TIMEOUT, "no answer in 2 s"))
        assert await person.end() == 1
    assert "failed: stop: no answer in 2 s" in person.said


def test_a_stop_behind_a_megabyte_of_lines_is_obeyed_at_once() -> None:
    script = Script()
    script.type("call /nosuch\n" + "cancel\n" * 150_000 + "stop\n")
    script.until("STOP: confirmed")
    script.close()


async def test_lines_that_are_refused_are_said_once_and_are_a_failure() -> None:
    robot: Any = Slow()
    line = "status" + " " * 60_000
    async with typing(stub_station(robot)) as person:
        await until(lambda: robot.listening)  # and reads: more is typed than a pipe holds
        person.type("stop\n" + f"{line}\n" * 50)
        await person.until("failed: too many lines wait: further ones are refused")
        await until(lambda: robot.answers)
        robot.answers[0].set_result(Outcome(Code.DONE, "Stopped"))
        assert await person.end() == 1
    assert person.said.count("failed:") == 1
    assert person.said.count("battery ") == 1024 * 1024 // len(line)


@pytest.mark.parametrize("typed", ["go 12\\nstop", "quit\\nstop\\n", "\\357\\273\\277Stop!\\r"])
def test_a_stop_that_comes_last_is_sent_before_the_end(typed: str) -> None:
    done = shell(f"printf '{typed}' | archo --plain")
    assert b"STOP: confirmed" in done.stdout, done


async def test_a_stop_that_is_refused_late_is_said() -> None:
    async with operated(Made(StandIn, "brake", "no", seconds=2.5)) as person:
        station = person.station
        await until(lambda: "emergency_stop" in station.robot.snapshot.offered)
        await person.enter("stop", "failed: stop: ")
        await person.until("STOP, answered late: REFUSED")


async def test_a_release_that_was_asked_before_another_consoles_stop_is_void() -> None:
    made: list[Peer] = []
    nodes = [*_robots_nodes(False).values(), making(made, Peer)]
    async with operated(*nodes, at_terminal=True) as person:
        await person.enter("stop", "alarm unacknowledged: STOPPED")
        await person.enter("release", "[y/N]")
        made[0].tell("stop")
        await person.until(f"failed: release: {VOID}")
        assert await person.end() == 1
    assert "release stop" not in person.said


async def test_another_consoles_stop_that_is_refused_holds_what_waited_here() -> None:
    peer, nodes = Made(Peer), _robots_nodes(False).values()
    async with operated(*nodes, peer, ros_args=BRISK) as person:
        await person.enter("go 12 7", "MOVING to 12")
        await until(lambda: peer.node._records.get_subscription_count() == 1)
        peer.node.tell("stop", Code.REFUSED)
        await person.until("queue held: 7 (STOP)")
        await person.until("Arrived at shelf 12")
        assert "MOVING to 7" not in person.said
        await person.enter("continue", "MOVING to 7")
        assert await person.end() == 0


async def test_a_stop_that_no_node_serves_is_said_in_time_and_never_called_sent() -> None:
    async with operated(lambda **options: Node("none", **options)) as person:
        said = "STOP NOT CONFIRMED (emergency_stop is not offered by any node): use the hardware"
        await person.enter("stop", f"alarm unacknowledged: {said}")
        failed = "failed: stop: /emergency_stop is not offered by any node"
        await person.until(failed)
        later = clock.seconds() + 6.0
        await until(lambda: clock.seconds() > later)
        began = clock.seconds()
        person.type("stop\n")
        await until(lambda: person.said.count(failed) == 2)
        assert clock.seconds() - began < 2.5
    assert "STOP SENT" not in person.said


async def test_a_continue_typed_before_a_stop_continues_nothing() -> None:
    async with operated(Cart, robot=CART) as person:
        await person.enter("go 12 7", "drives to 12")
        await person.enter("stop", "queue held: 7")
        assert await person.end("continue\nstop\n") == 1
    assert f"failed: continue: {VOID}" in person.said
    assert "not driven: 7" in person.said
    assert "drives to 7" not in person.said
