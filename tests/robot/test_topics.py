"""A topic that somebody looks at: counted whole, decoded within bounds, only while it is open."""

from __future__ import annotations

import asyncio
import math
from array import array
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus
from rcl_interfaces.msg import Log, Parameter, ParameterEvent, ParameterValue
from rclpy.node import Node
from rclpy.parameter import Parameter as RclpyParameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rclpy.serialization import serialize_message
from std_msgs.msg import Byte, Float32, Float32MultiArray, Float64, Header, String, UInt8MultiArray

from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.messages.text import as_text
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.graph import in_namespace
from archo_tui.robot.topics import inspect
from archo_tui.robot.topics import rows as row_module
from archo_tui.robot.topics.inspect import MessageIntake, TopicWatch
from archo_tui.robot.topics.rows import (
    SPAN,
    FieldKind,
    FieldView,
    TopicFields,
    TopicRequest,
    TopicView,
)
from archo_tui.robot_file.load import load
from archo_tui.robot_file.model import field_units
from tests.support import chosen
from tests.support.archo import ARCHO
from tests.support.quiet import until, while_passes
from tests.support.robot import robot
from tests.support.ros import begin
from tests.support.stand_in import Made

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


ONE_TYPE = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="one process cannot have both in Fast DDS, only two can"
)


EVERYTHING = TopicRequest(plotted=("data",), plot_columns=10)


class Talker(Node):
    """Publishes a count at 10 Hz, best effort, and once a large message that is kept."""

    def __init__(self, qos: Any = qos_profile_sensor_data, **options: Any) -> None:
        super().__init__("talker", **options)
        self._sent = 0.0
        self.fast = self.create_publisher(Float32, "fast", qos)
        self.timer = self.create_timer(0.1, self._publish)
        self._kept = self.create_publisher(UInt8MultiArray, "kept", LATCHED)
        self._kept.publish(UInt8MultiArray(data=bytes(5_000)))

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

    def change_qos(self) -> None:
        """Replace the publisher of `fast`."""
        before = self.fast
        self.fast = self.create_publisher(Float32, "fast", qos_profile_sensor_data)
        self.destroy_publisher(before)


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


async def test_a_topic_is_followed_five_times_a_second_while_it_is_open() -> None:
    talker = Made(Talker)
    async with robot(talker) as it:
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
            assert talker.node.count_subscribers("/fast") == 1
            before = len(views)
            await while_passes(4.0)
            assert 10 <= len(views) - before <= 22
        await until(lambda: talker.node.count_subscribers("/fast") == 0)


async def test_a_message_that_is_kept_is_shown_at_once() -> None:
    async with robot(Talker) as it, following(it, "/kept") as views:
        await until(lambda: views[-1].fields)
        assert views[-1].fields[-1].type == "uint8[5000]"
        assert views[-1].rate is None


async def test_a_topic_that_goes_is_waited_for_with_its_last_message() -> None:
    talker = Made(Talker)
    async with robot(talker) as it, following(it, "/fast") as views:
        await until(lambda: views[-1].fields)
        begin(talker.node, talker.node.leave_fast)
        await until(lambda: has(views, "it has no publisher: waiting for one"))
        assert views[-1].fields


@ONE_TYPE
async def test_a_publisher_that_comes_back_with_another_type_is_followed() -> None:
    talker = Made(Talker)
    async with robot(talker) as it, following(it, "/fast") as views:
        await until(lambda: views[-1].fields)
        begin(talker.node, talker.node.change_type)
        await until(lambda: views[-1].type == "std_msgs/msg/String" and views[-1].fields)
        assert views[-1].fields[0].value == "words now"
        assert not views[-1].fault


async def test_a_topic_that_is_not_there_is_waited_for() -> None:
    talker = Made(Talker)
    async with robot(talker) as it, following(it, "/later") as views:
        await until(lambda: has(views, "it is not on the graph: waiting for it"))
        publisher = talker.node.create_publisher(String, "later", LATCHED)
        publisher.publish(String(data="here"))
        await until(lambda: views[-1].fields and views[-1].fields[0].value == "here")


