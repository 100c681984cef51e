"""What another node sees of battery_monitor and dashboard."""

from __future__ import annotations

from typing import Any

import pytest
from archo_bringup.battery_monitor import BatteryMonitor
from archo_bringup.dashboard import Dashboard
from archo_bringup.fake_battery_drain import FakeBatteryDrain
from archo_interfaces.msg import BatteryStatus
from rcl_interfaces.msg import Log
from rclpy.exceptions import InvalidParameterValueException
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool

from tests.support.ros import Ros
from tests.support.waiting import wait_until

FAST = ["--ros-args", "-p", "publish_period:=0.02"]


def watch(ros: Ros) -> list[BatteryStatus]:
    heard: list[BatteryStatus] = []
    ros.spun("watcher").create_subscription(BatteryStatus, "battery_level", heard.append, 100)
    return heard


def start(ros: Ros, kind: Any = BatteryMonitor, *words: str) -> Any:
    node = ros.node(kind=kind, cli_args=[*FAST, *words])
    ros.spin(node)
    return node


def test_the_battery_is_published_and_drains_a_little_each_tick(ros: Ros) -> None:
    heard = watch(ros)
    start(ros)
    wait_until(lambda: len(heard) >= 5)
    first, second = heard[0], heard[1]
    assert first.percentage <= 87.5
    assert 0.04 < first.percentage - second.percentage < 0.21
    assert first.voltage == pytest.approx(20.6 + 0.04 * first.percentage, abs=1e-4)
    assert (first.battery_health, first.is_charging) == ("good", False)


def test_health_warns_below_the_threshold_parameter(ros: Ros) -> None:
    heard = watch(ros)
    node = start(ros)
    wait_until(lambda: heard)
    assert node.set_parameters([Parameter("low_battery_threshold", value=95.0)])[0].successful
    wait_until(lambda: heard[-1].battery_health == "warning")
    node.set_parameters([Parameter("low_battery_threshold", value=20.0)])
    wait_until(lambda: heard[-1].battery_health == "good")


def test_charging_is_switched_by_the_service(ros: Ros) -> None:
    heard = watch(ros)
    start(ros, BatteryMonitor, "-p", "charge_rate:=100.0")
    client = ros.spun("operator").create_client(SetBool, "set_charging")
    assert client.wait_for_service(10.0)
    assert ros.result(client.call_async(SetBool.Request(data=True))).message == "Charging"
    wait_until(lambda: heard and heard[-1].is_charging and heard[-1].percentage == 100.0)
    assert ros.result(client.call_async(SetBool.Request(data=False))).message == "Not charging"
    wait_until(lambda: not heard[-1].is_charging and heard[-1].percentage < 100.0)


def test_a_new_period_takes_effect_at_once(ros: Ros) -> None:
    heard = watch(ros)
    node = ros.node(kind=BatteryMonitor, cli_args=["--ros-args", "-p", "publish_period:=10.0"])
    ros.spin(node)
    assert heard == []
    node.set_parameters([Parameter("publish_period", value=0.02)])
    wait_until(lambda: len(heard) >= 3)


def test_drain_min_above_drain_max_is_refused(ros: Ros) -> None:
    node = start(ros)
    result = node.set_parameters([Parameter("drain_min", value=0.5)])[0]
    assert (result.successful, result.reason) == (False, "drain_min 0.5 is above drain_max 0.2")
    both: list[Parameter[Any]] = [
        Parameter("drain_min", value=0.5),
        Parameter("drain_max", value=0.6),
    ]
    assert node.set_parameters_atomically(both).successful
    with pytest.raises(InvalidParameterValueException, match="above drain_max"):
        ros.node(kind=BatteryMonitor, cli_args=["--ros-args", "-p", "drain_min:=50.0"])


def test_every_parameter_is_described(ros: Ros) -> None:
    node = ros.node(kind=BatteryMonitor)
    for name in ("low_battery_threshold", "publish_period", "drain_min", "drain_max"):
        descriptor = node.describe_parameter(name)
        assert descriptor.description
        assert descriptor.floating_point_range


def test_the_drain_node_empties_the_battery(ros: Ros) -> None:
    heard = watch(ros)
    start(ros)
    drain = ros.node(kind=FakeBatteryDrain, cli_args=["--ros-args", "-p", "drain:=100.0"])
    ros.spin(drain)
    wait_until(lambda: heard and heard[-1].percentage == 0.0)


def test_while_it_charges_the_drain_node_takes_nothing_off(ros: Ros) -> None:
    heard = watch(ros)
    start(ros, BatteryMonitor, "-p", "charge_rate:=1.0")
    client = ros.spun("operator").create_client(SetBool, "set_charging")
    assert client.wait_for_service(10.0)
    ros.result(client.call_async(SetBool.Request(data=True)))

    def charging() -> list[float]:
        return [reading.percentage for reading in heard if reading.is_charging]

    wait_until(charging)
    ros.spin(ros.node(kind=FakeBatteryDrain, cli_args=["--ros-args", "-p", "drain:=100.0"]))
    wait_until(lambda: charging()[-1] > charging()[0] + 2.5)  # 2.5 s: it drains once a second
    assert charging() == sorted(charging())


def test_the_dashboard_logs_what_it_sees_and_warns_when_low(ros: Ros) -> None:
    lines: list[Log] = []
    ros.spun("reader").create_subscription(Log, "/rosout", lines.append, 100)
    ros.spin(ros.node(kind=Dashboard))
    publisher = ros.node("battery").create_publisher(BatteryStatus, "battery_level", 10)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(BatteryStatus(percentage=87.5, battery_health="good"))
    publisher.publish(BatteryStatus(percentage=18.0, battery_health="warning"))

    def said() -> list[tuple[int, str]]:
        return [(line.level, line.msg) for line in [*lines] if line.name == "dashboard"]

    wait_until(lambda: len(said()) == 3)
    assert said() == [
        (20, "Dashboard sees: 87.5%"),
        (20, "Dashboard sees: 18.0%"),
        (30, "Low battery: 18.0%"),
    ]
