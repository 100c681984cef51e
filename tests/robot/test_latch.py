"""A STOP outlives the node that held it: told again here, no longer certain elsewhere."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from archo_interfaces.srv import EmergencyStop
from rclpy.action import ActionServer
from rclpy.node import Node
from std_srvs.srv import Trigger

from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot.stop.gate import UNCERTAIN
from archo_tui.text.state import motion_word, plain_text
from tests.support.alarms import conditions
from tests.support.archo import go
from tests.support.clock import seconds
from tests.support.console import FAST
from tests.support.peer import Peer
from tests.support.plain import operated
from tests.support.plain import plain as typed
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import making, robot

TOLD = "; /motor_controller was told STOP first, and is stopped"


class Motor(Node):
    """Holds a STOP as long as it lives; takes every goal otherwise."""

    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", **options)
        self.stopped = False
        self.create_service(EmergencyStop, "emergency_stop", self.stop)
        self.create_service(Trigger, "release_emergency_stop", self.release)
        self.status = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(0.1, self.tell)
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

    def tell(self) -> None:
        self.status.publish(MotorStatus(emergency_stopped=self.stopped))

    def stop(self, request: Any, response: Any) -> Any:
        self.stopped = response.success = True
        return response

    def release(self, request: Any, response: Any) -> Any:
        self.stopped, response.success = False, True
        return response

    def execute(self, goal: Any) -> Any:
        goal.succeed()
        return MoveToShelf.Result(success=True)


class Elsewhere:
    """A motor that no host of ours knows, on the executor of another node."""

    def __init__(self, host: Node) -> None:
        self._host = host
        self.motor = self._made()

    def _made(self) -> Motor:
        motor = Motor(context=self._host.context)
        self._do(self._host.executor.add_node, motor)  # type: ignore[union-attr]
        return motor

    def _do(self, *work: Any) -> None:
        assert self._host.executor is not None
        self._host.executor.create_task(*work)

    async def kill(self) -> None:
        motor, ended = self.motor, threading.Event()

        def end() -> None:
            self._host.executor.remove_node(motor)  # type: ignore[union-attr]
            motor.server.destroy()
            motor.destroy_node()
            ended.set()

        self._do(end)
        await until(ended.is_set)

    async def restart(self) -> None:
        await self.kill()
        self.motor = self._made()


@asynccontextmanager
async def stopped_elsewhere() -> AsyncIterator[tuple[Robot, Elsewhere]]:
    made: list[Node] = []
    async with robot(making(made, Node, "somebody")) as it:
        await until(lambda: made[0].executor is not None)
        elsewhere = Elsewhere(made[0])
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await until(lambda: it.snapshot.motion.stopped is False)
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.says_stopped)
        assert latch(it) is Latch.HELD
        try:
            yield it, elsewhere
        finally:
            await elsewhere.kill()


def latch(it: Robot) -> Latch:
    return it.snapshot.latch


def said_by_others(it: Robot) -> list[str]:
    return [event.text for event in it.snapshot.events if event.level == "PEER"]


async def test_the_stop_of_a_console_that_has_only_just_come_counts() -> None:
    made: list[Node] = []
    async with robot(making(made, Node, "somebody")) as it:
        await until(lambda: made[0].executor is not None)
        peer = Peer(context=made[0].context)
        await until(lambda: peer._records.get_subscription_count() == 1)
        peer.tell("stop")
        await until(lambda: said_by_others(it) == ["stop: done"])
        assert it.stops.sent_elsewhere == 1
        peer.destroy_node()


async def test_of_one_that_was_started_anew_elsewhere_it_is_not_certain_until_said_anew() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        await elsewhere.restart()
        await until(lambda: it.snapshot.motion.stopped is False)
        await until(lambda: latch(it) is Latch.UNCERTAIN)
        assert it.snapshot.is_stopped
        assert plain_text(motion_word(it.snapshot, seconds(), 40)) == "✗ STOP NOT CERTAIN"
        said = "/motor_controller was started since: stop again, or release it"
        await until(lambda: conditions(it.snapshot, seconds())["stop not certain"].endswith(said))
        assert await ended(go(it, 3)) == (Code.REFUSED, UNCERTAIN)
        await while_passes(6.0)
        assert said_by_others(it) == []
        assert (await ended(it.emergency_stop())).ok
        assert latch(it) is Latch.HELD
        await elsewhere.restart()
        await until(lambda: latch(it) is Latch.UNCERTAIN)
        await until(lambda: "release_emergency_stop" in it.snapshot.offered)
        assert (await ended(it.release_emergency_stop())).ok
        assert latch(it) is Latch.NONE
        assert not it.snapshot.is_stopped
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok


async def test_of_one_that_has_left_it_is_never_shown_as_stopped() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        await elsewhere.kill()
        await until(lambda: latch(it) is Latch.UNCERTAIN)
        found = conditions(it.snapshot, seconds())
        assert "/motor_controller has left" in found["stop not certain"]
        assert "stopped" not in found
        assert not it.snapshot.says_stopped
        await until(lambda: "release_emergency_stop" not in it.snapshot.offered)
        assert (await ended(it.release_emergency_stop())).code == Code.NOT_OFFERED
        assert it.snapshot.is_stopped
        elsewhere.motor = elsewhere._made()


async def test_one_that_leaves_as_it_confirms_leaves_no_stop_to_the_next() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        assert (await ended(it.release_emergency_stop())).ok
        await until(lambda: it.snapshot.motion.stopped is False)
        motor, holders = elsewhere.motor, it.graph.holders
        it.graph.holders = lambda service: {} if motor.stopped else holders(service)  # type: ignore[method-assign]
        assert (await ended(it.emergency_stop())).ok
        await elsewhere.kill()
        it.graph.holders = holders  # type: ignore[method-assign]
        elsewhere.motor = elsewhere._made()
        assert await ended(go(it, 3)) == (Code.REFUSED, UNCERTAIN)
        await until(lambda: it.snapshot.motion.stopped is False)
        await until(lambda: latch(it) is Latch.UNCERTAIN)


async def test_a_release_by_another_client_is_said_when_it_was_seen() -> None:
    async with stopped_elsewhere() as (it, elsewhere):
        elsewhere.motor.stopped = False
        await until(lambda: said_by_others(it))
        assert said_by_others(it) == ["stop released by another client"]
        assert latch(it) is Latch.NONE


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


class WornMotor(Node):
    """Confirms its first STOP only."""

    times = 0

    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", **options)
        self.create_service(EmergencyStop, "emergency_stop", self.stop)

    def stop(self, request: Any, response: Any) -> Any:
        WornMotor.times += 1
        response.success, response.message = WornMotor.times == 1, "the brake is worn"
        return response


async def test_one_that_cannot_take_it_is_no_longer_certain() -> None:
    WornMotor.times = 0
    async with operated(WornMotor) as person:
        person.type("stop\nhalt motor_controller\nstart motor_controller\n")
        why = "the STOP is not confirmed by it (the brake is worn): use the hardware stop"
        await person.until(f"/motor_controller started; {why}")
        await person.until("IS NO LONGER CERTAIN")
        assert f"failed: start: /motor_controller started; {why}" in person.said


@pytest.mark.real_time
async def test_a_file_that_is_saved_behind_a_stop_waits_for_a_key(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # It is another process there.
    import archo_bringup.motor_controller as own

    motor = here / "motor.py"
    motor.write_text(Path(own.__file__).read_text())
    async with operated(node_files=[motor], ros_args=FAST) as person:
        await person.until("motor_params.yaml is for ARCHO's own node")
        station = person._plain._station
        await until(lambda: "emergency_stop" in station.robot.snapshot.offered)
        person.type("stop\n")
        await person.until("alarm unacknowledged: STOPPED")
        (hosted,) = station.host.programs
        await asyncio.to_thread(station.host.reload, hosted.file)
        await person.until("motor.py was saved, and is not started behind a STOP")
        person.type("go 12\n")
        await person.until("failed: go: emergency stop: release it first")
        assert station.host.programs == [hosted]  # It runs on as it was.
        person.type("halt motor_controller --yes\nstart motor_controller\n")
        await person.until("failed: start: /motor_controller is not started behind a STOP")


@pytest.mark.parametrize("last", ["", "halt motor_controller --yes\nstart motor_controller\n"])
async def test_a_release_is_judged_by_what_was_confirmed_and_never_waits(
    last: str,
) -> None:
    code, said = await typed(f"stop\n{last}release --yes\ngo 7\n", ros_args=FAST)
    assert code == 0, said
    async with operated(ros_args=FAST) as person:
        await while_passes(6.0)
        before = seconds()
        person.type("release --yes\n")
        await person.until("failed: release: the robot is not stopped")
        assert seconds() - before < 0.5
