"""A topic that is open is followed: counted whole, decoded within bounds, and only while open."""

from __future__ import annotations

import asyncio
import math
from array import array
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.serialization import serialize_message
from std_msgs.msg import Float32, Float64, String, UInt8MultiArray

from archo_tui.robot.robot import Robot
from archo_tui.robot.topics import inspect
from archo_tui.robot.topics.inspect import MessageIntake, TopicWatch
from archo_tui.robot.topics.rows import TopicRequest, TopicView
from tests.support import chosen
from tests.support.quiet import until, while_passes
from tests.support.robot import making, robot
from tests.support.ros import begin

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ONE_TYPE = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="one process cannot have both in Fast DDS, only two can"
)
EVERYTHING = TopicRequest(plotted=("data",), plot_columns=10)


class Talker(Node):
    """Publishes a count at 10 Hz, and once a message that is kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        self._sent = 0.0
        self.fast = self.create_publisher(Float32, "fast", qos_profile_sensor_data)
        self.timer = self.create_timer(0.1, self._publish)
        self._kept = self.create_publisher(String, "kept", LATCHED)
        self._kept.publish(String(data="once"))

    def _publish(self) -> None:
        self._sent += 1.0
        self.fast.publish(Float32(data=self._sent))

    def leave_fast(self) -> None:
        """Publish nothing more on `fast`, and leave it."""
        self.timer.cancel()
        self.destroy_publisher(self.fast)

    def change_type(self) -> None:
        """Publish another type on `fast`."""
        self.leave_fast()
        publisher = self.create_publisher(String, "fast", 10)
        self.create_timer(0.1, lambda: publisher.publish(String(data="words now")))


@asynccontextmanager
async def following(
    it: Robot, topic: str, request: TopicRequest = EVERYTHING
) -> AsyncIterator[list[TopicView]]:
    """The views of a topic so far, the newest at the end."""
    views: list[TopicView] = []
    task = asyncio.ensure_future(it.follow_topic(topic, lambda: request, views.append))
    try:
        await until(lambda: views)
        yield views
    finally:
        task.cancel()


def has(views: list[TopicView], text: str) -> bool:
    """Return True if the newest view is about this fault."""
    return text in views[-1].fault


async def test_a_topic_is_followed_only_while_it_is_open() -> None:
    made: list[Talker] = []
    async with robot(making(made, Talker)) as it:
        async with following(it, "/fast") as views:
            await until(lambda: views[-1].received > 30)
            last = views[-1]
            assert last.type == "std_msgs/msg/Float32"
            assert last.rate == pytest.approx(10, rel=0.3)
            assert last.bytes_per_second == pytest.approx(80, rel=0.3)
            assert last.age is not None
            assert last.age < 1.0
            value, least = last.fields[0].value, last.fields[0].least
            assert isinstance(value, float)
            assert least is not None
            assert value - least == pytest.approx(last.received - 1, abs=3)
            assert last.fields[0].greatest == value
            assert last.plots["data"][-1] is not None
            assert last.ends is not None
            assert last.ends.publishers[0].qos == "BEST_EFFORT, VOLATILE"
            assert not last.fault
            assert made[0].count_subscribers("/fast") == 1
        await until(lambda: made[0].count_subscribers("/fast") == 0)


async def test_five_views_a_second_are_shown_however_fast_messages_come() -> None:
    async with robot(making([], Talker)) as it, following(it, "/fast") as views:
        await until(lambda: views[-1].received)
        before = len(views)
        await while_passes(4.0)
        assert 10 <= len(views) - before <= 22


async def test_a_message_that_is_kept_is_shown_at_once() -> None:
    async with robot(making([], Talker)) as it, following(it, "/kept") as views:
        await until(lambda: views[-1].fields)
        assert views[-1].fields[0].value == "once"
        assert views[-1].rate is None


async def test_a_topic_that_goes_is_waited_for_with_its_last_message() -> None:
    made: list[Talker] = []
    async with robot(making(made, Talker)) as it, following(it, "/fast") as views:
        await until(lambda: views[-1].fields)
        begin(made[0], made[0].leave_fast)
        await until(lambda: has(views, "it has no publisher: waiting for one"))
        assert views[-1].fields


@ONE_TYPE
async def test_a_publisher_that_comes_back_with_another_type_is_followed() -> None:
    made: list[Talker] = []
    async with robot(making(made, Talker)) as it, following(it, "/fast") as views:
        await until(lambda: views[-1].fields)
        begin(made[0], made[0].change_type)
        await until(lambda: views[-1].type == "std_msgs/msg/String" and views[-1].fields)
        assert views[-1].fields[0].value == "words now"
        assert not views[-1].fault


async def test_a_topic_that_is_not_there_is_waited_for() -> None:
    made: list[Talker] = []
    async with robot(making(made, Talker)) as it, following(it, "/later") as views:
        await until(lambda: has(views, "it is not on the graph: waiting for it"))
        publisher = made[0].create_publisher(String, "later", LATCHED)
        publisher.publish(String(data="here"))
        await until(lambda: views[-1].fields and views[-1].fields[0].value == "here")


@ONE_TYPE
async def test_two_types_on_a_topic_are_said_and_the_first_is_shown() -> None:
    made: list[Talker] = []
    async with robot(making(made, Talker)) as it:
        made[0].create_publisher(Float64, "fast", 10)
        async with following(it, "/fast") as views:
            await until(lambda: has(views, "also published as std_msgs/msg/Float64"))
            await until(lambda: views[-1].fields)
            assert views[-1].type == "std_msgs/msg/Float32"


async def test_a_type_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("archo_tui.robot.requests.topics.load_class", lambda _: None)
    async with robot(making([], Talker), nodes=1) as it, following(it, "/fast") as views:
        await until(lambda: has(views, "/fast is std_msgs/msg/Float32, which is not installed"))
        assert has(views, "install its package std_msgs")
        assert views[-1].ends is not None


def test_a_rate_needs_three_intervals_and_no_message_that_was_sent_before() -> None:
    intake = MessageIntake()
    intake.add(9.93, b"1234", True)
    assert (intake.received, intake.last) == (1, None)
    for number in range(3):
        intake.add(10.0 + number, b"1234")
        assert intake.rates(10.0 + number) is None
    intake.add(13.0, b"1234")
    assert intake.rates(13.5) == (1.0, 4.0)
    assert intake.rates(19.0) is None


def test_a_slow_topic_has_the_rate_of_its_last_three_intervals() -> None:
    intake = MessageIntake()
    for number in range(9):
        intake.add(20.0 * number, b"1234")
    assert intake.rates(170.0) == (0.05, 0.2)
    assert intake.rates(230.0) is None


def test_of_a_thousand_a_second_all_are_counted_and_thirty_decoded() -> None:
    intake = MessageIntake()
    decoded: list[bytes] = []

    def decode(data: bytes) -> Float32:
        decoded.append(data)
        return Float32(data=float(len(decoded)))

    watch = TopicWatch("/fast", "std_msgs/msg/Float32", {}, intake, decode)
    data = serialize_message(Float32())
    for number in range(5_000):
        intake.add(number / 1000, data)
        if number % 200 == 199:
            watch.update(number / 1000, EVERYTHING)
    view = watch.update(5.0, EVERYTHING)
    assert view.received == 5_000
    assert view.rate == pytest.approx(1_000, rel=0.01)
    assert view.bytes_per_second == pytest.approx(8_000, rel=0.01)
    assert 100 <= len(decoded) <= 151
    assert view.fields[0].value == float(len(decoded))


def test_messages_of_ten_megabytes_are_counted_and_not_decoded() -> None:
    intake = MessageIntake()
    watch = TopicWatch("/image", "std_msgs/msg/UInt8MultiArray", {}, intake, _never)
    for number in range(60):
        intake.add(number / 30, bytes(10_000_000))
    view = watch.update(2.0, EVERYTHING)
    assert view.received == 60
    assert view.bytes_per_second == pytest.approx(300e6, rel=0.01)
    assert view.fault == "not shown: a message of 10.0 MB, more than 8 MB"


def test_what_waits_takes_a_bounded_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    intake = MessageIntake()
    for number in range(100):
        intake.add(number / 10, bytes(7_000_000))
    assert len(intake.drain()) == 3  # Two that wait, and the newest.
    assert intake.drain() == []


def test_a_message_of_another_definition_is_said_until_one_can_be_read() -> None:
    made = inspect.Inspection(_Plain(), None, "/fast", UInt8MultiArray)  # type: ignore[arg-type]
    intake = MessageIntake()
    watch = TopicWatch("/fast", "std_msgs/msg/UInt8MultiArray", {}, intake, made.decode)
    intake.add(1.0, b"\x00\x01\x00\x00\x01")
    assert "may have another definition" in watch.update(1.0, EVERYTHING).fault
    assert "may have another definition" in watch.update(1.2, EVERYTHING).fault
    intake.add(2.0, serialize_message(UInt8MultiArray(data=array("B", [1, 2]))))
    view = watch.update(2.0, EVERYTHING)
    assert view.fault == ""
    assert view.age == 0.0
    assert not math.isnan(view.age)


class _Plain:
    def without_secrets(self, message: Any) -> Any:
        """Return a message that has none."""
        return message


def _never(_data: bytes) -> Any:
    raise AssertionError("decoded")
