"""`echo TOPIC` and `hz TOPIC`: what is on a topic now, how often, and why nothing is."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32, String

from tests.support.plain import plain
from tests.support.shells import served, typed

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Talker(Node):
    """Publishes at 10 Hz, has published once, and never publishes; it hears what nobody sends."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        fast = self.create_publisher(Float32, "fast", 10)
        self.create_timer(0.1, lambda: fast.publish(Float32(data=0.1)))
        self._kept = self.create_publisher(String, "kept", LATCHED)
        self._kept.publish(String(data="once"))
        rare = self.create_publisher(Float32, "rare", 10)
        self.create_timer(2.0, lambda: rare.publish(Float32(data=0.5)))
        self._silent = self.create_publisher(String, "silent", 10)
        self.create_subscription(String, "heard", lambda _: None, 10)


async def test_the_last_message_is_shown_as_yaml() -> None:
    code, said = await plain("echo /motor_status\necho battery_level percentage\n")
    assert code == 0, said
    assert "encoder_ticks: 15420\nspeed: 0.0\nmoving: false\nemergency_stopped: false\n" in said
    assert "\npercentage: 8" in said


async def test_a_message_that_is_kept_is_shown_at_once() -> None:
    code, said = await plain("echo kept\necho fast data\n", Talker)
    assert (code, said) == (0, "data: once\ndata: 0.1\n")


REFUSED = [
    ("echo silent", "echo: no message on /silent in 5 s: nothing arrived from talker"),
    ("echo heard", "echo: no message on /heard in 5 s: it has no publisher"),
    ("echo fas", "echo: no topic /fas is on the graph (nearest: /fast)"),
    ("echo fast dat", "echo: there is no field dat (nearest: data)"),
    ("hz silent", "hz: no message on /silent in 5 s: nothing arrived from talker"),
    ("hz fas", "hz: no topic /fas is on the graph (nearest: /fast)"),
    ("hz", "hz: needs TOPIC"),
]


async def test_why_nothing_is_shown_is_one_line() -> None:
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
    assert rate == pytest.approx(10.0, abs=2.0)


@pytest.mark.waits
async def test_too_few_messages_have_the_rate_of_the_graph_or_none() -> None:
    code, said = await plain("hz kept\nhz rare\n", Talker)
    assert code == 0, said
    assert "/kept: no message in 5 s, but the last one that was sent before\n" in said
    assert re.search(r"/rare: -- Hz, [23] messages in 5 s, ", said)


@pytest.mark.real_time
async def test_a_shell_gets_the_message_as_an_object() -> None:
    async with served() as person:
        result = json.loads((await typed("echo", "motor_status", "--once", "--json")).out)
        assert result["data"]["encoder_ticks"] == 15420
        assert result["data"]["moving"] is False
        shown = await typed("echo", "motor_status", "moving", "--once")
        assert (shown.code, shown.out) == (0, "moving: false\n")
        given_up = await typed("hz", "motor_status", "--timeout", "0.2")
        assert (given_up.code, given_up.err) == (4, "archo-tui: hz: 0.2 s are over\n")
        rate = json.loads((await typed("hz", "motor_status", "--json")).out)["data"]
        assert rate["messages"] > 1
        assert 0 < rate["least"] <= 1 / rate["rate"] <= rate["greatest"]
        await person.end()
