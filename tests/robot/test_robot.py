"""Robot's requests all end: done, refused with the reason, or no answer. No screen here."""

from __future__ import annotations

import asyncio
import gc
import os
import threading
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus, MotorStatus
from archo_interfaces.srv import ResetEncoder
from rcl_interfaces import srv
from rclpy.action import ActionServer
from rclpy.node import Node

from archo_tui.robot.goals.machine import Event, TrackedGoal
from archo_tui.robot.outcome import Code
from archo_tui.robot.runtime import PERIOD as SENT
from archo_tui.robot.runtime import Mailbox
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.graph import Parameter, linked_number
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import ParameterRef
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.archo import go, reset
from tests.support.clock import NOW
from tests.support.night import corners
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot
from tests.support.stand_in import Made, StandIn
from tests.support.states import goal


def server(*, hang: threading.Event | None = None, end: str = "succeed") -> Any:
    """A node with the encoder service and the action; may hang in both."""

    class Server(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("server", **options)
            self.create_service(ResetEncoder, "reset_encoder", self.reset)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

        def reset(self, request: Any, response: Any) -> Any:
            if hang is not None:
                with clock.stuck():
                    hang.wait(30)
            response.success, response.message = False, "the encoder is stuck"
            return response

        def execute(self, goal: Any) -> Any:
            if hang is not None:
                with clock.stuck():
                    hang.wait(30)
            getattr(goal, end)()
            return MoveToShelf.Result(success=end == "succeed", final_message="that was it")

    return Server


async def test_what_nobody_offers_is_said() -> None:
    async with robot(Made(Node, "quiet")) as it:
        assert it.snapshot.offered == frozenset()
        outcome = await ended(reset(it))
        assert outcome == (Code.NOT_OFFERED, "/reset_encoder is not offered by any node")
        outcome = await ended(it.cancel())
        assert outcome == (Code.REFUSED, "no goal is running")


async def test_a_goal_without_an_answer_is_unknown_until_the_robot_says_more() -> None:
    hang = threading.Event()
    async with robot(server(hang=hang), offers="reset_encoder") as it:
        hung = await ended(reset(it))  # the server hangs in it, and has not seen the goal
        assert (hung.code, hung.text[:13]) == (Code.TIMEOUT, "no answer in ")
        outcome = await ended(go(it, 3))
        assert not outcome.ok
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.UNKNOWN
        assert it.snapshot.goal.is_running
        assert (await ended(it.cancel())).text == "no answer to the cancel in 4 s"
        hang.set()
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ARRIVED)
        assert (await ended(reset(it))).text == "the encoder is stuck"


@pytest.mark.parametrize(("end", "phase"), [("succeed", Phase.ARRIVED), ("abort", Phase.ABORTED)])
async def test_a_goal_ends_as_the_server_says(end: str, phase: Phase) -> None:
    async with robot(server(end=end), offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == phase)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message == "that was it"
        assert [goal.target for goal in it.snapshot.history] == ["3"]
        assert GoalStatus.STATUS_ABORTED == 6


async def test_every_verb_leaves_a_line_with_its_ros2_command() -> None:
    async with robot(server(), offers="reset_encoder") as it:
        assert await ended(reset(it)) == (Code.REFUSED, "the encoder is stuck")
        await it.set_parameters("/server", {"use_sim_time": True})
        await ended(go(it, 7))
        await until(lambda: len([e for e in it.snapshot.events if e.level == "YOU"]) == 3)
        assert [e.command for e in it.snapshot.events if e.level == "YOU"] == [
            "ros2 service call /reset_encoder archo_interfaces/srv/ResetEncoder '{}'",
            "ros2 param set /server use_sim_time true",
            "ros2 action send_goal /move_to_shelf archo_interfaces/action/MoveToShelf "
            "'{shelf_number: 7}' --feedback",
        ]


async def test_who_watches_sends_nothing_whoever_asks_for_it() -> None:
    watched = Made(StandIn, "watched", "yes", goals="arrive")
    async with robot(watched, watch=True, offers="move_to_shelf emergency_stop") as it:
        for outcome in (await ended(go(it, 3)), await ended(it.emergency_stop())):
            assert outcome.code == Code.WATCHING
            assert outcome.text.startswith("watching only")
    assert (watched.node.stops, watched.node.shelves) == ([], [])


async def test_a_toggle_of_what_is_no_bool_is_said_before_it_is_called(here: Path) -> None:
    def counter(**options: Any) -> Node:
        node = Node("counter", **options)
        node.create_service(srv.GetParameterTypes, "count", lambda _, response: response)
        return node

    file = here / "robot.yaml"
    file.write_text(
        "battery: {topic: b, types: {std_msgs/msg/Float32: {percentage: data}}}\n"
        "commands: [{id: light, title: Light, service: count, toggle: {names: battery.charging}}]\n"
    )
    async with robot(counter, robot=file) as it:
        await until(lambda: "count" in it.snapshot.faults)
        assert it.snapshot.faults["count"].endswith("whose names is sequence<string>: not called")


