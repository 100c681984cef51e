"""A topic is looked at by a subscription of its own, only while somebody asks, and cheaply."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.parameter import Parameter as RclpyParameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import String, UInt8MultiArray

from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.messages.text import as_text
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.topics import inspect
from archo_tui.robot.topics.rows import TopicRequest
from tests.support.quiet import until, while_passes
from tests.support.robot import making, robot
from tests.support.ros import begin

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Talker(Node):
    """Publishes at 10 Hz, best effort, and once a message that is kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        fast = self.create_publisher(String, "fast", qos_profile_sensor_data)
        self.create_timer(0.1, lambda: fast.publish(String(data="hello")))
        self.kept = self.create_publisher(UInt8MultiArray, "kept", LATCHED)
        self.kept.publish(UInt8MultiArray(data=bytes(5_000)))
        self.deep: Any = None


async def test_messages_are_counted_from_begin_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    recorded: list[str] = []
    made: list[Talker] = []
    seen = ConsoleNode.__init__

    def listen(self: Any, name: str, context: Any, _on_message: Any, masks: Any) -> None:
        seen(self, name, context, lambda topic, *_: recorded.append(topic), masks)

    monkeypatch.setattr(ConsoleNode, "__init__", listen)
    async with robot(making(made, Talker)) as it:
        async with it.inspect("/fast", String) as counted:
            await until(lambda: counted.count >= 5)
            assert counted.decode(counted.newest[1]) == String(data="hello")
            assert counted.least is not None
            assert counted.greatest is not None
            assert 0 < counted.least <= counted.greatest
            assert counted.size == counted.count * 14  # A header, a length, and 6 bytes.
            assert made[0].count_subscribers("/fast") == 1
        await until(lambda: made[0].count_subscribers("/fast") == 0)
        assert "/fast" not in recorded


async def test_a_subscription_that_rclpy_refuses_is_a_fault_and_an_outcome(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(_: object) -> None:
        raise RuntimeError("created topic with other type")

    monkeypatch.setattr(inspect.Inspection, "subscribe", refused)
    said = "/fast: no subscription: RuntimeError: created topic with other type"
    async with robot(making([], Talker)) as it:
        await until(lambda: "/fast" in {end.name for end in it.snapshot.resources})
        with pytest.raises(ArchoError, match=said):
            async with it.inspect("/fast", String):
                pass
        views: list[Any] = []
        task = asyncio.ensure_future(it.follow_topic("/fast", TopicRequest, views.append))
        await until(lambda: views and said in views[-1].fault)
        assert not task.done()
        task.cancel()


async def test_messages_that_are_kept_are_no_rate() -> None:
    made: list[Talker] = []

    def make(**options: Any) -> Node:
        made.append(Talker(**options))
        deep = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        made[0].deep = made[0].create_publisher(String, "deep", deep)
        for _ in range(5):
            made[0].deep.publish(String(data="kept"))
        return made[0]

    async with robot(make) as it, it.inspect("/deep", String) as counted:
        await until(lambda: counted.count)
        await while_passes(1.0)
        assert counted.rate is None
        assert counted.kept == counted.count
        made[0].deep.publish(String(data="new"))
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


async def test_a_caller_that_is_cancelled_leaves_no_subscription() -> None:
    made: list[Talker] = []
    async with robot(making(made, Talker)) as it:

        async def look() -> None:
            async with it.inspect("/fast", String):
                await asyncio.Event().wait()

        looking = asyncio.ensure_future(look())
        await until(lambda: made[0].count_subscribers("/fast") == 1)
        looking.cancel()
        await until(lambda: made[0].count_subscribers("/fast") == 0)


async def test_a_message_beyond_the_bound_is_counted_and_not_decoded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(inspect, "MAX_BYTES", 4_000)
    async with robot(making([], Talker)) as it, it.inspect("/kept", UInt8MultiArray) as counted:
        await until(lambda: counted.count)
        assert counted.size > 5_000
        with pytest.raises(ArchoError, match=r"a message of 0\.0 MB, more than 0\.004 MB"):
            counted.decode(counted.newest[1])


class Changing(Node):
    """Publishes at 10 Hz, reliable at first, and best effort after `change`."""

    def __init__(self, **options: Any) -> None:
        super().__init__("changing", **options)
        self._publisher = self.create_publisher(String, "fast", 10)
        self.create_timer(0.1, lambda: self._publisher.publish(String(data="hello")))

    def change(self) -> None:
        """Replace the publisher."""
        before = self._publisher
        self._publisher = self.create_publisher(String, "fast", qos_profile_sensor_data)
        self.destroy_publisher(before)


async def test_a_publisher_with_another_qos_is_heard_again() -> None:
    made: list[Changing] = []
    async with robot(making(made, Changing)) as it, it.inspect("/fast", String) as counted:
        await until(lambda: counted.count)
        begin(made[0], made[0].change)
        await until(lambda: made[0]._publisher.qos_profile.depth == 5)
        await while_passes(1.0)
        before = counted.count
        it.resubscribe_if_needed(counted)
        await until(lambda: counted.count > before + 2)
        it.resubscribe_if_needed(counted)  # Changes nothing.
        await until(lambda: counted.count > before + 6)


async def test_a_secret_parameter_stays_secret() -> None:
    def secretive(**options: Any) -> Node:
        node = Node("secretive", **options)
        node.declare_parameter("password", "first")
        node.create_timer(0.5, lambda: node.set_parameters([_password("hunter2")]))
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


def _password(value: str) -> RclpyParameter[str]:
    return RclpyParameter("password", value=value)
