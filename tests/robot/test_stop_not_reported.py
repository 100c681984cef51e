"""A STOP of a robot that never reports one: the console remembers it until a release."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot.stop.gate import HOLDS, UNCERTAIN
from archo_tui.text.state import motion_word, plain_text
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import TIMEOUT
from tests.support.alarms import conditions
from tests.support.clock import seconds
from tests.support.peer import Peer
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import making, robot

FILE = """
version: 1
name: Base
motion: {topic: motor_status, types: {archo_interfaces/msg/MotorStatus: {moving: moving}}}
goals:
  - {id: drive, title: Go, noun: shelf, action: move_to_shelf,
     type: archo_interfaces/action/MoveToShelf, form: {shelf_number: {label: Shelf}}}
stop: {service: e_stop, release: e_release}
"""


class Base(Node):
    """Stops, and says of itself only whether it moves; takes every goal, and arrives at once."""

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self.is_moving = self.is_silent = False
        self.status = self.create_publisher(MotorStatus, "motor_status", 10)
        # Of its own group: it wakes the executor while a service of the other one waits.
        self.create_timer(0.1, self.tell, callback_group=MutuallyExclusiveCallbackGroup())
        for name in ("e_stop", "e_release"):
            self.create_service(Trigger, name, self.obey)
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

    def tell(self) -> None:
        if not self.is_silent:
            self.status.publish(MotorStatus(moving=self.is_moving))

    def obey(self, _: Any, response: Any) -> Any:
        response.success = True
        return response

    def execute(self, goal: Any) -> Any:
        goal.succeed()
        return MoveToShelf.Result(success=True)


class Slow(Base):
    """Takes its time to answer."""

    def __init__(self, **options: Any) -> None:
        self.asked = False
        self.awake: Future[bool] = Future()
        super().__init__(**options)

    async def obey(self, _: Any, response: Any) -> Any:
        self.asked = True
        await self.awake
        response.success = True
        return response


class Driver(Base):
    """Drives until it is told to cancel, whatever STOP says."""

    def __init__(self, **options: Any) -> None:
        self.over: Future[bool] = Future()
        super().__init__(**options)
        self.server.register_cancel_callback(self.cancel)

    def cancel(self, _: Any) -> CancelResponse:
        self.over.set_result(True)
        return CancelResponse.ACCEPT

    async def execute(self, goal: Any) -> Any:
        await self.over
        goal.canceled()
        return MoveToShelf.Result()


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "base.yaml"
    made.write_text(FILE)
    return made


def go(it: Robot) -> Any:
    return it.send(it.file.goals[0], {"shelf_number": 3})


async def stopped(it: Robot) -> None:
    """Stop it once it is heard."""
    await until(lambda: it.snapshot.motion.received is not None)
    await until(lambda: {"e_stop", "move_to_shelf"} <= it.snapshot.offered)
    assert (await ended(it.emergency_stop())).ok
    await until(lambda: it.snapshot.latch is Latch.HELD)


async def test_it_is_shown_and_no_goal_goes_out_until_it_is_released(file: Path) -> None:
    async with robot(Base, robot=file) as it:
        await stopped(it)
        assert it.snapshot.is_stopped
        assert plain_text(motion_word(it.snapshot, seconds(), 80)) == "✗ STOPPED"
        assert "STOPPED: look for the cause" in conditions(it.snapshot, seconds()).values()
        await while_passes(3.0)
        refused = await ended(go(it))
        assert (refused.code, refused.text) == (Code.REFUSED, HOLDS)
        assert (await ended(it.release_emergency_stop())).ok
        await until(lambda: not it.snapshot.is_stopped)
        assert plain_text(motion_word(it.snapshot, seconds(), 80)) == "● IDLE"
        assert (await ended(go(it))).ok


async def test_when_the_robot_moves_it_is_no_longer_certain_until_r_or_another_stop(
    file: Path,
) -> None:
    made: list[Any] = []
    async with robot(making(made, Base), robot=file) as it:
        await stopped(it)
        await while_passes(1.0)
        made[0].is_moving = True
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        made[0].is_moving = False
        await until(lambda: it.snapshot.motion.moving is False)
        await while_passes(3.0)
        assert plain_text(motion_word(it.snapshot, seconds(), 80)) == "✗ STOP NOT CERTAIN"
        text = conditions(it.snapshot, seconds())["stop not certain"]
        assert text.startswith("STOP OF ")
        assert text.endswith(" IS NO LONGER CERTAIN: the robot moves: stop again, or release it")
        assert (await ended(go(it))).text == UNCERTAIN
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert (await ended(go(it))).text == HOLDS


async def test_a_short_move_as_it_brakes_leaves_it_certain(file: Path) -> None:
    made: list[Any] = []
    async with robot(making(made, Base), robot=file) as it:
        await until(lambda: made)
        made[0].is_moving = True
        await until(lambda: it.snapshot.motion.moving)
        await stopped(it)
        await while_passes(0.4)
        made[0].is_moving = False
        await while_passes(3.0)
        assert it.snapshot.latch is Latch.HELD
        assert not it.snapshot.stop_not_obeyed


async def test_another_consoles_release_leaves_it_uncertain(file: Path) -> None:
    made: list[Any] = []
    async with robot(Base, making(made, Peer), nodes=1, robot=file) as it:
        await stopped(it)
        await until(lambda: it.snapshot.consoles)
        made[0].tell("release")
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        assert it.snapshot.latch_doubt == "console other_lab_1 released it"


async def test_another_consoles_stop_holds_here_until_one_of_the_two_releases_it(
    file: Path,
) -> None:
    made: list[Any] = []
    async with robot(Base, making(made, Peer), nodes=1, robot=file) as it:
        await until(lambda: "e_release" in it.snapshot.offered and it.snapshot.consoles)
        await until(lambda: it.snapshot.motion.received is not None)
        made[0].tell("stop")
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert plain_text(motion_word(it.snapshot, seconds(), 80)) == "✗ STOPPED"
        assert (await ended(go(it))).text == HOLDS
        made[0].tell("release")
        await until(lambda: it.snapshot.latch is Latch.NONE)
        assert plain_text(motion_word(it.snapshot, seconds(), 80)) == "● IDLE"
        made[0].tell("stop")
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert (await ended(it.release_emergency_stop())).ok
        assert (await ended(go(it))).ok


async def test_another_consoles_stop_cancels_a_goal_that_goes_on_behind_it(file: Path) -> None:
    made: list[Any] = []
    peers: list[Any] = []
    async with robot(making(made, Driver), making(peers, Peer), nodes=1, robot=file) as it:
        await until(lambda: it.snapshot.consoles and it.snapshot.motion.received is not None)
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it))).ok
        await while_passes(0.5)
        peers[0].tell("stop")
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase is Phase.CANCELLED)


async def test_another_consoles_stop_is_not_over_by_an_answer_to_what_left_before_it(
    file: Path,
) -> None:
    made: list[Any] = []
    peers: list[Any] = []
    async with robot(making(made, Slow), making(peers, Peer), nodes=1, robot=file) as it:
        await until(lambda: "e_release" in it.snapshot.offered and it.snapshot.consoles)
        await until(lambda: it.snapshot.motion.received is not None)
        release = asyncio.ensure_future(it.release_emergency_stop())
        await until(lambda: made[0].asked)
        peers[0].tell("stop")
        await until(lambda: it.snapshot.latch is Latch.HELD)
        made[0].executor.create_task(lambda: made[0].awake.set_result(True))
        assert (await ended(release)).ok
        assert it.snapshot.latch is Latch.UNCERTAIN  # The robot may have released it last.


async def test_its_alarm_ends_with_the_release_of_a_robot_that_is_not_heard(file: Path) -> None:
    made: list[Any] = []
    async with operated(making(made, Base), robot=file) as typed:
        station = typed._plain._station
        await until(lambda: {"e_stop", "e_release"} <= station.robot.snapshot.offered)
        await until(lambda: station.robot.snapshot.motion.period is not None)
        typed.type("stop\n")
        await typed.until("alarm unacknowledged: STOPPED")
        made[0].is_silent = True
        await typed.until("alarm unacknowledged: CONTACT LOST")
        typed.type("release --yes\n")
        await typed.until("alarm over, unacknowledged: stopped")


async def test_a_program_that_waits_for_ready_is_told_so_after_the_release_only(
    file: Path,
) -> None:
    async with operated(Base, robot=file) as typed:
        station = typed._plain._station
        wait = verbs(station.robot.file, station.robot.snapshot.forms)["wait"]
        await until(lambda: "move_to_shelf" in station.robot.snapshot.offered)
        typed.type("stop\ngo 3\n")
        await typed.until(HOLDS)
        ready, stopped = ({"state": state, TIMEOUT: 3.0} for state in ("ready", "stopped"))
        assert (await ended(wait.run(station, ready))).code is Code.RAN_OUT
        assert (await ended(wait.run(station, stopped))).ok
        typed.type("release --yes\n")
        assert (await ended(wait.run(station, {**ready, TIMEOUT: 10.0}))).ok
