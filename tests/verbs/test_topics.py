"""`echo`, `hz`, `interface`: what is on a topic; `pub`: what keeps a robot from driving unasked."""

from __future__ import annotations

import json
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from archo_bringup.battery_monitor import BatteryMonitor
from archo_bringup.motor_controller import MotorController
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32, Header, String

from archo_tui.robot_file import load
from archo_tui.screen.commands.generic import _publish_values
from archo_tui.text.nodes import node_rows
from archo_tui.verbs.goals import Cancel
from archo_tui.verbs.topics import Publish
from tests.support.clock import seconds
from tests.support.console import console
from tests.support.plain import Typed, operated, plain
from tests.support.quiet import until, while_passes
from tests.support.robot import hearing
from tests.support.ros import begin
from tests.support.shells import served, typed
from tests.support.shells import until as until_beside
from tests.support.states import NORMAL
from tests.support.stub import StubRobot, stub_station

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TALKERS: list[Talker] = []


class Talker(Node):
    """Publishes a count at 20 Hz, and less often, once, and never; it hears what nobody sends."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        self._counts, self._fast = 0, self.create_publisher(Float32, "fast", 10)
        self._fast_timer = self.create_timer(0.05, self._publish)
        slow = self.create_publisher(Header, "slow", 10)
        self.slow_timer = self.create_timer(1.0, lambda: slow.publish(Header(frame_id="map")))
        rare = self.create_publisher(Float32, "rare", 10)
        self.create_timer(2.0, lambda: rare.publish(Float32(data=0.5)))
        self._kept = self.create_publisher(String, "kept", LATCHED)
        self._kept.publish(String(data="once"))
        self._silent = self.create_publisher(Header, "silent", 10)
        self.create_subscription(String, "heard", lambda _: None, 10)
        TALKERS[:] = [self]

    def leave_fast(self) -> None:
        """Publish nothing more on `fast`, and leave it."""
        self._fast_timer.cancel()
        self.destroy_publisher(self._fast)

    def _publish(self) -> None:
        self._counts += 1
        self._fast.publish(Float32(data=float(self._counts)))


def listens(topic: str) -> bool:
    """Return True if the console has subscribed to a topic of the talker."""
    return TALKERS[0].count_subscribers(topic) > 0


# one message, and the rate


async def test_the_last_message_is_shown_as_yaml_and_a_kept_one_at_once() -> None:
    code, said = await plain("echo /motor_status\necho battery_level percentage\n")
    assert code == 0, said
    assert "encoder_ticks: 15420\nspeed: 0.0\nmoving: false\nemergency_stopped: false\n" in said
    assert "\npercentage: 8" in said
    code, said = await plain("echo kept\necho slow frame_id\n", Talker)
    assert (code, said) == (0, "data: once\nframe_id: map\n")


REFUSED = [
    ("echo silent", "echo: no message on /silent in 5 s: nothing arrived from talker"),
    ("echo heard", "echo: no message on /heard in 5 s: it has no publisher"),
    ("echo fas", "echo: no topic /fas is on the graph (nearest: /fast)"),
    ("echo fast dat", "echo: there is no field dat (nearest: data)"),
    ("hz silent", "hz: no message on /silent in 5 s: nothing arrived from talker"),
    ("hz fas", "hz: no topic /fas is on the graph (nearest: /fast)"),
    ("hz", "hz: needs TOPIC"),
    ("interface MotorStatu", "interface: no type MotorStatu is on the graph"),
    (
        "interface archo_interfaces/msg/MotorStat",
        "interface: no type archo_interfaces/msg/MotorStat is installed here "
        "(nearest: archo_interfaces/msg/MotorStatus)",
    ),
    (
        "interface std_msgs/Strin",
        "interface: no type std_msgs/Strin is installed here (nearest: std_msgs/String)",
    ),
    (
        "interface std_msg/msg/String",
        "interface: no package of interfaces std_msg is installed here (nearest: std_msgs)",
    ),
    ("interface ../a", "interface: no package of interfaces .. is installed here"),
]


async def test_why_nothing_is_shown_is_one_line_with_the_nearest() -> None:
    code, said = await plain("".join(f"{line}\n" for line, _ in REFUSED), Talker)
    assert code == 1
    told = [line.partition(" failed: ")[2] for line in said.splitlines() if " failed: " in line]
    assert told == [why for _, why in REFUSED]


async def test_a_type_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("archo_tui.verbs.topics.load_class", lambda _: None)
    code, said = await plain("echo fast\n", Talker)
    assert code == 1
    assert "std_msgs/msg/Float32" in said
    assert "not installed" in said


async def test_the_rate_is_measured_for_five_seconds() -> None:
    code, said = await plain("hz fast\n", Talker)
    assert code == 0, said
    assert "listening for 5 s\n/fast: " in said
    assert " messages in 5 s, " in said
    assert " s between them, " in said
    rate = float(said.partition("/fast: ")[2].partition(" Hz")[0])
    assert rate == pytest.approx(20.0, abs=2.0)


@pytest.mark.waits
async def test_too_few_messages_have_the_rate_of_the_graph_or_none() -> None:
    code, said = await plain("hz kept\nhz rare\n", Talker)
    assert code == 0, said
    assert "/kept: no message in 5 s, but the last one that was sent before\n" in said
    assert re.search(r"/rare: -- Hz, [23] messages in 5 s, ", said)


# followed


async def test_messages_are_printed_until_the_next_line_five_a_second_at_most() -> None:
    async with operated(Talker, at_terminal=True) as person:
        await person.enter("echo slow --follow", "following slow; the next line ends it\nstamp:\n")
        await person.until("frame_id: map\n---\nstamp:")
        await while_passes(3.0)
        began = seconds()
        person.type("echo fast --follow\n")
        await until(lambda: not listens("/slow"))
        assert 3 <= person.said.count("frame_id: map") <= 7  # None twice.
        await person.until("data: ")
        await while_passes(3.0)
        person.type("\n")
        await until(lambda: not listens("/fast"))
        lines = person.said.splitlines()
        shown = [float(line.partition(": ")[2]) for line in lines if line.startswith("data: ")]
        left_out = [int(line.split()[0]) for line in lines if line.endswith(" left out")]
        assert 10 <= len(shown) <= 5 * (seconds() - began) + 2
        assert sum(left_out) + len(shown) == pytest.approx(shown[-1] - shown[0] + 1, abs=5)
        none = "no message on /silent in 5 s: nothing arrived from talker"
        await person.enter("echo silent --follow", none)
        assert listens("/silent")
        none = "failed: echo: no topic /nosuch is on the graph"
        await person.enter("echo nosuch --follow", none)
        await until(lambda: not listens("/silent"))
        assert await person.end() == 1


async def test_that_the_publisher_has_gone_is_said_once() -> None:
    async with operated(Talker, at_terminal=True) as person:
        await person.enter("echo fast --follow", "data: ")
        begin(TALKERS[0], TALKERS[0].leave_fast)
        await person.until("no message on /fast in 5 s: it has no publisher")
        await while_passes(12.0)
        assert person.said.count("no publisher") == 1
        TALKERS[0].slow_timer.cancel()
        none = "no message on /slow in 5 s: nothing arrived from talker"
        await person.enter("echo slow --follow", none)
        assert await person.end() == 0


@pytest.mark.real_time
async def test_a_shell_gets_messages_rates_and_types_as_text_or_objects() -> None:
    async with served(Talker) as person:
        shown = await typed("echo", "fast", "--timeout", "1")
        assert shown.code == 4
        assert shown.out.startswith("data: ")
        assert " left out\n" in shown.err
        told = await typed("echo", "fast", "--json", "--timeout", "1")
        *messages, result = map(json.loads, told.out.splitlines())
        assert result["code"] == "ran_out"
        assert [sorted(one) for one in messages] == [["left_out", "message"]] * len(messages)
        assert messages[1]["message"]["data"] > messages[0]["message"]["data"]
        await until_beside(lambda: not listens("/fast"))
        assert await typed("echo", "kept", "data", "--once") == (0, "data: once\n", "")
        once = json.loads((await typed("echo", "kept", "--once", "--json")).out)
        assert once["data"] == {"data": "once"}
        wrong = await typed("echo", "fast", "dat")
        said = "archo-tui: echo: there is no field dat (nearest: data)\n"
        assert (wrong.code, wrong.err) == (2, said)
        given_up = await typed("hz", "fast", "--timeout", "0.2")
        assert (given_up.code, given_up.err) == (4, "archo-tui: hz: 0.2 s are over\n")
        rate = json.loads((await typed("hz", "fast", "--json")).out)["data"]
        assert rate["messages"] > 1
        assert 0 < rate["least"] <= 1 / rate["rate"] <= rate["greatest"]
        shown = await typed("interface", "archo_interfaces/msg/MotorStatus")
        assert (shown.code, shown.err) == (0, "")
        assert shown.out.startswith(f"{COMMENT}\n")
        result = json.loads((await typed("interface", "Float32", "--json")).out)
        assert result["data"]["type"] == "std_msgs/msg/Float32"
        assert result["data"]["definition"].endswith("float32 data")
        await person.end()


# types

COMMENT = "# State of the drive, published on motor_status."


async def test_a_type_may_be_typed_with_or_without_its_package() -> None:
    names = [
        *("archo_interfaces/msg/MotorStatus", "archo_interfaces/MotorStatus", "MotorStatus"),
        *("MoveToShelf", "std_srvs/Trigger"),
    ]
    code, said = await plain("".join(f"interface {name}\n" for name in (*names, "MotorStatu")))
    assert code == 1, said
    assert said.count(f"{COMMENT}\nint64 encoder_ticks") == 3
    assert "# Drive to a shelf.\nint32 shelf_number" in said
    assert "---\nbool success" in said
    assert "no type MotorStatu is on the graph (nearest: MotorStatus)" in said


async def test_t_on_a_topic_shows_the_definition_of_its_type() -> None:
    async with console() as op:
        await op.press("8")
        while not (row := op.app.main.graph.selected) or row.resource.name != "/motor_status":
            await op.press("down")
        await op.press("enter")
        await op.until("t type")
        await op.press("t")
        await op.until(COMMENT)
        await op.until("# archo_interfaces/msg/MotorStatus")
        await op.press("escape")
        await op.until("t type")
        await op.press("escape")


@asynccontextmanager
async def publishing(
    line: str = "", *makers: Any, kind: Any = String, **options: Any
) -> AsyncIterator[tuple[Typed, list[Any]]]:
    """A console, and what is heard on `words`; with a line it publishes there already."""
    heard: list[Any] = []
    read = (lambda m: m.data) if kind is String else (lambda m: m.linear.x)
    async with operated(hearing(heard, kind, read=read), *makers, **options) as person:
        await is_seen(person)
        if line:
            await publish(person, heard, line)
        yield person, heard


async def publish(person: Typed, heard: list[Any], line: str) -> None:
    """Publish until some messages are heard; a pause of a busy machine ends it: then once more."""
    publications, before = person.station.robot.publications, len(heard)
    while len(heard) < before + 4:
        person.type(f"pub words {line}\n")
        await until(lambda: publications.active)
        await until(lambda: len(heard) > before + 3 or not publications.active)


async def is_seen(person: Typed) -> None:
    robot = person.station.robot
    await until(lambda: "/words" in {found.name for found in robot.snapshot.resources})


@pytest.mark.parametrize(
    ("words", "rate", "times"),
    [
        ("words data=a", 1.0, 1),
        ("words data=a --times 3", 1.0, 3),
        ("words --rate 10 data=a", 10.0, None),
        ("words data=a --rate=100 --times=2", 100.0, 2),
    ],
)
def test_without_a_rate_it_is_one_message_and_with_one_it_has_no_end(
    words: str, rate: float, times: int | None
) -> None:
    given = Publish().values(words.split())
    assert (given["rate"], given["times"]) == (rate, times)
    assert given["field=value"] == ["data=a"]


@pytest.mark.parametrize(
    "number",
    [
        *("--rate 0", "--rate -1", "--rate 100.1", "--rate nan", "--rate inf", "--rate x"),
        *("--times 0", "--times 1.5", "--times inf", "--times nan", "--times", "--rate"),
    ],
)
def test_a_rate_or_a_number_of_times_that_is_none_is_refused(number: str) -> None:
    with pytest.raises(ValueError, match=number.split()[0]):
        Publish().values(["words", *number.split()])


def test_the_text_of_a_large_message_keeps_the_limits_of_a_rate_too() -> None:
    values = {"--rate": 1000.0, "--times": 0, "pose": {}}  # As a form of YAML gives them.
    for wrong in ({}, {"--rate": "often"}, {"--rate": 1.0, "--times": 1.5}):
        with pytest.raises(ValueError, match=r"--rate|--times"):
            _publish_values("/words", {**values, **wrong})


async def test_cancel_all_cancels_every_goal_also_while_something_is_published() -> None:
    async with publishing("", MotorController) as (person, heard):
        station = person.station
        await until(lambda: "move_to_shelf" in station.robot.snapshot.offered)
        person.type("pub words data=x --rate 10 --yes\n")
        await until(lambda: len(heard) > 2)
        outcome = await Cancel().run(station, {"--all": True})
        assert outcome.text == "none was cancelled"
        assert not station.robot.publications.active


async def test_a_message_is_asked_about_and_arrives_as_often_as_asked() -> None:
    async with publishing() as (person, heard):
        await person.enter("pub words data=no", "This may move the robot. Publish to /words")
        await person.enter("pub words data=one --yes", "pub words: published; 1 subscriber\n")
        await until(lambda: heard == ["one"])
        await person.enter("pub words data=two --times 3 --rate 20 --yes", "published 3 messages")
        await until(lambda: heard == ["one", "two", "two", "two"])
        await person.enter("pub words dada=x --yes", "failed: pub: expected data=..., not dada=x")
        await person.enter("pub word data=x --yes", "(nearest: /words)")
        await person.enter("pub words std_msgs/msg/Bool --yes", "is std_msgs/msg/String, not")
        await person.enter("pub /_hid std_msgs/msg/String --yes", "nothing is published there")
        await person.enter("pub new std_msgs/msg/String --yes", "published; no subscribers")
        now = (
            "this console has /new as std_msgs/msg/String now: it cannot publish std_msgs/msg/Bool"
        )
        await person.enter("pub new std_msgs/msg/Bool --yes", f"failed: pub: {now} there as well")
        assert len(heard) == 4


@pytest.mark.parametrize("name", ["'a b'", "/1x", "a//b", "a/", "''", "/", "~/x", "x" * 248])
def test_a_name_that_no_topic_can_have_is_misuse(name: str) -> None:
    with pytest.raises(ValueError, match="is not a name of a topic, such as /cmd_vel"):
        Publish().values([name.strip("'"), "std_msgs/msg/String"])


async def test_subscribers_that_get_nothing_are_counted_apart() -> None:
    class Unfit(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("unfit", **options)
            timely = QoSProfile(depth=10, deadline=Duration(seconds=0.1))
            self.create_subscription(String, "words", print, timely)
            self.create_subscription(String, "words", print, 10)

    async with operated(Unfit) as person:
        await is_seen(person)
        one = "published; 1 subscriber; 1 of another type or QoS"
        await person.enter("pub words data=a --yes", one)


async def test_what_has_no_end_is_shown_in_nodes_and_ends_by_the_next_line() -> None:
    async with publishing(at_terminal=True) as (person, heard):
        station = person.station
        await person.enter("pub words data=x --rate 10 --yes", "publishing at 10 Hz; 1 ")
        await until(lambda: len(heard) > 3)
        station.refresh()
        assert node_rows(station.view)[0].word()[1] == "at 10 Hz, cancel ends it"
        person.type("\n")  # The next line ends it, at a terminal.
        await person.until("pub: ended")
        await until(lambda: not station.robot.publications.active)
        count, later = len(heard), seconds() + 2.0
        await until(lambda: seconds() > later)
        assert len(heard) <= count + 1


def test_two_publications_of_one_topic_are_one_row() -> None:
    view = stub_station(StubRobot(NORMAL)).view
    twice = replace(view, publishes=("pub /words, at 10 Hz", "pub /words, at 2 Hz"))
    rows = [row for row in node_rows(twice) if row.publishes]
    assert [(row.name, row.publishes) for row in rows] == [("pub /words", "at 10 Hz and at 2 Hz")]


async def test_a_stop_ends_it_and_behind_it_none_is_sent_until_the_release() -> None:
    async with publishing("data=x --rate 50 --yes", MotorController) as (person, heard):
        await person.enter("stop", "STOP: confirmed")
        await person.until("failed: pub: ended by STOP after")
        count, later = len(heard), seconds() + 2.0
        await person.enter("pub words data=y --yes", "failed: pub: the robot is stopped")
        await until(lambda: seconds() > later)
        assert len(heard) <= count + 1
        await person.enter("release --yes", "release stop: ")
        await person.enter("pub words data=y --yes", "published; 1 subscriber\n")
        await until(lambda: heard[-1] == "y")


async def test_a_cancel_a_pause_and_the_end_of_the_console_end_it() -> None:
    always = "data=x --rate 50 --yes"
    async with publishing(always) as (person, heard):
        robot = person.station.robot
        person.type("cancel\nnodes\n")
        await person.until("pub words: ended after")
        await person.until("hearing up")
        assert "pub /words" not in person.said
        await publish(person, heard, always)
        (publication,) = robot.publications.active
        publication.looked = seconds() - 3.0  # As it was suspended, and read no STOP.
        await person.until("failed: pub: ended by a pause of the console after")
        count, later = len(heard), seconds() + 1.0
        await until(lambda: seconds() > later)
        assert len(heard) == count
        await publish(person, heard, always)
        with robot.thread._lock:  # The signal comes while this thread hands over a request.
            robot.end_publications_now()
        robot.end_publications_now()  # It does not hang.
        await until(lambda: not robot.publications.active)
        await publish(person, heard, always)
        await robot.stop_sending_goals()
        assert robot.publications.active == ()
        await person.until("ended by the end of the console")
        await person.enter("pub words data=x --yes", "not published: the console ends")


async def test_a_topic_of_the_file_that_never_moves_asks_nothing_and_outlives_a_stop(
    tmp_path: Path,
) -> None:
    file = tmp_path / "robot.yaml"
    text = load.default_path().read_text(encoding="utf-8")
    file.write_text(f"{text}\ntopics:\n  - {{topic: words, moves: false}}\n")
    async with publishing("data=x --rate 10", MotorController, robot=file) as (person, heard):
        await person.enter("stop", "STOP: confirmed")
        count = len(heard)
        await until(lambda: len(heard) > count + 3)


async def test_a_speed_that_is_ended_is_followed_by_no_speed() -> None:
    geometry = pytest.importorskip("geometry_msgs.msg")
    async with publishing("linear.x=0.5 --rate 20 --yes", kind=geometry.Twist) as (person, heard):
        person.type("cancel\n")
        await until(lambda: heard[-1] == 0.0)
        assert set(heard[:-1]) == {0.5}
        await person.enter("pub words linear.x=0.3 --yes", "published; 1 subscriber\n")
        await until(lambda: heard[-1] == 0.3)  # One message is meant as it is typed.


async def test_a_cancel_while_a_subscriber_is_sought_ends_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Publisher, "get_subscription_count", lambda _: 0)
    async with publishing() as (person, heard):
        station = person.station
        person.type("pub words data=x --yes\n")
        await until(lambda: station.robot.publications.active)
        await station.robot.end_publications()
        await person.until("failed: pub: ended by cancel after 0 messages")
        assert heard == []


async def test_what_the_robot_says_to_the_console_is_not_said_in_its_place() -> None:
    async with operated(BatteryMonitor) as person:
        topics = person.station.robot
        await until(lambda: "/battery_level" in {r.name for r in topics.snapshot.resources})
        await person.enter(
            "pub battery_level percentage=100 --yes",
            "failed: pub: the console reads /battery_level, and /battery_monitor",
        )


async def test_a_header_gets_the_present_time_unless_one_is_typed() -> None:
    geometry, heard = pytest.importorskip("geometry_msgs.msg"), list[Any]()
    async with operated(hearing(heard, geometry.PoseStamped)) as person:
        await is_seen(person)
        for header in ("header.frame_id=map", "'{header: {frame_id: map}}'"):
            await person.enter(f"pub words {header} --yes", "published; 1 subscriber\n")
        await person.enter("pub words header.stamp.sec=7 --times 1 --yes", "published")
        await until(lambda: len(heard) == 3)
        assert [message.header.stamp.sec > 1000 for message in heard] == [True, True, False]
        assert heard[0].header.frame_id == "map"
