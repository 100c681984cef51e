"""Several servers of one name: a stale launch, two robots. And a STOP that is not confirmed."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from archo_interfaces.srv import EmergencyStop
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float32

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Latch, OpenStop, StopAnswer
from tests.support import clock
from tests.support.alarms import conditions
from tests.support.archo import go
from tests.support.clock import NOW
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.ros import begin
from tests.support.states import STATES


class Brake(Node):
    """Serves STOP: says yes, no, or nothing before it is woken; after so many seconds."""

    def __init__(
        self,
        name: str,
        says: str = "yes",
        seconds: float = 0.0,
        *,
        serves: bool = True,
        **options: Any,
    ) -> None:
        super().__init__(name, **options)
        self.says, self.seconds, self.asked = says, seconds, 0
        self.awake: Future[bool] = Future()
        self.service: Any = None
        if serves:
            self.offer()
        self.battery = self.create_publisher(Float32, "battery_level", 10)
        self.create_timer(0.5, lambda: self.battery.publish(Float32(data=80.0)))

    def offer(self) -> None:
        group = ReentrantCallbackGroup()
        self.service = self.create_service(
            EmergencyStop, "emergency_stop", self.stop, callback_group=group
        )

    def leave(self) -> None:
        self.destroy_service(self.service)

    async def stop(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        self.asked += 1
        if self.says == "nothing":
            await self.awake
        if self.seconds:
            over: Future[bool] = Future(executor=self.executor)
            timer = self.create_timer(self.seconds, lambda: over.set_result(True))
            await over
            self.destroy_timer(timer)
        response.success, response.message = self.says != "no", f"{self.get_name()} {self.says}"
        return response


class Drive(Node):
    """Serves the action; its goals run until they are cancelled."""

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self.shelves: list[int] = []
        self.over: Future[bool] = Future()
        self.action = ActionServer(
            self, MoveToShelf, "move_to_shelf", self.drive, cancel_callback=self.cancel
        )

    def cancel(self, _: Any) -> CancelResponse:
        self.over.set_result(True)
        return CancelResponse.ACCEPT

    def leave(self) -> None:
        self.action.destroy()
        self.destroy_node()

    async def drive(self, goal: Any) -> MoveToShelf.Result:
        self.shelves.append(goal.request.shelf_number)
        await self.over
        goal.canceled()
        return MoveToShelf.Result(final_message="called back")


def alarms(it: Any) -> dict[str, str]:
    return conditions(it.snapshot, clock.seconds())


@pytest.mark.parametrize(
    ("says", "code", "said"),
    [
        ("yes", Code.DONE, "yes"),
        ("no", Code.REFUSED, "REFUSED by 1 of 2: b no: use the hardware stop"),
        ("nothing", Code.TIMEOUT, "1 of 2 answered in 3 s: use the hardware stop"),
    ],
)
async def test_one_stop_counts_the_answers_of_all_its_servers(
    says: str, code: Code, said: str
) -> None:
    made: list[Brake] = []
    makers = making(made, Brake, "a"), making(made, Brake, "b", says)
    async with robot(*makers) as it:
        await until(lambda: "emergency_stop" in it.snapshot.duplicate_servers)
        outcome = await ended(it.emergency_stop())
        assert outcome.code == code
        assert said in outcome.text
        assert all(brake.asked for brake in made)
        assert (it.snapshot.open_stop is None) == outcome.ok
        for brake in made:
            brake.awake.set_result(True)


async def test_two_servers_of_stop_are_an_alarm_that_names_them() -> None:
    made: list[Brake] = []
    async with robot(making(made, Brake, "a"), making(made, Brake, "b")) as it:
        await until(lambda: "several stops" in alarms(it))
        assert "2 NODES SERVE emergency_stop: /a, /b:" in alarms(it)["several stops"]
        assert "hardware stop" in alarms(it)["several stops"]


@pytest.mark.parametrize("seconds", [(2.5,), (0.0, 3.5)])
async def test_a_stop_that_is_always_answered_late_is_confirmed(seconds: tuple[float]) -> None:
    made: list[Brake] = []
    makers = [making(made, Brake, f"brake_{s:.0f}", "yes", s) for s in seconds]
    async with robot(*makers) as it:
        await until(lambda: it.snapshot.battery.received is not None)
        await until(lambda: "emergency_stop" in it.snapshot.offered)
        await until(lambda: len(made) == 1 or "emergency_stop" in it.snapshot.duplicate_servers)
        assert not (await ended(it.emergency_stop())).ok
        assert it.snapshot.open_stop
        assert it.snapshot.open_stop.answer == StopAnswer.NONE
        until_then = clock.seconds() + 3.0
        await until(lambda: it.snapshot.open_stop is None or clock.seconds() > until_then)
        assert it.snapshot.open_stop is None
        told = "STOP, answered late: confirmed: brake_"
        await until(lambda: any(e.text.startswith(told) for e in it.snapshot.events))


async def test_a_stop_that_was_refused_is_sent_again_until_there_is_a_yes() -> None:
    made: list[Brake] = []
    async with robot(making(made, Brake, "a", "no")) as it:
        await until(lambda: it.snapshot.battery.received is not None)
        first = clock.seconds()
        assert not (await ended(it.emergency_stop())).ok
        assert alarms(it)["stop not confirmed"] == "STOP REFUSED (a no): use the hardware stop"
        await until(lambda: made[0].asked >= 4)
        assert clock.seconds() - first > 2.9  # a second between two
        repeats = [e for e in it.snapshot.events if e.text == "STOP, sent again: REFUSED: a no"]
        assert [event.count for event in repeats] in ([2], [3])
        made[0].says = "yes"
        await until(lambda: it.snapshot.open_stop is None)
        assert it.snapshot.latch is Latch.HELD
        said = "STOP, sent again: confirmed: a yes"
        await until(lambda: said in {event.text for event in it.snapshot.events})
        asked, later = made[0].asked, clock.seconds() + 3.0
        await until(lambda: clock.seconds() > later)
        assert made[0].asked == asked


async def test_a_stop_that_nobody_could_be_sent_is_sent_once_somebody_serves_it() -> None:
    made: list[Brake] = []
    async with robot(making(made, Brake, "late", serves=False)) as it:
        await until(lambda: it.snapshot.battery.received is not None)
        assert not (await ended(it.emergency_stop())).ok
        begin(made[0], made[0].offer)
        said = "STOP, sent now: confirmed: late yes"
        await until(lambda: said in {event.text for event in it.snapshot.events})
        assert made[0].asked == 1
        assert it.snapshot.open_stop is None
        assert "stop not confirmed" not in alarms(it)


async def test_a_stop_is_given_up_when_the_operator_says_so() -> None:
    made: list[Brake] = []
    async with robot(making(made, Brake, "a", "nothing")) as it:
        await until(lambda: it.snapshot.battery.received is not None)
        assert not (await ended(it.emergency_stop())).ok
        assert (await ended(it.give_up_stop())).ok
        assert "stop not confirmed" not in alarms(it)
        asked, later = made[0].asked, clock.seconds() + 3.0
        await until(lambda: clock.seconds() > later)
        assert made[0].asked <= asked + 1  # one may have been on its way
        made[0].awake.set_result(True)


async def test_a_goal_is_not_sent_to_an_action_with_two_servers() -> None:
    made: list[Drive] = []
    async with robot(making(made, Drive, "a"), making(made, Drive, "b")) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.duplicate_servers)
        outcome = await ended(go(it, 3))
        assert not outcome.ok
        assert outcome.text == (
            "move_to_shelf is served by /a and /b: each would drive; stop all but one"
        )
        assert it.snapshot.faults["move_to_shelf"] == outcome.text
        assert [drive.shelves for drive in made] == [[], []]


@pytest.mark.waits
async def test_a_server_that_does_not_know_the_goal_is_not_believed_beside_another() -> None:
    made: list[Drive] = []
    async with robot(making(made, Drive, "a"), offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        executor = made[0].executor
        assert executor is not None
        late: Any = Drive("b", context=made[0].context)
        executor.create_task(executor.add_node, late)
        await until(lambda: "move_to_shelf" in it.snapshot.duplicate_servers)
        later = clock.seconds() + 20.0  # it sends no feedback
        await until(lambda: clock.seconds() > later)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.is_running, it.snapshot.goal
        await ended(it.cancel())  # Either may answer first.
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.CANCELLED)
        executor.create_task(late.destroy_node)


class Running(Node):
    """Says that it moves, whatever becomes of the action."""

    def __init__(self, **options: Any) -> None:
        super().__init__("running", **options)
        motion = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(0.2, lambda: motion.publish(MotorStatus(moving=True)))


@pytest.mark.parametrize("is_cancelled", [False, True])
async def test_a_goal_of_a_restarted_server_does_not_run_for_ever(
    is_cancelled: bool,
) -> None:
    made: list[Drive] = []
    async with robot(making(made, Drive, "a"), Running, offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        executor = made[0].executor
        assert executor is not None
        leaving = executor.create_task(made[0].leave)
        again: Any = Drive("a", context=made[0].context)
        executor.create_task(executor.add_node, again)
        end = clock.seconds() + 20.0
        if is_cancelled:
            await until(leaving.done)  # else the cancel may reach the one that knows the goal
            await until(lambda: it.snapshot.duplicate_servers == {})
            assert not (await ended(it.cancel())).ok
            if clock.current is not None:  # on real ROS 2 the answer itself may come late
                end = clock.seconds() + 0.5
        await until(lambda: clock.seconds() > end or it.snapshot.history)
        assert it.snapshot.history
        assert it.snapshot.history[0].message.startswith("the robot no longer knows this goal")
        executor.create_task(again.leave)


async def test_moving_behind_a_stop_that_is_not_confirmed_is_an_alarm() -> None:
    moving = STATES["motor moving"]._replace(open_stop=OpenStop(NOW - 3, StopAnswer.NONE))
    assert "moves after stop" in conditions(moving, NOW)
    assert "moves after stop" not in conditions(
        moving._replace(open_stop=OpenStop(NOW, StopAnswer.NONE)), NOW
    )
    assert "moves after stop" not in conditions(moving._replace(open_stop=None), NOW)
