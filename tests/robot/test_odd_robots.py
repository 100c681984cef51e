"""Robots that do what is allowed and rare."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from archo_interfaces.msg import MotorStatus
from archo_interfaces.srv import EmergencyStop
from rcl_interfaces import srv
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from std_msgs.msg import Float32

from archo_tui.robot.clients import CLIENT, CONSOLE, UnexplainedChanges
from archo_tui.robot.goals.machine import Event, TrackedGoal
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.readings import Motion
from tests.support import clock
from tests.support.clock import NOW
from tests.support.console import console, screen_text
from tests.support.quiet import Quiet, ended, until
from tests.support.robot import making, robot
from tests.support.states import goal
from tests.support.stub import stub_app


class Unset(Node):
    """Has a parameter that was declared and never set, and one that is not a number."""

    def __init__(self, **options: Any) -> None:
        super().__init__("unset", **options)
        self.declare_parameter("speed", 0.5)
        self.declare_parameter("later", Parameter.Type.DOUBLE)
        self.declare_parameter("odd", float("nan"))


async def test_a_parameter_without_a_value_hides_none_of_the_others() -> None:
    async with robot(Unset) as it:
        await until(lambda: it.snapshot.parameter("speed"))
        known = {p.name: p for p in it.snapshot.parameters}
        assert (known["speed"].value, known["later"].value) == (0.5, None)
        assert known["later"].type == "double"
        assert not known["odd"].is_changed
        assert (await ended(it.set_parameters("/unset", {"later": 1.5}))).ok
        await until(lambda: it.snapshot.parameter("later").value == 1.5)  # type: ignore[union-attr]


async def test_a_value_that_is_not_read_back_is_not_said_to_be_as_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with robot(Unset) as it:
        await until(lambda: it.snapshot.parameter("speed"))
        call = it.node.call

        async def hangs(kind: Any, *given: Any, **options: Any) -> Any:
            return None if kind is srv.GetParameters else await call(kind, *given, **options)

        monkeypatch.setattr(it.node, "call", hangs)
        outcome = await ended(it.set_parameters("/unset", {"speed": 0.7}))
        said = "accepted, but /unset has not reported the new value; speed was 0.5"
        assert outcome == (Code.DONE, said)


async def test_a_parameter_without_a_value_is_edited_from_an_empty_field() -> None:
    async with console(node_makers=[Unset], wait=False) as op:
        await op.until("later")
        assert "--" in op.line("later")
        assert "*" not in op.line("odd")
        await op.press("4", "slash", *"later", "enter")
        await op.at(clock.seconds() + 1.0)
        await op.press("enter", *"2.5", "enter")
        await op.until("2.5 *")


class Latched(Node):
    """Says its charge once, to whoever comes later, too."""

    def __init__(self, **options: Any) -> None:
        super().__init__("latched", **options)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.battery = self.create_publisher(Float32, "battery_level", kept)
        self.battery.publish(Float32(data=42.0))


async def test_a_reading_that_was_latched_before_is_shown() -> None:
    async with robot(Latched) as it:
        await until(lambda: it.snapshot.battery.percentage == 42.0)


async def test_the_header_does_not_say_online_beside_a_goal_that_is_lost() -> None:
    app = stub_app(goal(Phase.LOST, heard=NOW - 3.2))
    async with app.run_test(size=(120, 36)):
        await Quiet(app).settle()
        assert "● online" not in screen_text(app)
        assert "▲ move_to_shelf silent" in screen_text(app)


def test_the_time_that_is_left_counts_down_between_two_feedbacks() -> None:
    way = tuple((NOW - ago, 9.0 + ago * 9.0 / 4.0) for ago in (2.0, 1.0, 0.0))
    state = goal(Phase.MOVING, heard=NOW, remaining=9.0, way=way)
    moving = state.goal
    assert moving is not None
    assert moving.seconds_left(NOW) == 4.0
    assert moving.seconds_left(NOW + 1.5) == 2.5
    assert moving.seconds_left(NOW + 4.9) == 0.0
    assert moving.seconds_left(NOW + 9.0) is None


def set_(node: str, code: Code = Code.DONE, **values: Any) -> AuditRecord:
    return AuditRecord("set", {"node": node, "values": values}, code)


def test_what_was_not_answered_in_time_is_ours_when_it_is_done_later() -> None:
    others = UnexplainedChanges()
    others.on_audit_record(set_("/motor", Code.TIMEOUT, speed=0.5), 10.0)
    others.on_audit_record(set_("/motor", ramp=2.0), 10.0)
    others.on_parameter("/motor", "speed", 1.0, 0.5, 15.0)
    others.on_parameter("/motor", "ramp", 2.0, 3.0, 15.0)
    assert others.take_due(19.5) == ["motor ramp changed by another client: 3.0, was 2.0"]
    others.on_parameter("/motor", "speed", 0.5, 0.6, 40.0)
    assert others.take_due(44.5) == ["motor speed changed by another client: 0.6, was 0.5"]


def test_what_a_console_says_late_is_still_its_doing() -> None:
    others = UnexplainedChanges()
    moving = Motion(count=1, moving=True, stopped=False, received=10.0)
    others.on_motion(moving, 10.0)
    others.on_motion(replace(moving, stopped=True, received=10.2), 10.2)
    assert others.take_due(13.0) == []
    others.on_audit_record(AuditRecord("stop", {}, Code.TIMEOUT), 13.1)
    assert others.take_due(20.0) == []


@pytest.mark.pure
@pytest.mark.parametrize(
    ("record", "is_explained"),
    [
        (set_("/motor", speed=0.5), True),
        (set_("/motor", ramp=1.0, speed=0.5), True),
        (set_("/motor", Code.REFUSED, speed=0.5), True),  # it may have been done in part
        (set_("/motor", Code.CANCELLED, speed=0.5), False),  # it never left
        (set_("/motor", ramp=2.0), False),
        (set_("/other", speed=0.5), False),
        (AuditRecord("stop", {"node": "/motor", "values": {"speed": 0.5}}, Code.DONE), False),
        (AuditRecord("set", {"node": "/motor", "values": "speed"}, Code.DONE), False),
        (AuditRecord("set", {}, Code.DONE), False),
    ],
)
def test_a_change_of_a_parameter_is_explained_by_its_node_and_name(
    record: AuditRecord, is_explained: bool
) -> None:
    others = UnexplainedChanges()
    others.on_audit_record(record, 10.0)
    others.on_parameter("/motor", "speed", 1.0, 0.5, 10.5)
    said = [] if is_explained else ["motor speed changed by another client: 0.5, was 1.0"]
    assert others.take_due(15.0) == said


def test_where_a_console_does_not_tell_what_it_does_it_may_have_been_that() -> None:
    others = UnexplainedChanges()
    others.author = CONSOLE
    others.on_parameter("/motor", "speed", 1.0, 0.5, 10.0)
    others.author = CLIENT  # it has left since
    assert others.take_due(15.0) == ["motor speed changed by another console: 0.5, was 1.0"]


class Dazed(Node):
    """Takes a STOP only after it has been woken, and says how it moves meanwhile."""

    def __init__(self, **options: Any) -> None:
        super().__init__("dazed", **options)
        self.is_awake = self.is_stopped = False
        self.never: Future[bool] = Future()
        group = ReentrantCallbackGroup()
        self.create_service(EmergencyStop, "emergency_stop", self.stop, callback_group=group)
        self.motion = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(0.2, self.tell)

    async def stop(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        if not self.is_awake:
            await self.never
        response.success = self.is_stopped = True
        return response

    def tell(self) -> None:
        self.motion.publish(MotorStatus(emergency_stopped=self.is_stopped))


async def test_a_stop_that_is_sent_again_is_not_another_clients() -> None:
    made: list[Dazed] = []
    async with robot(making(made, Dazed)) as it:
        await until(lambda: it.snapshot.motion.received is not None)
        assert not (await ended(it.emergency_stop())).ok
        later = clock.seconds() + 3.0
        await until(lambda: clock.seconds() > later)
        made[0].is_awake = True
        made[0].never.set_result(True)  # what was sent before is answered, too
        await until(lambda: it.snapshot.motion.stopped)
        later = clock.seconds() + 6.0
        await until(lambda: clock.seconds() > later)
        texts = [event.text for event in it.snapshot.events]
        assert not any("another client" in text for text in texts)
        ends = ("STOP, ", "STOP: the robot says")
        assert len([text for text in texts if text.startswith(ends)]) == 1, texts


def test_the_words_for_the_end_may_stand_in_a_message_in_the_result() -> None:
    moving = goal(Phase.MOVING).goal
    assert moving is not None
    kind = replace(moving.kind, message="end.words")
    result = SimpleNamespace(end=SimpleNamespace(words="parked"))
    after = TrackedGoal(moving._replace(kind=kind)).answered(0, Event.ARRIVED, result, 0.0).goal
    assert (after.phase, after.message) == (Phase.ARRIVED, "parked")


class Counter(Node):
    """Serves what the robot file toggles, but by a number."""

    def __init__(self, **options: Any) -> None:
        super().__init__("counter", **options)
        self.asked: list[Any] = []
        self.create_service(srv.GetParameterTypes, "count", self.count)

    def count(self, request: Any, response: Any) -> Any:
        self.asked.append(request)
        return response


async def test_a_toggle_of_what_is_no_bool_is_said_before_it_is_called(here: Path) -> None:
    file = here / "robot.yaml"
    file.write_text(
        "battery: {topic: b, types: {std_msgs/msg/Float32: {percentage: data}}}\n"
        "commands: [{id: light, title: Light, service: count, toggle: {names: battery.charging}}]\n"
    )
    async with robot(Counter, robot=file) as it:
        await until(lambda: "count" in it.snapshot.faults)
        assert it.snapshot.faults["count"].endswith("whose names is sequence<string>: not called")


class Mute(Node):
    """Offers its parameters and never answers when asked for them."""

    def __init__(self, **options: Any) -> None:
        super().__init__("mute", **options, start_parameter_services=False)
        self.asked: list[float] = []
        self.never: Future[bool] = Future()
        group = ReentrantCallbackGroup()
        for name in ("list", "get", "describe"):
            kind = getattr(srv, f"{name.capitalize()}Parameters")
            self.create_service(kind, f"~/{name}_parameters", self.ask, callback_group=group)

    async def ask(self, _: Any, response: Any) -> Any:
        self.asked.append(clock.seconds())
        await self.never
        return response


async def test_a_node_that_never_answers_is_asked_ever_more_rarely_but_not_never() -> None:
    made: list[Mute] = []
    async with robot(making(made, Mute)):
        await until(lambda: made[0].asked)
        # so long as real time may take: two questions; a clock that is moved, ten minutes
        end = made[0].asked[0] + (10.0 if clock.current is None else 600.0)
        while clock.seconds() < end:
            step = clock.seconds() + 90.0 if clock.current is not None else end
            await until(lambda step=step: clock.seconds() >= step)  # type: ignore[misc]
        gaps = [b - a for a, b in zip(made[0].asked, made[0].asked[1:], strict=False)]
        assert gaps
        assert max(gaps) < 80.0  # 60 s, the answers' deadlines and a look
