"""A topic with several readers is subscribed to once: recorded once, counted once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from std_msgs.msg import Float32

from archo_tui.recordings.replay.state import RecordedTopics
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.telemetry import Telemetry
from archo_tui.robot_file.load import load
from tests.support.quiet import until, while_passes
from tests.support.robot import making, robot
from tests.support.stub import StandingClock

FILE = """
version: 1
name: Base
battery: {topic: level, types: {std_msgs/msg/Float32: {percentage: data}}}
gauges:
  - {title: Level, topic: level, type: std_msgs/msg/Float32, field: data, unit: "%"}
stop: none
"""


class Talker(Node):
    """Publishes at 10 Hz."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        level = self.create_publisher(Float32, "level", 10)
        self.create_timer(0.1, lambda: level.publish(Float32(data=80.0)))


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "base.yaml"
    made.write_text(FILE)
    return made


async def test_live_both_are_read_and_the_rate_is_that_of_the_publisher(file: Path) -> None:
    made: list[Any] = []
    async with robot(making(made, Talker), robot=file) as it:
        await until(lambda: it.snapshot.battery.percentage == 80.0)
        await until(lambda: it.snapshot.gauges[0].value == 80.0)
        await while_passes(3)
        rate = it.snapshot.message_rates["/level"].hertz
        assert rate is not None
        assert 8.0 < rate < 13.0
        assert made[0].count_subscribers("level") == 1


def test_in_a_replay_both_are_read(file: Path) -> None:
    topics = RecordedTopics({"/level": "std_msgs/msg/Float32"}, "/")
    heard: list[str] = []
    telemetry = Telemetry(
        topics,  # type: ignore[arg-type]
        load(file),
        StandingClock(),
        lambda topic, _: heard.append(topic),
        lambda _: None,
    )
    telemetry.resubscribe()
    topics.callbacks["/level"](Float32(data=80.0))
    assert telemetry.battery.percentage == 80.0
    assert telemetry.gauges[0].value == 80.0
    assert heard == ["level"]


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

    class Both(Talker):
        def __init__(self, **options: Any) -> None:
            super().__init__(**options)
            self.create_publisher(Float32, "refused", 10)
            self.create_publisher(Float32, "unread", 10)

    monkeypatch.setattr(ConsoleNode, "create_subscription", refusing)
    async with robot(Both, robot=file) as it:
        await until(lambda: it.snapshot.gauges[0].value == 80.0)
        reason = "RuntimeError: incompatible type"
        why = f"is std_msgs/msg/Float32, and cannot be subscribed to here: {reason}"
        assert it.snapshot.faults["refused"] == f"refused {why}"
        texts = [event.text for event in it.snapshot.events]
        assert f"refused {why}" in texts
        assert f"not recorded: unread {why}" in texts
        await while_passes(3)
        assert [event.text for event in it.snapshot.events] == texts
