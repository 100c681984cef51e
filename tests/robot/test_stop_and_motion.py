"""What the robot says of its motion, once a STOP was sent: believed where it is the worse news."""

from __future__ import annotations

from typing import Any

from archo_interfaces.msg import MotorStatus
from archo_interfaces.srv import EmergencyStop
from rclpy.node import Node

from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.snapshot import Latch
from archo_tui.text.state import motion_word, plain_text
from tests.robot.test_several_servers import Brake, Drive, alarms
from tests.support import clock
from tests.support.archo import SHELF, go
from tests.support.quiet import ended, until
from tests.support.robot import making, robot


class Wheels(Node):
    """Publishes how it moves, whatever it is told."""

    def __init__(self, name: str = "wheels", **options: Any) -> None:
        super().__init__(name, **options)
        self.moving, self.stopped = True, False
        self.status = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(0.2, self.tell)
        self.create_service(EmergencyStop, "release_emergency_stop", self.release)

    def tell(self) -> None:
        self.status.publish(
            MotorStatus(speed=0.8, moving=self.moving, emergency_stopped=self.stopped)
        )

    def release(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        response.success = True
        return response


async def later(seconds: float) -> None:
    due = clock.seconds() + seconds
    await until(lambda: clock.seconds() >= due)


async def test_a_robot_that_moves_on_behind_a_confirmed_stop_is_an_alarm() -> None:
    wheels: list[Wheels] = []
    async with robot(making([], Brake, "brake"), making(wheels, Wheels)) as it:
        await until(lambda: it.snapshot.motion.moving)
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: "moves after stop" in alarms(it))
        assert alarms(it)["moves after stop"].startswith("THE ROBOT MOVES ALTHOUGH STOP WAS SENT")
        wheels[0].moving = False
        await until(lambda: "moves after stop" not in alarms(it))
        wheels[0].moving = True  # it does not latch: somebody else drives it again
        await later(2.0)
        assert "moves after stop" not in alarms(it)


async def test_goals_end_behind_a_stop_that_only_the_motion_confirms() -> None:
    wheels: list[Wheels] = []
    drives: list[Drive] = []
    makers = making([], Brake, "brake", "nothing"), making(wheels, Wheels)
    async with robot(
        *makers, making(drives, Drive, "drive"), offers="emergency_stop move_to_shelf"
    ) as it:
        assert (await ended(go(it, 5))).ok
        await later(1.0)
        wheels[0].moving, wheels[0].stopped = False, True
        outcome = await ended(it.emergency_stop())
        assert outcome == (Code.DONE, "the robot says that it is stopped")
        await until(lambda: drives[0].over.done())


async def test_goals_from_before_a_late_yes_end() -> None:
    drives: list[Drive] = []
    makers = making([], Brake, "brake", "yes", 4.0), making(drives, Drive, "drive")
    async with robot(*makers, offers="emergency_stop move_to_shelf") as it:
        assert not (await ended(it.emergency_stop())).ok
        assert (await ended(it.give_up_stop())).ok
        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        await until(lambda: drives[0].over.done())


async def test_a_late_yes_to_an_older_stop_behind_a_release_is_not_certain() -> None:
    brakes: list[Brake] = []
    async with robot(
        making(brakes, Brake, "brake", "yes", 6.0), making([], Wheels), offers="emergency_stop"
    ) as it:
        assert not (await ended(it.emergency_stop())).ok
        assert (await ended(it.give_up_stop())).ok
        brakes[0].seconds = 0.0
        assert (await ended(it.emergency_stop())).ok
        assert (await ended(it.release_emergency_stop())).ok
        assert it.snapshot.latch is Latch.NONE
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        assert it.snapshot.latch_doubt == "it was answered behind a release"


async def test_a_robot_that_moves_while_it_says_that_it_is_stopped_is_an_alarm() -> None:
    wheels: list[Wheels] = []
    async with robot(making([], Brake, "brake"), making(wheels, Wheels)) as it:
        await until(lambda: it.snapshot.motion.moving)
        wheels[0].stopped, wheels[0].moving = True, False
        await later(2.0)
        assert "moves after stop" not in alarms(it)
        assert word(it) == "✗ STOPPED"
        wheels[0].moving = True
        await until(lambda: "moves after stop" in alarms(it))
        await until(lambda: word(it) == "✗ STILL MOVING")
        wheels[0].stopped = False  # released
        await until(lambda: "moves after stop" not in alarms(it))


async def test_of_two_nodes_that_tell_of_the_motion_none_confirms_a_stop() -> None:
    brakes: list[Brake] = []
    other: list[Wheels] = []
    makers = making(brakes, Brake, "brake", "nothing"), making([], Wheels)
    async with robot(*makers, making(other, Wheels, "other")) as it:
        await until(lambda: "motor_status" in it.snapshot.publishers)
        other[0].moving, other[0].stopped = False, True
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: brakes[0].asked > 1)  # it is sent again
        await later(6.0)
        assert "stop not confirmed" in alarms(it)
        # Readings that come mixed are no doing of another client.
        assert [e.text for e in it.snapshot.events if "by another client" in e.text] == []


async def test_no_goal_is_sent_behind_a_stop_that_is_not_confirmed() -> None:
    brakes: list[Brake] = []
    drives: list[Drive] = []
    makers = making(brakes, Brake, "brake", "nothing"), making([], Wheels)
    async with robot(
        *makers, making(drives, Drive, "drive"), offers="emergency_stop move_to_shelf"
    ) as it:
        assert not (await ended(it.emergency_stop())).ok
        outcome = await ended(go(it, 5))
        said = "the STOP is not confirmed: release it first, or give it up"
        assert outcome == (Code.REFUSED, said)
        queued = await ended(it.send(SHELF, {"shelf_number": 3}, queued=True))
        assert queued == (Code.HELD, "held: STOP")
        asked = brakes[0].asked
        await until(lambda: brakes[0].asked > asked)  # it goes on to be sent
        assert (await ended(it.release_emergency_stop())).ok
        assert (await ended(go(it, 6))).ok
        assert drives[0].shelves == [6]
        assert (await ended(it.cancel())).ok


async def test_a_confirmed_stop_that_the_robot_never_reports_is_not_called_idle() -> None:
    wheels: list[Wheels] = []
    async with robot(making([], Brake, "brake"), making(wheels, Wheels)) as it:
        await until(lambda: it.snapshot.motion.moving)
        wheels[0].moving = False
        await until(lambda: word(it) == "● IDLE")
        assert (await ended(it.emergency_stop())).ok
        await later(3.0)
        assert word(it) == "✗ STOP CONFIRMED, not reported by the robot"
        assert (await ended(it.release_emergency_stop())).ok
        await until(lambda: word(it) == "● IDLE")


def word(it: Robot) -> str:
    return plain_text(motion_word(it.snapshot, clock.seconds(), 80))
