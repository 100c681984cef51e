"""`echo`, `hz` and `interface`: what is on a topic, how often, why nothing is, and its type."""

from __future__ import annotations

import json
import re
import threading
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32, Header, String

import archo_tui
from tests.support.clock import seconds
from tests.support.console import console
from tests.support.plain import operated, plain
from tests.support.quiet import until, while_passes
from tests.support.ros import begin
from tests.support.shells import served, typed
from tests.support.shells import until as until_beside

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


@pytest.mark.real_time
async def test_a_program_iterates_over_messages() -> None:
    found: list[dict[str, Any]] = []
    errors: list[str] = []

    def run() -> None:
        with archo_tui.connect() as robot:
            for message in robot.messages("fast"):
                found.append(message)
                if len(found) == 3:
                    break
            found.extend(robot.messages("slow", "frame_id", timeout=2.5))
            try:
                next(robot.messages("nosuch"))
            except archo_tui.Misused as error:
                errors.append(str(error))

    async with served(Talker) as person:
        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        await until_beside(lambda: not thread.is_alive())
        counts = [message["data"] for message in found[:3]]
        assert counts == sorted(set(counts))
        assert found[3] == {"frame_id": "map"}
        assert errors == ["no topic /nosuch is on the graph"]
        await until_beside(lambda: not (listens("/fast") or listens("/slow")))
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
