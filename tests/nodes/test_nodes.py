"""What another node sees of battery_monitor, dashboard and motor_controller."""

from __future__ import annotations

from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from archo_bringup.battery_monitor import BatteryMonitor
from archo_bringup.dashboard import Dashboard
from archo_bringup.fake_battery_drain import FakeBatteryDrain
from archo_bringup.motor_controller import MotorController
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus, MotorStatus
from archo_interfaces.srv import EmergencyStop, ResetEncoder
from rcl_interfaces.msg import Log
from rclpy.action import ActionClient
from rclpy.exceptions import InvalidParameterValueException
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from tests.support.ros import Ros, begin
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


# motor_controller.

# the default move in a tenth of the time: 3 m each 0.05 s
QUICK = ["-p", "feedback_period:=0.05", "-p", "time_scale:=75.0"]


class Operator:
    """A client of the motor controller, and everything it hears."""

    def __init__(self, ros: Ros, *words: str) -> None:
        self.ros = ros
        self.motor: Any = ros.node(kind=MotorController, cli_args=["--ros-args", *QUICK, *words])
        ros.spin(self.motor)
        node = self.node = ros.node("operator")
        self.feedback: list[float] = []
        self.status: list[MotorStatus] = []
        self.log: list[tuple[int, str]] = []
        node.create_subscription(MotorStatus, "motor_status", self.status.append, 100)
        node.create_subscription(Log, "/rosout", lambda m: self.log.append((m.level, m.msg)), 100)
        self.action = ActionClient(node, MoveToShelf, "move_to_shelf")
        ros.spin(node)  # not before: rclpy's action client is not ready while it is made
        assert self.action.wait_for_server(10.0)
        wait_until(lambda: self.status)

    def send(self, shelf: int = 12) -> Any:
        sent = begin(
            self.node,
            self.action.send_goal_async,
            MoveToShelf.Goal(shelf_number=shelf),
            lambda m: self.feedback.append(m.feedback.distance_remaining),
        )
        return self.ros.result(self.ros.result(sent))

    def outcome(self, handle: Any) -> tuple[int, bool, str]:
        answer = self.ros.result(handle.get_result_async())
        return answer.status, answer.result.success, answer.result.final_message

    def call(self, srv_type: Any, name: str) -> Any:
        client = self.node.create_client(srv_type, name)
        assert client.wait_for_service(10.0)
        return self.ros.result(client.call_async(srv_type.Request()))

    def set(self, name: str, value: Any) -> None:
        assert self.motor.set_parameters([Parameter(name, value=value)])[0].successful


def test_a_default_move_reports_every_three_metres_and_arrives(ros: Ros) -> None:
    operator = Operator(ros)
    handle = operator.send()
    assert operator.outcome(handle) == (GoalStatus.STATUS_SUCCEEDED, True, "Arrived at shelf 12")
    wait_until(lambda: len(operator.feedback) == 6)
    assert operator.feedback == [15.0, 12.0, 9.0, 6.0, 3.0, 0.0]


def test_encoder_and_speed_follow_the_move(ros: Ros) -> None:
    operator = Operator(ros)
    assert (operator.status[-1].encoder_ticks, operator.status[-1].moving) == (15420, False)
    handle = operator.send()
    wait_until(lambda: operator.status[-1].moving)
    assert operator.status[-1].speed == pytest.approx(0.8)
    operator.outcome(handle)
    wait_until(lambda: not operator.status[-1].moving)
    assert operator.status[-1].speed == 0.0
    assert operator.status[-1].encoder_ticks == 15420 + 58670


def test_a_cancel_at_nine_metres_ends_there(ros: Ros) -> None:
    operator = Operator(ros, "-p", "feedback_period:=0.2", "-p", "time_scale:=18.75")
    handle = operator.send()
    wait_until(lambda: operator.feedback and operator.feedback[-1] == 9.0)
    assert len(ros.result(handle.cancel_goal_async()).goals_canceling) == 1
    assert operator.outcome(handle) == (GoalStatus.STATUS_CANCELED, False, "Cancelled mid-route")
    wait_until(lambda: not operator.status[-1].moving)
    assert operator.feedback == [15.0, 12.0, 9.0]