@ONE_TYPE
async def test_two_types_on_a_topic_are_said_and_the_first_is_shown() -> None:
    talker = Made(Talker)
    async with robot(talker) as it:
        talker.node.create_publisher(Float64, "fast", 10)
        async with following(it, "/fast") as views:
            await until(lambda: has(views, "also published as std_msgs/msg/Float64"))
            await until(lambda: views[-1].fields)
            assert views[-1].type == "std_msgs/msg/Float32"


async def test_a_type_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("archo_tui.robot.requests.topics.load_class", lambda _: None)
    async with robot(Talker, nodes=1) as it, following(it, "/fast") as views:
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


def _never(_data: bytes) -> Any:
    raise AssertionError("decoded")


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
    node: Any = SimpleNamespace(without_secrets=lambda message: message)
    made = inspect.Inspection(node, None, "/fast", UInt8MultiArray)  # type: ignore[arg-type]
    intake = MessageIntake()
    watch = TopicWatch("/fast", "std_msgs/msg/UInt8MultiArray", {}, intake, made.decode)
    intake.add(1.0, b"\x00\x01\x00\x00\x01")
    assert "may have another definition" in watch.update(1.0, EVERYTHING).fault
    assert "may have another definition" in watch.update(1.2, EVERYTHING).fault
    intake.add(2.0, serialize_message(UInt8MultiArray(data=array("B", [1, 2]))))
    view = watch.update(2.0, EVERYTHING)
    assert view.fault == ""
    assert view.age == 0.0


# Without a view: its messages are counted.


async def test_messages_are_counted_from_begin_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    recorded: list[str] = []
    talker = Made(Talker)
    seen = ConsoleNode.__init__

    def listen(self: Any, name: str, context: Any, _on_message: Any, masks: Any) -> None:
        seen(self, name, context, lambda topic, *_: recorded.append(topic), masks)

    monkeypatch.setattr(ConsoleNode, "__init__", listen)
    async with robot(talker) as it:
        async with it.inspect("/fast", Float32) as counted:
            await until(lambda: counted.count >= 5)
            assert counted.decode(counted.newest[1]).data >= 5.0
            assert counted.least is not None
            assert counted.greatest is not None
            assert 0 < counted.least <= counted.greatest
            assert counted.size == counted.count * 8  # A header, and 4 bytes.
            assert talker.node.count_subscribers("/fast") == 1
        await until(lambda: talker.node.count_subscribers("/fast") == 0)
        assert "/fast" not in recorded


