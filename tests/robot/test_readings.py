"""The robot's readings: what is not one is said and not guessed, whatever is published."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float32, String

from archo_tui.robot.messages import types
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.state.frames import MOST_FRAMES, Frame, Transforms, faults, with_transforms
from archo_tui.robot.state.readings import DiagnosticLevel
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.telemetry import ClockOffsets, Diagnostics
from archo_tui.screen.widgets.bars import header
from archo_tui.text.graph import NONE, transform_lines
from archo_tui.text.state import age_text, battery_line, battery_word, motion_word
from tests.support import chosen, clock
from tests.support.alarms import alarms_of, conditions
from tests.support.clock import NOW
from tests.support.console import console
from tests.support.night import corners
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot, texts
from tests.support.stand_in import Made, StandIn
from tests.support.states import NORMAL, plain_text


def publisher(
    kind: Any, topic: str, *messages: Any, period: float = 1.0, qos: Any = 10
) -> Callable[..., Node]:
    """A node that publishes these in turn."""

    class Publisher(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__(f"publisher_{topic}", **options)
            self.sent = 0
            self.publisher = self.create_publisher(kind, topic, qos)
            self.create_timer(period, self.publish)

        def publish(self) -> None:
            self.publisher.publish(messages[self.sent % len(messages)])
            self.sent += 1

    return Publisher


def battery(**fields: Any) -> Callable[..., Node]:
    return publisher(BatteryStatus, "battery_level", BatteryStatus(**fields))


def text(snapshot: Snapshot) -> str:
    return plain_text(battery_line(snapshot, clock.seconds(), 80))


@pytest.mark.parametrize(
    "quality", [10, QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)]
)
async def test_a_float32_battery_is_heard_however_it_is_published(quality: Any) -> None:
    async with robot(publisher(Float32, "battery_level", Float32(data=55.5), qos=quality)) as it:
        await until(lambda: it.snapshot.battery.percentage == 55.5)
        assert (it.snapshot.battery.voltage, it.snapshot.battery.health) == (None, None)


async def test_a_reading_that_was_latched_before_is_shown() -> None:
    def latched(**options: Any) -> Node:
        node = Node("latched", **options)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_publisher(Float32, "battery_level", kept).publish(Float32(data=42.0))
        return node

    async with robot(latched) as it:
        await until(lambda: it.snapshot.battery.percentage == 42.0)


async def test_a_topic_of_an_unknown_type_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    load_class = types.load_class
    monkeypatch.setattr(
        "archo_tui.robot.telemetry.load_class",
        lambda name: None if name == "std_msgs/msg/Float32" else load_class(name),
    )
    async with robot(publisher(Float32, "battery_level", Float32())) as it:
        said = "battery_level is std_msgs/msg/Float32, which is not installed here"
        await until(lambda: texts(it) == [said])
        await until(lambda: len(it.snapshot.nodes) == 1)
        assert [e.count for e in it.snapshot.events] == [1]


@pytest.mark.parametrize("value", corners([float("nan")], [3e38]))
async def test_a_percentage_that_cannot_be_is_shown_as_received_and_is_not_good(
    value: float,
) -> None:
    async with console(
        node_makers=[publisher(Float32, "battery_level", Float32(data=value))], wait=False
    ) as op:
        await op.until("? UNREADABLE ")
        assert "GOOD" not in op.text
        assert "LOW" not in op.text
        assert op.app.view.snapshot.battery.percentage is None
        said = [e for e in op.app.view.snapshot.events if "is not within 0 .. 100" in e.text]
        assert len(said) == 1
        assert said[0].count == 1
        await op.press("f1")  # it lives
        await op.until("STOP is a software stop")


@pytest.mark.parametrize(
    ("topic", "kinds"),
    [
        ("battery_level", "archo_interfaces/msg/BatteryStatus or std_msgs/msg/Float32"),
        ("motor_status", "archo_interfaces/msg/MotorStatus"),
    ],
)
async def test_another_type_on_a_topic_is_said_and_not_guessed_at(topic: str, kinds: str) -> None:
    async with robot(publisher(String, topic, String(data="x"))) as it:
        await until(lambda: topic in it.snapshot.faults)
        fault = f"{topic} is std_msgs/msg/String: expected {kinds}"
        assert it.snapshot.faults[topic] == fault
        assert [e.text for e in it.snapshot.events] == [fault]
        assert battery_word(it.snapshot)[1] == "NO DATA"
        assert "IDLE" not in plain_text(motion_word(it.snapshot, clock.seconds(), 80))


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="Fast DDS has one type a topic")
async def test_a_topic_of_two_types_that_would_both_do_is_said() -> None:
    one, other = publisher(Float32, "battery_level", Float32(data=50.0)), Made(Node, "other")
    said = "battery_level has several types: archo_interfaces/msg/BatteryStatus, "
    async with robot(one, other) as it:
        other.node.create_publisher(BatteryStatus, "battery_level", 10)
        await until(lambda: f"{said}std_msgs/msg/Float32" in texts(it))


async def test_an_unknown_word_of_health_is_shown_and_hides_no_low_battery() -> None:
    async with robot(battery(percentage=80.0, voltage=24.0, battery_health="swollen")) as it:
        await until(lambda: it.snapshot.battery.received)
        assert battery_word(it.snapshot)[:2] == ("?", "swollen")
        assert "battery health" in alarms_of(it)
    async with robot(battery(percentage=10.0, voltage=21.0, battery_health="swollen")) as it:
        await until(lambda: it.snapshot.battery.received)
        assert battery_word(it.snapshot)[1] == "LOW"


async def test_a_parameter_that_is_no_number_is_not_used_and_the_robot_alone_decides() -> None:
    def stating(name: str, **words: str) -> Callable[..., Node]:
        """A node with parameters of ARCHO's names, which hold words."""

        def make(**options: Any) -> Node:
            made = StandIn(name, goals="arrive" if "motor" in name else "", **options)
            for parameter, value in words.items():
                made.declare_parameter(parameter, value, ignore_override=True)
            return made

        return make

    battery_monitor = stating("battery_monitor", low_battery_threshold="twenty")
    motor = stating("motor_controller", route_length="far", shelf_count="many")
    async with console(node_makers=[battery_monitor, motor], wait=False) as op:
        await op.until("twenty")
        await op.until("far")
        assert op.app.view.snapshot.low_charge == 20.0
        await op.until("low 20")
        await op.press("g", *"4711", "enter")
        await op.until("ARRIVED")