def test_a_second_goal_is_refused_with_the_reason_and_the_first_goes_on(ros: Ros) -> None:
    operator = Operator(ros)
    handle = operator.send(12)
    assert not operator.send(3).accepted
    assert operator.outcome(handle)[2] == "Arrived at shelf 12"
    wait_until(lambda: (30, "Goal refused: a goal is already running") in operator.log)


@pytest.mark.parametrize("shelf", [0, -1, 41, 2**31 - 1])
def test_a_shelf_that_does_not_exist_is_refused(ros: Ros, shelf: int) -> None:
    operator = Operator(ros)
    assert not operator.send(shelf).accepted
    wait_until(lambda: (30, f"Goal refused: shelf {shelf} is not in 1 .. 40") in operator.log)


def test_the_encoder_resets_at_any_time(ros: Ros) -> None:
    operator = Operator(ros)
    answer = operator.call(ResetEncoder, "reset_encoder")
    assert (answer.success, answer.message) == (True, "Encoder reset to zero")
    wait_until(lambda: operator.status[-1].encoder_ticks == 0)
    wait_until(lambda: (20, "Encoder reset from 15420 ticks") in operator.log)


def test_an_emergency_stop_aborts_latches_and_is_released_apart(ros: Ros) -> None:
    operator = Operator(ros, "-p", "feedback_period:=0.2", "-p", "time_scale:=18.75")
    handle = operator.send()
    wait_until(lambda: operator.feedback and operator.feedback[-1] == 9.0)
    assert operator.call(EmergencyStop, "emergency_stop").success
    assert operator.outcome(handle) == (
        GoalStatus.STATUS_ABORTED,
        False,
        "Emergency stop, 9.0 m before shelf 12",
    )
    wait_until(lambda: operator.status[-1].emergency_stopped)
    assert operator.call(EmergencyStop, "emergency_stop").success
    assert not operator.send().accepted
    wait_until(lambda: (30, "Goal refused: emergency stop: release it first") in operator.log)
    assert operator.call(Trigger, "release_emergency_stop").success
    wait_until(lambda: not operator.status[-1].emergency_stopped)
    assert operator.outcome(operator.send())[1]


def test_an_empty_battery_aborts_the_move_and_refuses_the_next(ros: Ros) -> None:
    operator = Operator(ros, "-p", "feedback_period:=0.2", "-p", "time_scale:=18.75")
    battery = operator.node.create_publisher(BatteryStatus, "battery_level", 10)
    wait_until(lambda: battery.get_subscription_count() == 1)
    handle = operator.send()
    wait_until(lambda: operator.feedback)
    battery.publish(BatteryStatus(percentage=0.0))
    assert operator.outcome(handle) == (GoalStatus.STATUS_ABORTED, False, "Battery empty")
    assert not operator.send().accepted
    battery.publish(BatteryStatus(percentage=5.0))
    wait_until(lambda: not operator.motor.battery_empty)
    assert operator.send().accepted


def test_a_new_feedback_period_takes_effect_mid_route(ros: Ros) -> None:
    operator = Operator(ros, "-p", "feedback_period:=5.0", "-p", "time_scale:=20.0")
    handle = operator.send()
    operator.set("feedback_period", 0.05)
    assert operator.outcome(handle)[1]
    wait_until(lambda: len(operator.feedback) == 23)


def test_a_new_feedback_period_starts_nothing_while_it_stands(ros: Ros) -> None:
    operator = Operator(ros)
    operator.set("feedback_period", 0.1)
    heard = len(operator.status)
    wait_until(lambda: len(operator.status) >= heard + 3)  # its node spins on
    assert not operator.status[-1].moving
    assert operator.outcome(operator.send())[1]
    wait_until(lambda: operator.feedback[-1:] == [0.0])
    assert operator.feedback == [12.0, 6.0, 0.0]
