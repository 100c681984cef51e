"""A confirmed STOP is remembered until a release, and uncertain once the robot may have moved."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot.stop.gate import HOLDS, UNCERTAIN
from archo_tui.text.state import motion_word
from tests.support.alarms import alarms_of
from tests.support.archo import go
from tests.support.clock import seconds
from tests.support.console import FAST
from tests.support.peer import Peer
from tests.support.plain import operated
from tests.support.plain import plain as typed
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot
from tests.support.ros import begin
from tests.support.stand_in import Made, StandIn, beside
from tests.support.states import plain_text

TOLD = "; /motor_controller was told STOP first, and is stopped"


def word(it: Robot) -> str:
    return plain_text(motion_word(it.snapshot, seconds(), 80))


def said_by_others(it: Robot) -> list[str]:
    return [event.text for event in it.snapshot.events if event.level == "PEER"]


# It outlives the node that held it: told again here, no longer certain elsewhere.


class Elsewhere:
    """A motor that holds a STOP as long as it lives, and that no host of ours knows."""

    def __init__(self, host: Node) -> None:
        self._host = host
        self.start()

    def start(self) -> None:
        motor = StandIn(
            "motor_controller",
            "yes",
            release="yes",
            goals="arrive",
            latches=True,
            moving=False,
            context=self._host.context,
        )
        self.motor = beside(self._host, motor)

    async def kill(self) -> None:
        await until(begin(self._host, self.motor.leave).done)

    async def restart(self) -> None:
        await self.kill()
        self.start()


@asynccontextmanager
async def stopped_elsewhere() -> AsyncIterator[tuple[Robot, Elsewhere]]:
    host = Made(Node, "somebody")
    async with robot(host) as it:
        await until(lambda: host.node.executor is not None)
        elsewhere = Elsewhere(host.node)
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await until(lambda: it.snapshot.motion.stopped is False)
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.says_stopped)
        assert it.snapshot.latch is Latch.HELD
        try:
            yield it, elsewhere
        finally:
            await elsewhere.kill()


async def test_the_stop_of_a_console_that_has_only_just_come_counts() -> None:
    host = Made(Node, "somebody")
    async with robot(host) as it:
        await until(lambda: host.node.executor is not None)
        peer = Peer(context=host.node.context)
        await until(lambda: peer._records.get_subscription_count() == 1)
        peer.tell("stop")
        await until(lambda: said_by_others(it) == ["stop: done"])
        assert it.stops.sent_elsewhere == 1
        peer.destroy_node()


async def test_of_one_that_was_started_anew_elsewhere_it_is_not_certain_until_said_anew() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        await elsewhere.restart()
        await until(lambda: it.snapshot.motion.stopped is False)
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        assert it.snapshot.is_stopped
        assert word(it) == "✗ STOP NOT CERTAIN"
        said = "/motor_controller was started since: stop again, or release it"
        await until(lambda: alarms_of(it)["stop not certain"].endswith(said))
        assert await ended(go(it, 3)) == (Code.REFUSED, UNCERTAIN)
        await while_passes(6.0)
        assert said_by_others(it) == []
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.latch is Latch.HELD)
        await elsewhere.restart()
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        await until(lambda: "release_emergency_stop" in it.snapshot.offered)
        assert (await ended(it.release_emergency_stop())).ok
        assert it.snapshot.latch is Latch.NONE
        assert not it.snapshot.is_stopped
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok


async def test_of_one_that_has_left_it_is_never_shown_as_stopped() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        await elsewhere.kill()
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        found = alarms_of(it)
        assert "/motor_controller has left" in found["stop not certain"]
        assert "stopped" not in found
        assert not it.snapshot.says_stopped
        await until(lambda: "release_emergency_stop" not in it.snapshot.offered)
        assert (await ended(it.release_emergency_stop())).code == Code.NOT_OFFERED
        assert it.snapshot.is_stopped
        elsewhere.start()


async def test_one_that_leaves_as_it_confirms_leaves_no_stop_to_the_next() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        assert (await ended(it.release_emergency_stop())).ok
        await until(lambda: it.snapshot.motion.stopped is False)
        motor, holders = elsewhere.motor, it.graph.holders
        it.graph.holders = lambda service: {} if motor.stopped else holders(service)  # type: ignore[method-assign]
        assert (await ended(it.emergency_stop())).ok
        await elsewhere.kill()
        it.graph.holders = holders  # type: ignore[method-assign]
        elsewhere.start()
        assert await ended(go(it, 3)) == (Code.REFUSED, UNCERTAIN)
        await until(lambda: it.snapshot.motion.stopped is False)
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)


async def test_a_release_by_another_client_is_said_when_it_was_seen() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        elsewhere.motor.stopped = False
        await until(lambda: said_by_others(it))
        assert said_by_others(it) == ["stop released by another client"]
        assert it.snapshot.latch is Latch.NONE


async def test_a_motor_that_was_halted_behind_a_stop_is_told_it_before_it_runs() -> None:
    async with operated(ros_args=FAST) as person:
        person.type("stop\nhalt motor_controller --yes\nstart motor_controller\ngo 12\n")
        await person.until("failed: go: emergency stop: release it first")
        held = "stopped; it held the STOP, and is told of it again before it starts"
        assert f"stop /motor_controller: /motor_controller {held}" in person.said
        assert f"/motor_controller started{TOLD}" in person.said
        await while_passes(6.0)
        assert "another client" not in person.said
        assert "alarm unacknowledged: THE STOP" not in person.said
        assert await person.end("release --yes\ngo 7\n") == 1
        assert "Arrived at shelf 7" in person.said


async def test_one_that_cannot_take_it_is_no_longer_certain() -> None:
    answers = iter(("yes", "no"))

    def motor(**options: Any) -> Node:
        return StandIn("motor_controller", next(answers), **options)

    async with operated(motor) as person:
        person.type("stop\nhalt motor_controller\nstart motor_controller\n")
        why = "the STOP is not confirmed by it (motor_controller no): use the hardware stop"
        await person.until(f"/motor_controller started; {why}")
        await person.until("IS NO LONGER CERTAIN")
        assert f"failed: start: /motor_controller started; {why}" in person.said


async def test_a_release_is_judged_by_what_was_confirmed_and_never_waits() -> None:
    lines = "stop\nhalt motor_controller --yes\nstart motor_controller\nrelease --yes\ngo 7\n"
    code, said = await typed(lines, ros_args=FAST)
    assert code == 0, said
    async with operated(ros_args=FAST) as person:
        await while_passes(6.0)
        before = seconds()
        await person.enter("release --yes", "failed: release: the robot is not stopped")
        assert seconds() - before < 0.5


# A robot that never reports one.

FILE = """
version: 1
name: Base
motion: {topic: motor_status, types: {archo_interfaces/msg/MotorStatus: {moving: moving}}}
goals:
  - {id: drive, title: Go, noun: shelf, action: move_to_shelf,
     type: archo_interfaces/action/MoveToShelf, form: {shelf_number: {label: Shelf}}}