@pytest.mark.waits
async def test_a_new_pace_that_the_operator_sets_is_measured_anew() -> None:
    async with operated(ros_args=("-p", "drain_max:=0.0", "-p", "drain_min:=0.0")) as person:
        it = person._plain._station.robot
        await while_passes(10.0)
        outcome = it.set_parameters("/battery_monitor", {"publish_period": 10.0})
        assert (await ended(outcome)).ok
        for _ in range(4):
            await while_passes(9.0)
            view = person._plain._station.view
            assert "silent" not in header(view, 120).plain
            assert "(old" not in text(it.snapshot)


@pytest.mark.waits
async def test_two_publishers_are_named_in_the_panel_and_an_alarm_when_they_stay() -> None:
    def second(**options: Any) -> Node:
        return battery(percentage=60.0)(cli_args=["--ros-args", "-r", "__node:=second"], **options)

    async with console(node_makers=[battery(percentage=50.0), second], wait=False) as op:
        begin = clock.seconds()
        await op.until("2 publishers: ")
        await op.at(begin + 20)
        assert "PUBLISHERS" not in op.text.splitlines()[1]  # one that was killed lingers so long
        await op.until("2 PUBLISHERS of battery_level: /publisher_battery_level, /second")
        names = conditions(op.app.view.snapshot, clock.seconds())
        assert "several publishers /battery_level" in names


def test_an_age_is_in_seconds_up_to_two_minutes_and_never_wide() -> None:
    told = {
        0.0: "0.0 s",
        9.94: "9.9 s",
        9.96: "10 s",
        61.0: "61 s",
        119.4: "119 s",
        119.9: "120 s",
        120.0: "2 min",
        599.0: "9 min",
        600.0: "0.2 h",
        36_000.0: "10 h",
    }
    assert {seconds: age_text(seconds) for seconds in told} == told
    assert all(len(age_text(tenth / 10)) <= 5 for tenth in range(10_000))


