"""A topic is looked at by a subscription of its own, only while somebody asks, and cheaply."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Float32MultiArray, String, UInt8MultiArray

from archo_tui.errors import ArchoError
from archo_tui.robot import inspection
from archo_tui.robot.listener import Listener
from tests.support.quiet import until
from tests.support.robot import making, robot

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Talker(Node):
    """Publishes at 10 Hz, best effort, and once a message that is kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        fast = self.create_publisher(String, "fast", qos_profile_sensor_data)
        self.create_timer(0.1, lambda: fast.publish(String(data="hello")))
        self.kept = self.create_publisher(UInt8MultiArray, "kept", LATCHED)
        self.kept.publish(UInt8MultiArray(data=bytes(5_000)))


async def test_messages_are_counted_from_begin_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    recorded: list[str] = []
    made: list[Talker] = []
    seen = Listener.__init__

    def listen(self: Any, name: str, on_message: Any, *given: Any, **options: Any) -> None:
        seen(self, name, lambda topic, _: recorded.append(topic), *given, **options)

    monkeypatch.setattr(Listener, "__init__", listen)
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


async def test_a_message_that_is_kept_comes_at_once() -> None:
    async with robot(making([], Talker)) as it, it.inspect("/kept", UInt8MultiArray) as counted:
        await until(lambda: counted.count)
        assert len(counted.decode(counted.newest[1]).data) == 5_000


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
    monkeypatch.setattr(inspection, "MAX_BYTES", 4_000)
    async with robot(making([], Talker)) as it, it.inspect("/kept", UInt8MultiArray) as counted:
        await until(lambda: counted.count)
        assert counted.size > 5_000
        with pytest.raises(ArchoError, match=r"a message of 0\.0 MB, more than 0\.004 MB"):
            counted.decode(counted.newest[1])


async def test_bytes_of_another_definition_are_an_error_in_a_line() -> None:
    async with robot(making([], Talker)) as it, it.inspect("/fast", String) as counted:
        await until(lambda: counted.count)
        counted._class = Float32MultiArray
        with pytest.raises(ArchoError, match="its publisher may have another definition"):
            counted.decode(counted.newest[1])