def test_the_time_that_is_left_counts_down_between_two_feedbacks() -> None:
    way = tuple((NOW - ago, 9.0 + ago * 9.0 / 4.0) for ago in (2.0, 1.0, 0.0))
    state = goal(Phase.MOVING, heard=NOW, remaining=9.0, way=way)
    moving = state.goal
    assert moving is not None
    assert moving.seconds_left(NOW) == 4.0
    assert moving.seconds_left(NOW + 1.5) == 2.5
    assert moving.seconds_left(NOW + 4.9) == 0.0
    assert moving.seconds_left(NOW + 9.0) is None


def test_the_words_for_the_end_may_stand_in_a_message_in_the_result() -> None:
    moving = goal(Phase.MOVING).goal
    assert moving is not None
    kind = replace(moving.kind, message="end.words")
    result = SimpleNamespace(end=SimpleNamespace(words="parked"))
    after = TrackedGoal(moving._replace(kind=kind)).answered(0, Event.ARRIVED, result, 0.0).goal
    assert (after.phase, after.message) == (Phase.ARRIVED, "parked")


# A limit that a node holds as a parameter.


@pytest.mark.pure
def test_a_node_that_is_named_from_the_root_is_not_of_the_namespace() -> None:
    fleet = Parameter("/fleet", "racks", "integer", 40, 40)
    ours = fleet._replace(node="/tb1/fleet", value=7)
    assert linked_number([fleet, ours], "/tb1", ParameterRef("fleet", "racks")) == 7
    assert linked_number([fleet, ours], "/tb1", ParameterRef("/fleet", "racks")) == 40


# The way up to the screen is bounded, and starting and stopping leaves nothing behind.


@pytest.mark.pure
async def test_a_stalled_loop_gets_one_call_with_the_newest() -> None:
    door, got = Mailbox(), list[Snapshot]()
    door.open(got.append)

    def flood() -> None:
        for ticks in range(1000):
            door.put(Snapshot()._replace(motion=Motion(count=ticks)))

    thread = threading.Thread(target=flood)
    thread.start()
    thread.join()  # the loop stalls meanwhile, on purpose
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert [snapshot.motion.count for snapshot in got] == [999]
    door.put(Snapshot())
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert len(got) == 2


PERIOD = 0.02  # s between two messages


class Telling(Node):
    """A voltage that goes on, and a motion that stays; an INFO line each time."""

    def __init__(self, **options: Any) -> None:
        super().__init__("telling", **options)
        self.battery = BatteryStatus(percentage=80.0, voltage=24.0, battery_health="good")
        self._batteries = self.create_publisher(BatteryStatus, "battery_level", 10)
        self._motors = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(PERIOD, self.tell)

    def tell(self) -> None:
        self.battery.voltage += 0.001
        self._batteries.publish(self.battery)
        self._motors.publish(MotorStatus())
        self.get_logger().info(f"{self.battery.voltage} V")


@pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="in real time a snapshot comes as late as the machine is"
)
async def test_numbers_and_lines_that_go_on_are_seen_four_times_a_second() -> None:
    async with robot(Telling) as it:
        await while_passes(5.0)
        times: list[float] = []
        it.subscribe(lambda _: times.append(clock.seconds()))
        await while_passes(8.0)
    gaps = [after - before for before, after in pairwise(times)]
    assert max(gaps) <= SENT + 2 * PERIOD
    assert len(times) <= 8.0 / SENT + 1


ROUNDS = 50


def test_what_is_said_behind_the_end_is_heard_by_nobody_and_disturbs_nobody() -> None:
    session = Session(Options(engine=chosen.ENGINE, domain_id=chosen.next_domain()), clock.current)
    session.start()
    assert session.close() == []
    session.robot.note("ERROR", "motor_controller", "crashed")


def descriptors() -> int:
    gc.collect()
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.parametrize("rounds", corners([8], [ROUNDS]))
def test_sessions_in_a_row_leave_no_thread_and_no_descriptor(rounds: int) -> None:
    options = Options(engine=chosen.ENGINE, domain_id=chosen.next_domain())
    with Session(options, clock.current):
        pass  # what is made once, is made now
    before, threads = descriptors(), threading.active_count()
    for _ in range(rounds):
        session = Session(options, clock.current)
        session.start()
        assert session.close() == []
        del session
        if chosen.ENGINE == "ros2":
            gc.collect()  # rclpy frees a context's descriptors with its last reference
    assert threading.active_count() == threads
    assert descriptors() <= before + 4