# A topic with several readers is subscribed to once: recorded once, counted once.

FILE = """
version: 1
name: Base
battery: {topic: level, types: {std_msgs/msg/Float32: {percentage: data}}}
gauges:
  - {title: Level, topic: level, type: std_msgs/msg/Float32, field: data, unit: "%"}
stop: none
"""


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "base.yaml"
    made.write_text(FILE)
    return made


async def test_both_are_read_and_the_rate_is_that_of_the_publisher(file: Path) -> None:
    talker = Made(publisher(Float32, "level", Float32(data=80.0), period=0.1))
    async with robot(talker, robot=file) as it:
        await until(lambda: it.snapshot.battery.percentage == 80.0)
        await until(lambda: it.snapshot.gauges[0].value == 80.0)
        await while_passes(3)
        rate = it.snapshot.message_rates["/level"].hertz
        assert rate is not None
        assert 8.0 < rate < 13.0
        assert talker.node.count_subscribers("level") == 1


async def test_a_topic_that_cannot_be_subscribed_to_leaves_the_others_alone(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fast DDS refuses a second type of a topic in one process, for example."""
    file = here / "base.yaml"
    refused = FILE.replace("topic: level", "topic: refused", 1)
    file.write_text(refused + "record: [refused, unread]\n")
    subscribe = ConsoleNode.create_subscription

    def refusing(self: ConsoleNode, kind: Any, topic: str, *rest: Any, **options: Any) -> Any:
        if topic in ("/refused", "/unread"):
            raise RuntimeError("incompatible type")
        return subscribe(self, kind, topic, *rest, **options)

    def both(**options: Any) -> Node:
        node = publisher(Float32, "level", Float32(data=80.0), period=0.1)(**options)
        for topic in ("refused", "unread"):
            node.create_publisher(Float32, topic, 10)
        return node

    monkeypatch.setattr(ConsoleNode, "create_subscription", refusing)
    async with robot(both, robot=file) as it:
        await until(lambda: it.snapshot.gauges[0].value == 80.0)
        reason = "RuntimeError: incompatible type"
        why = f"is std_msgs/msg/Float32, and cannot be subscribed to here: {reason}"
        assert it.snapshot.faults["refused"] == f"refused {why}"
        said = texts(it)
        assert f"refused {why}" in said
        assert f"not recorded: unread {why}" in said
        await while_passes(3)
        assert texts(it) == said


# Diagnostic statuses: levels, silence, and names without end.


def array(*parts: tuple[str, Any, str], hardware: str = "") -> Any:
    return SimpleNamespace(
        status=[
            SimpleNamespace(name=name, level=level, message=message, hardware_id=hardware)
            for name, level, message in parts
        ]
    )


def found(table: Diagnostics) -> list[tuple[str, str, str]]:
    return [(status.part, status.level.value, status.message) for status in table.all]


def test_a_level_is_a_byte_or_a_number_and_an_unknown_one_an_error() -> None:
    table = Diagnostics()
    levels = array(("a", b"\x02", "hot"), ("b", 1, ""), ("c", b"\x00", ""), ("d", b"\x09", ""))
    table.add(levels, 0.0)
    assert [status.level.value for status in table.all] == ["ERROR", "WARN", "OK", "ERROR"]
    assert table.all[0].message == "hot"


def test_silence_of_three_periods_and_five_seconds_is_stale() -> None:
    table = Diagnostics()
    for second in range(20):
        table.add(array(("quick", 0, "")), float(second))
        if second % 4 == 0:
            table.add(array(("slow", 0, "")), float(second))
    quick, slow = table.all
    assert quick.level_at(23.9) is DiagnosticLevel.OK
    assert quick.level_at(24.1) is DiagnosticLevel.STALE
    assert slow.level_at(24.1) is DiagnosticLevel.OK
    assert slow.level_at(28.1) is DiagnosticLevel.STALE


def test_an_error_takes_the_place_of_a_part_that_is_well() -> None:
    table = Diagnostics()
    table.add(array(*((f"part {number}", 0, "") for number in range(1000))), 0.0)
    table.add(array(("late", 2, "hot"), ("later", 0, "")), 1.0)
    assert len(table.all) == 1000
    bad = [status.name for status in table.all if status.level is not DiagnosticLevel.OK]
    assert bad == ["late"]
    table.add(array(*((f"bad {number}", 2, "") for number in range(1010))), 2.0)
    assert len(table.all) == 1000


def test_the_worst_of_several_statuses_of_a_part_in_one_array_stays() -> None:
    table = Diagnostics()
    for second in range(20):
        table.add(array(("a", 1, "w"), ("a", 2, "e"), ("a", 3, "s"), ("a", 0, "")), float(second))
    assert found(table) == [("a", "ERROR", "e")]
    assert table.all[0].period == 1.0


def test_a_status_without_hardware_makes_way_unless_it_is_bad() -> None:
    table = Diagnostics()
    table.add(array(("motor", 0, "Node starting up"), ("fan", 2, "stuck")), 0.0)
    table.add(array(("motor", 0, "fine"), ("fan", 0, "turns"), hardware="sn 12"), 1.0)
    assert found(table) == [
        ("fan", "ERROR", "stuck"),
        ("fan (sn 12)", "OK", "turns"),
        ("motor (sn 12)", "OK", "fine"),
    ]


# Clocks that differ: which stamps count, and when the alarm is over.


def stamp(seconds: float) -> Any:
    return SimpleNamespace(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))


def test_three_stamps_that_are_off_are_a_large_offset_until_the_clock_is_set() -> None:
    offsets = ClockOffsets()
    assert not offsets.add("/base", stamp(97.0), 100.0)
    assert not offsets.add("/base", stamp(97.0), 100.0)
    assert offsets.add("/base", stamp(97.0), 100.0)
    assert offsets.large == {"/base": -3.0}
    assert not offsets.add("/base", stamp(97.1), 100.0)
    assert offsets.add("/base", stamp(100.0), 100.0)
    assert offsets.large == {}


def test_a_late_message_is_no_offset_nor_is_no_stamp() -> None:
    offsets = ClockOffsets()
    for late in (0.0, 5.0, 9.0, 0.2, 7.0):
        offsets.add("/base", stamp(100.0), 100.0 + late)
        offsets.add("/odom", stamp(0.0), 100.0)
    assert offsets.large == {}


def test_the_alarm_names_who_is_off_and_how_far() -> None:
    clocks = NORMAL._replace(clock_offsets={"/base": -3.2, "/odom": 61.0})
    text = "CLOCKS DIFFER: /odom is 61.0 s ahead, /base is 3.2 s behind: set one of them"
    assert conditions(clocks, NOW)["clocks differ"].startswith(text)


class Odometer(Node):
    """Publishes with a stamp of 1970."""

    def __init__(self, **options: Any) -> None:
        from nav_msgs.msg import Odometry

        super().__init__("odometer", **options)
        self.publisher = self.create_publisher(Odometry, "odom", 10)
        message = Odometry()
        message.header.stamp.sec = 5
        self.create_timer(0.1, lambda: self.publisher.publish(message))

    def leave(self) -> None:
        for timer in self.timers:
            timer.cancel()
        self.destroy_publisher(self.publisher)

    def simulate(self) -> None:
        self.create_publisher(Clock, "/clock", 10)


@pytest.mark.parametrize("ends", [Odometer.leave, Odometer.simulate])
async def test_what_left_or_is_simulated_has_no_clock(here: Path, ends: Any) -> None:
    pytest.importorskip("nav_msgs")
    file = here / "base.yaml"
    file.write_text(
        "version: 1\nname: Base\nstop: none\nmotion: {topic: odom, types: "
        "{nav_msgs/msg/Odometry: {speed: twist.twist.linear.x}}}\n"
    )
    made = Made(Odometer)
    async with robot(made, robot=file) as it:
        it.own_nodes = tuple  # As if the node ran on another computer.
        await until(lambda: "/odom" in it.snapshot.clock_offsets)
        ends(made.node)
        await until(lambda: "/odom" not in it.snapshot.clock_offsets)


# Transforms as a table: what came in, and what is said of the frames.

WALL = 1_000_000.0  # Unix time at the time 0 of the tests.


def transform(parent: str, child: str, stamp: float) -> Any:
    """A TransformStamped without its numbers."""
    time = SimpleNamespace(sec=int(stamp), nanosec=round(stamp % 1 * 1e9))
    header = SimpleNamespace(frame_id=parent, stamp=time)
    return SimpleNamespace(header=header, child_frame_id=child)


def heard(*came: tuple[float, str, str, float | None], simulated: bool = False) -> Transforms:
    """What came: when, parent, child and how old its stamp was; None for a static one."""
    frames: dict[str, Frame] = {}
    for now, parent, child, old in came:
        message = [transform(parent, child, WALL + now - (old or 0.0))]
        wall_time = None if simulated else WALL + now
        frames = with_transforms(frames, message, now, wall_time, is_static=old is None)
    return Transforms(frames, ("odometry",), ("state_publisher",))


ODOM = [(t / 10, "odom", "base_link", 0.1) for t in range(11)]  # At 10 Hz, the last at 1.0 s.
LASER = (0.0, "base_link", "laser", None)


def test_each_frame_tells_parent_rate_age_and_who_publishes_it() -> None:
    found = heard(*ODOM, LASER)
    assert transform_lines(found, 1.2) == [
        "base_link in odom: 10.0 Hz, 0.3 s old, from odometry",
        "laser in base_link: static, from state_publisher",
    ]
    several = found._replace(publishers=("amcl", "odometry"), static_publishers=())
    assert transform_lines(several, 1.2) == [
        "base_link in odom: 10.0 Hz, 0.3 s old, from one of amcl, odometry",
        "laser in base_link: static, its publisher has left",
    ]


def test_a_frame_falls_silent_unless_it_is_static() -> None:
    lines = transform_lines(heard(*ODOM, LASER), 61.0)
    assert lines == [
        "base_link in odom: SILENT for 60 s, from odometry",
        "laser in base_link: static, from state_publisher",
    ]


@pytest.mark.parametrize(
    ("came", "now", "said"),
    [
        ([*ODOM, LASER], 1.0, []),
        (
            [*ODOM, (1.0, "map", "base_link", 0.0)],
            1.0,
            ["base_link has 2 parents, map and odom: a frame has one"],
        ),
        ([*ODOM, (10.9, "map", "base_link", 0.0)], 12.0, []),  # Odometry has stopped by then.
        (
            [LASER, (20.0, "tower", "laser", 0.0)],
            20.0,
            ["laser has 2 parents, base_link and tower: a frame has one"],
        ),
        (
            [*ODOM, (1.0, "map", "dock", None)],
            1.0,
            ["the tree is in 2 parts, no transform joins them: base_link, odom; dock, map"],
        ),
        (
            [(0.0, "map", name, None) for name in "abcd"] + [(0.0, "e", "f", None)],
            0.0,
            ["the tree is in 2 parts, no transform joins them: a, b, c and 2 more; e, f"],
        ),
        (
            [(0.0, "odom", "base_link", -3.0)],
            0.0,
            ["the stamp of base_link is 3.0 s in the future: compare the clocks"],
        ),
        ([(0.0, "odom", "base_link", -0.2)], 0.0, []),
    ],
)
def test_what_is_wrong_is_said_in_words(came: Any, now: float, said: list[str]) -> None:
    assert list(faults(heard(*came), now)) == said
    assert transform_lines(heard(*came), now)[: len(said)] == [f"▲ {text}" for text in said]


def test_a_stamp_in_simulated_time_tells_no_age() -> None:
    found = heard((5.0, "odom", "base_link", WALL), simulated=True)
    assert found.frames["base_link"].age(5.5) == pytest.approx(0.5)
    assert list(faults(found, 5.5)) == []


def test_no_transforms_are_said_to_be_none_and_endless_ones_are_bounded() -> None:
    assert transform_lines(Transforms(), 0.0) == [NONE]
    waiting = Transforms(publishers=("odometry",))
    assert transform_lines(waiting, 0.0) == ["no transform came so far from odometry"]
    many = [transform("map", f"frame{n}", WALL) for n in range(MOST_FRAMES + 5)]
    assert len(with_transforms({}, many, 0.0, WALL, is_static=False)) == MOST_FRAMES
