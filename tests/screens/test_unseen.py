"""What is said when nothing is found, and when simulated time has no clock."""

from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from archo_tui.ros import engine
from tests.support import chosen
from tests.support.console import FAST, Console, console
from tests.support.plain import operated


def names(op: Console) -> list[str]:
    return [alarm.name for alarm in op.app.view.alarms]


async def test_without_any_node_the_banner_says_where_was_looked() -> None:
    async with console(only=True, wait=False) as op:
        await op.until("NO NODES ")
        assert names(op) == ["no nodes"]
        if chosen.ENGINE == "embedded":
            await op.until("NO NODES in this process: give one by --node FILE")
        else:
            await op.until(f"NO NODES on domain {op.session.options.domain_id} (rmw_")


async def test_line_by_line_it_is_an_alarm_too() -> None:
    async with operated(only=True) as person:
        await person.until("alarm unacknowledged: NO NODES ")


class Clocked(Node):
    """Publishes simulated time."""

    def __init__(self, **options: Any) -> None:
        super().__init__("simulator", **options)
        clock = self.create_publisher(Clock, "/clock", 1)
        self.create_timer(0.5, lambda: clock.publish(Clock(clock=Time(sec=1))))


class Waiting(Node):
    """Waits for it."""

    def __init__(self, **options: Any) -> None:
        super().__init__("waiting", **options)


async def test_a_node_whose_simulated_time_has_no_clock_is_named() -> None:
    async with console(node_makers=[Waiting], wait=False) as op:
        await op.until(lambda: op.app.view.snapshot.parameters)
        assert (await op.session.robot.set_parameters("/waiting", {"use_sim_time": True})).ok
        await op.until("NO CLOCK for /waiting: use_sim_time is true and nobody publishes /clock")
        assert names(op) == ["no clock"]
        assert (await op.session.robot.set_parameters("/waiting", {"use_sim_time": False})).ok
        await op.until("was: NO CLOCK for /waiting")


async def test_with_a_clock_simulated_time_is_no_alarm() -> None:
    async with console(*FAST, node_makers=[Waiting, Clocked], wait=False) as op:
        await op.until(lambda: len(op.app.view.snapshot.parameters) >= 2)
        assert (await op.session.robot.set_parameters("/waiting", {"use_sim_time": True})).ok
        await op.until(lambda: op.app.view.snapshot.has_clock)
        await op.at(op.app.station.clock.monotonic() + 18.0)
        assert names(op) == []


@pytest.mark.parametrize(
    ("variables", "reach", "tries"),
    [
        (
            {},
            "SUBNET",
            "start the robot, or match its ROS_DOMAIN_ID (`archo-tui look` tries 0 to 20) and RMW",
        ),
        (
            {"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"},
            "LOCALHOST",
            "for a robot elsewhere set ",
        ),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, "OFF", "for a robot elsewhere set "),
        ({"ROS_LOCALHOST_ONLY": "1"}, "LOCALHOST", "for a robot elsewhere unset ROS_LOCAL"),
        ({"ROS_LOCALHOST_ONLY": "0"}, "SUBNET", "start the robot"),
    ],
)
def test_what_to_try_depends_on_how_far_was_looked(
    variables: dict[str, str], reach: str, tries: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)

    class Context:
        def get_domain_id(self) -> int:
            return 42

    context: Any = Context()
    said = engine.no_node_hint(engine.ROS2, context)
    assert said.startswith("on domain 42 (")
    assert f", discovery {reach}): {tries}" in said