async def test_a_subscription_that_rclpy_refuses_is_a_fault_and_an_outcome(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(_: object) -> None:
        raise RuntimeError("created topic with other type")

    monkeypatch.setattr(inspect.Inspection, "subscribe", refused)
    said = "/fast: no subscription: RuntimeError: created topic with other type"
    async with robot(Talker) as it:
        await until(lambda: "/fast" in {end.name for end in it.snapshot.resources})
        with pytest.raises(ArchoError, match=said):
            async with it.inspect("/fast", Float32):
                pass
        views: list[Any] = []
        task = asyncio.ensure_future(it.follow_topic("/fast", TopicRequest, views.append))
        await until(lambda: views and said in views[-1].fault)
        assert not task.done()
        task.cancel()


async def test_messages_that_are_kept_are_no_rate() -> None:
    publishers: list[Any] = []

    def make(**options: Any) -> Node:
        node = Node("deep", **options)
        deep = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        publishers.append(node.create_publisher(String, "deep", deep))
        for _ in range(5):
            publishers[0].publish(String(data="kept"))
        return node

    async with robot(make) as it, it.inspect("/deep", String) as counted:
        await until(lambda: counted.count)
        await while_passes(1.0)
        assert counted.rate is None
        assert counted.kept == counted.count
        publishers[0].publish(String(data="new"))
        await until(lambda: counted.count == counted.kept + 1)
        assert counted.rate is None
        assert counted.least is None


def test_two_messages_at_once_are_no_rate() -> None:
    rate = MessageRate(10.0).with_message_at(10.0002)
    assert rate.hertz is None
    for number in range(1, 30):
        rate = rate.with_message_at(10.0 + number)
    assert rate.hertz == pytest.approx(1.0, rel=0.02)
    assert rate.hertz_at(39.5) == rate.hertz
    assert rate.hertz_at(44.0) is None


async def test_a_secret_parameter_stays_secret() -> None:
    def secretive(**options: Any) -> Node:
        node = Node("secretive", **options)
        node.declare_parameter("password", "first")
        node.create_timer(
            0.5, lambda: node.set_parameters([RclpyParameter("password", value="hunter2")])
        )
        return node

    async with (
        robot(secretive) as it,
        it.inspect("/parameter_events", ParameterEvent) as counted,
    ):
        seen = set[str]()
        while len(seen) < 2:  # the value at the start and the one that was set then
            await until(lambda: counted.count > len(seen))
            seen.add(text := as_text(counted.decode(counted.newest[1])))
            assert "name: password" in text
            assert "first" not in text
            assert "hunter2" not in text


async def test_a_publisher_with_another_qos_is_heard_again() -> None:
    talker = Made(Talker, 10)
    async with robot(talker) as it, it.inspect("/fast", Float32) as counted:
        await until(lambda: counted.count)
        begin(talker.node, talker.node.change_qos)
        await until(lambda: talker.node.fast.qos_profile.depth == 5)
        await while_passes(1.0)
        before = counted.count
        it.resubscribe_if_needed(counted)
        await until(lambda: counted.count > before + 2)
        it.resubscribe_if_needed(counted)  # Changes nothing.
        await until(lambda: counted.count > before + 6)


# What is kept of its fields: ranges, a minute of values, arrays by shape, and bounds.


def rows(message: Any, **open_arrays: int) -> dict[str, FieldView]:
    """The rows of one message by path."""
    fields = TopicFields({})
    fields.add(0.0, message, {})
    return {row.path: row for row in fields.rows(0.0, TopicRequest(open_arrays))}


def watched(*values: float, per_second: float = 1.0) -> FieldView:
    """The row of a number that had these values, one after the other, with its curve."""
    fields = TopicFields({})
    for number, value in enumerate(values):
        fields.add(number / per_second, Float32(data=value), {})
    now = (len(values) - 1) / per_second
    request = TopicRequest(visible=frozenset(["data"]), curve_columns=6, plotted=("data",))
    return fields.rows(now, request)[0]


def test_nested_messages_and_times_are_rows_below_their_own() -> None:
    header = Header(frame_id="map")
    header.stamp.sec, header.stamp.nanosec = 7, 500_000_000
    stamp, frame = rows(header).values()
    assert (stamp.path, stamp.value, stamp.is_time) == ("stamp", 7.5, True)
    assert (frame.path, frame.value, frame.kind) == ("frame_id", "map", FieldKind.VALUE)
    found = rows(Log(stamp=header.stamp, level=30))
    assert (found["level"].value, found["level"].constant) == (30, "WARN")
    value = rows(Parameter(value=ParameterValue(type=3, double_value=0.25)))
    assert value["value"].kind is FieldKind.GROUP
    assert value["value.double_value"].value == 0.25


def test_the_range_lasts_since_the_first_message_and_the_values_a_minute() -> None:
    row = watched(*[float(n) for n in range(100)])
    assert (row.least, row.greatest) == (0.0, 99.0)
    assert row.curve == ((40, 49), (50, 59), (60, 69), (70, 79), (80, 89), (90, 99))


def test_no_spike_within_a_tenth_of_a_second_is_lost() -> None:
    values = [0.0] * 3000
    values[1234] = 9.0
    row = watched(*values, per_second=100.0)
    assert row.curve.count((0.0, 9.0)) == 1
    assert row.greatest == 9.0


def test_a_value_holds_until_the_next_one_and_not_for_ever() -> None:
    fields = TopicFields({})
    for time in (0.0, 1.2, 2.4, 30.0):
        fields.add(time, Float32(data=time), {})
    request = TopicRequest(plotted=("data", "gone"), plot_columns=120)  # Half a second each.
    plots = fields.plots(30.0, request)
    assert list(plots) == ["data"]
    known = [column for column in plots["data"] if column is not None]
    first = plots["data"].index(known[0])
    assert None not in plots["data"][first : first + 6]
    assert plots["data"][first + 10 : -1].count(None) == len(plots["data"]) - first - 11
    assert fields.plots(31.0 + SPAN * 2, request)["data"] == (None,) * 120


def test_nan_and_inf_everywhere_are_values_without_a_range() -> None:
    row = watched(math.nan, math.inf, -math.inf, math.nan)
    assert math.isnan(row.value)  # type: ignore[arg-type]
    assert row.least is None
    assert row.curve == ()
    assert watched(math.nan, 2.0, math.inf).greatest == 2.0
    array = rows(Float32MultiArray(data=[math.nan] * 30))["data"]
    assert (array.type, array.nan, array.least) == ("float32[30]", 30, None)


def test_bytes_and_elements_that_are_shown_have_ranges_without_lost_spikes() -> None:
    fields, request = TopicFields({}), TopicRequest({"data": 40})
    for number in range(10):
        values = [0.0] * 50
        values[45] = 9.0 if number == 4 else 1.0
        fields.add(number / 100, Float32MultiArray(data=values), request.open_arrays)
    found = {row.path: row for row in fields.rows(0.1, request)}
    assert (found["data[45]"].least, found["data[45]"].greatest) == (1.0, 9.0)
    fields, request = TopicFields({}), TopicRequest({"new_parameters": 0})
    for gain in (0.5, 7.0, 1.0):
        value = ParameterValue(double_value=gain)
        event = ParameterEvent(new_parameters=[Parameter(value=value)])
        fields.add(
            1.0, event, {**request.open_arrays, "new_parameters[3].value.byte_array_value": 0}
        )
    found = {row.path: row for row in fields.rows(1.0, request)}
    assert found["new_parameters[0].value.double_value"].greatest == 7.0
    byte = TopicFields({})
    byte.add(1.0, Byte(data=b"\x07"), {})
    assert byte.rows(1.0, TopicRequest())[0].greatest == 7


def test_an_array_is_a_row_until_it_is_opened_twenty_elements_at_a_time() -> None:
    long = Float32MultiArray(data=[float(n) for n in range(360)])
    closed = rows(long)["data"]
    assert (closed.type, closed.least, closed.greatest) == ("float32[360]", 0.0, 359.0)
    opened = rows(long, data=340)
    assert [path for path in opened if "[" in path] == [
        *(f"data[{number}]" for number in range(340, 360)),
        "data[]",
    ]
    assert opened["data[340]"].value == 340.0
    assert opened["data[]"].kind is FieldKind.MORE
    assert opened["data[]"].value == 360
    image = rows(UInt8MultiArray(data=bytes(range(200))))["data"]
    assert image.first.startswith("00 01 02")
    event = ParameterEvent(new_parameters=[Parameter(name="gain")])
    assert rows(event, new_parameters=0)["new_parameters[0].name"].value == "gain"


def test_the_fields_beyond_the_bound_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(row_module, "MAX_FIELDS", 3)
    fields = TopicFields({})
    fields.add(0.0, BatteryStatus(), {})
    assert len(fields.rows(0.0, TopicRequest())) == 3
    assert fields.is_cut
    fields.add(1.0, Header(), {})  # Of another definition.
    assert [row.path for row in fields.rows(1.0, TopicRequest())] == ["stamp", "frame_id"]
    assert not fields.is_cut


def test_a_long_text_is_cut() -> None:
    value = rows(String(data="x" * 5_000))["data"].value
    assert isinstance(value, str)
    assert len(value) == 504


def test_the_robot_file_names_units_of_fields_that_it_does_not_convert(tmp_path: Path) -> None:
    fields = TopicFields({"data": "bar"})
    fields.add(0.0, Float32(data=1.0), {})
    assert fields.rows(0.0, TopicRequest())[0].unit == "bar"

    def full(name: str) -> str:
        return in_namespace("/left", name)

    kind = "archo_interfaces/msg/BatteryStatus"
    assert field_units(ARCHO, full, "/left/battery_level", kind)["percentage"] == "%"
    assert field_units(ARCHO, full, "/battery_level", kind) == {}
    path = tmp_path / "robot.yaml"
    path.write_text(
        "gauges:\n"
        "- {title: Tank, topic: tank, type: std_msgs/msg/Float32, field: data, unit: l}\n"
        "- {title: Oil, topic: oil, type: std_msgs/msg/Float32, field: {field: data, scale: 10},"
        " unit: bar}\n"
    )
    file = load(path)
    assert field_units(file, full, "/left/tank", "std_msgs/msg/Float32") == {"data": "l"}
    assert field_units(file, full, "/left/oil", "std_msgs/msg/Float32") == {}