stop: {service: emergency_stop, release: release_emergency_stop}
"""
OFFERS = "emergency_stop release_emergency_stop move_to_shelf"
Base = partial(Made, StandIn, "base", "yes", release="yes", goals="arrive", moving=False)


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "base.yaml"
    made.write_text(FILE)
    return made


def drive(it: Robot) -> Any:
    return it.send(it.file.goals[0], {"shelf_number": 3})


@asynccontextmanager
async def heard(file: Path, *makers: Any) -> AsyncIterator[Robot]:
    """Beside a robot whose motion is heard, and the other consoles, if any."""
    async with robot(*makers, robot=file, nodes=1, offers=OFFERS) as it:
        await until(lambda: it.snapshot.motion.received is not None)
        await until(lambda: len(it.snapshot.consoles) == len(makers) - 1)
        yield it


async def stop(it: Robot) -> None:
    assert (await ended(it.emergency_stop())).ok
    await until(lambda: it.snapshot.latch is Latch.HELD)


async def test_it_is_shown_and_no_goal_goes_out_until_it_is_released(file: Path) -> None:
    async with heard(file, Base()) as it:
        await stop(it)
        assert it.snapshot.is_stopped
        assert word(it) == "✗ STOPPED"
        assert "STOPPED: look for the cause" in alarms_of(it).values()
        await while_passes(3.0)
        assert await ended(drive(it)) == (Code.REFUSED, HOLDS)
        assert (await ended(it.release_emergency_stop())).ok
        await until(lambda: not it.snapshot.is_stopped)
        assert word(it) == "● IDLE"
        assert (await ended(drive(it))).ok


async def test_when_the_robot_moves_it_is_no_longer_certain_until_r_or_another_stop(
    file: Path,
) -> None:
    base = Base()
    async with heard(file, base) as it:
        await stop(it)
        await while_passes(1.0)
        base.node.moving = True
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        base.node.moving = False
        await until(lambda: it.snapshot.motion.moving is False)
        await while_passes(3.0)
        assert word(it) == "✗ STOP NOT CERTAIN"
        text = alarms_of(it)["stop not certain"]
        assert text.startswith("STOP OF ")
        assert text.endswith(" IS NO LONGER CERTAIN: the robot moves: stop again, or release it")
        assert (await ended(drive(it))).text == UNCERTAIN
        await stop(it)
        assert (await ended(drive(it))).text == HOLDS


async def test_another_consoles_release_leaves_it_uncertain(file: Path) -> None:
    peer = Made(Peer)
    async with heard(file, Base(), peer) as it:
        await stop(it)
        peer.node.tell("release")
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        assert it.snapshot.latch_doubt == "console other_lab_1 released it"


async def test_another_consoles_stop_holds_here_until_one_of_the_two_releases_it(
    file: Path,
) -> None:
    peer = Made(Peer)
    async with heard(file, Base(), peer) as it:
        peer.node.tell("stop")
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert word(it) == "✗ STOPPED"
        assert (await ended(drive(it))).text == HOLDS
        peer.node.tell("release")
        await until(lambda: it.snapshot.latch is Latch.NONE)
        assert word(it) == "● IDLE"
        peer.node.tell("stop")
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert (await ended(it.release_emergency_stop())).ok
        assert (await ended(drive(it))).ok


async def test_another_consoles_stop_cancels_a_goal_that_goes_on_behind_it(file: Path) -> None:
    peer = Made(Peer)
    async with heard(file, Base(goals="drive"), peer) as it:
        assert (await ended(drive(it))).ok
        await while_passes(0.5)
        peer.node.tell("stop")
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase is Phase.CANCELLED)


async def test_its_alarm_ends_with_the_release_of_a_robot_that_is_not_heard(file: Path) -> None:
    base = Base()
    async with operated(base, robot=file) as person:
        it = person._plain._station.robot
        await until(lambda: {*OFFERS.split()} <= it.snapshot.offered)
        await until(lambda: it.snapshot.motion.period is not None)
        person.type("stop\n")
        await person.until("alarm unacknowledged: STOPPED")
        base.node.is_silent = True
        await person.until("alarm unacknowledged: CONTACT LOST")
        person.type("release --yes\n")
        await person.until("alarm over, unacknowledged: stopped")
