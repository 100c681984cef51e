"""What is on the graph is checked: nothing is guessed, and no value ends the console."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus
from rclpy.action import ActionServer
from rclpy.node import Node
from std_msgs.msg import Float32, String

from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.widgets.bars import header
from archo_tui.station.history import History
from archo_tui.station.view import View
from archo_tui.text.state import age_text, battery_line, battery_word, motion_word, plain_text
from tests.support import chosen, clock
from tests.support.alarms import conditions
from tests.support.archo import go
from tests.support.console import console
from tests.support.night import corners
from tests.support.plain import operated
from tests.support.quiet import Quiet, ended, until, while_passes
from tests.support.robot import robot
from tests.support.ros import Ros


def publisher(kind: Any, topic: str, *messages: Any, period: float = 1.0) -> Callable[..., Node]:
    """A node that publishes these in turn."""

    class Publisher(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__(f"publisher_{topic}", **options)
            self.sent = 0
            self.publisher = self.create_publisher(kind, topic, 10)
            self.create_timer(period, self.publish)

        def publish(self) -> None:
            self.publisher.publish(messages[self.sent % len(messages)])
            self.sent += 1

    return Publisher


def battery(**fields: Any) -> Callable[..., Node]:
    return publisher(BatteryStatus, "battery_level", BatteryStatus(**fields))


def text(snapshot: Snapshot) -> str:
    return plain_text(battery_line(snapshot, clock.seconds(), 80))


@pytest.mark.parametrize("value", corners([float("nan")], [3e38]))
async def test_a_percentage_that_cannot_be_is_shown_as_received_and_is_not_good(
    value: float,
) -> None:
    async with console(
        node_makers=[publisher(Float32, "battery_level", Float32(data=value))], wait=False
    ) as op:
        await op.until("? UNREADABLE ")
        assert "GOOD" not in op.text
        assert "LOW" not in op.text
        assert op.app.view.snapshot.battery.percentage is None
        said = [e for e in op.app.view.snapshot.events if "is not within 0 .. 100" in e.text]
        assert len(said) == 1
        assert said[0].count == 1
        await op.press("f1")  # it lives
        await op.until("STOP is a software stop")


@pytest.mark.parametrize(
    ("topic", "kinds"),
    [
        ("battery_level", "archo_interfaces/msg/BatteryStatus or std_msgs/msg/Float32"),
        ("motor_status", "archo_interfaces/msg/MotorStatus"),
    ],
)
async def test_another_type_on_a_topic_is_said_and_not_guessed_at(topic: str, kinds: str) -> None:
    async with robot(publisher(String, topic, String(data="x"))) as it:
        await until(lambda: topic in it.snapshot.faults)
        fault = f"{topic} is std_msgs/msg/String: expected {kinds}"
        assert it.snapshot.faults[topic] == fault
        assert [e.text for e in it.snapshot.events] == [fault]
        assert battery_word(it.snapshot)[1] == "NO DATA"
        assert "IDLE" not in plain_text(motion_word(it.snapshot, clock.seconds(), 80))


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="Fast DDS has one type a topic")
async def test_a_topic_of_two_types_that_would_both_do_is_said() -> None:
    one = publisher(Float32, "battery_level", Float32(data=50.0))

    class Other(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("other", **options)
            self.create_publisher(BatteryStatus, "battery_level", 10)

    said = "battery_level has several types: archo_interfaces/msg/BatteryStatus, "
    async with robot(one, Other) as it:
        await until(lambda: f"{said}std_msgs/msg/Float32" in [e.text for e in it.snapshot.events])


async def test_an_unknown_word_of_health_is_shown_and_hides_no_low_battery() -> None:
    async with robot(battery(percentage=80.0, voltage=24.0, battery_health="swollen")) as it:
        await until(lambda: it.snapshot.battery.received)
        assert battery_word(it.snapshot)[:2] == ("?", "swollen")
        assert "battery health" in conditions(it.snapshot, clock.seconds())
    async with robot(battery(percentage=10.0, voltage=21.0, battery_health="swollen")) as it:
        await until(lambda: it.snapshot.battery.received)
        assert battery_word(it.snapshot)[1] == "LOW"


class Strange(Node):
    """Has parameters of ARCHO's names, which hold words."""

    def __init__(self, **options: Any) -> None:
        super().__init__("battery_monitor", **options)
        self.declare_parameter("low_battery_threshold", "twenty", ignore_override=True)


class StrangeMotor(Node):
    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", **options)
        self.declare_parameter("route_length", "far", ignore_override=True)


async def test_a_parameter_that_is_no_number_ends_nothing_and_is_not_used() -> None:
    async with console(node_makers=[Strange, StrangeMotor], wait=False) as op:
        await op.until("twenty")
        await op.until("far")
        assert op.app.view.snapshot.low_charge == 20.0
        await op.until("low 20")


def in_namespace(make: Any, namespace: str) -> Callable[..., Node]:
    """The same node in another robot's namespace."""
    return lambda **options: make(cli_args=["--ros-args", "-r", f"__ns:={namespace}"], **options)


async def test_another_robots_nodes_parameters_and_logs_are_not_its_own() -> None:
    class Other(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("battery_monitor", **options)
            self.declare_parameter("low_battery_threshold", 77.0)
            self.create_timer(0.5, lambda: self.get_logger().error("Goal refused: not yours"))

    makers = [in_namespace(Other, "/r2"), in_namespace(Other, "/r1")]
    async with robot(*makers, nodes=1, namespace="/r1") as it:
        await until(lambda: it.snapshot.parameters)
        await until(lambda: it.snapshot.events)
        assert {n.name for n in it.snapshot.nodes} == {"/r1/battery_monitor"}
        assert {p.node for p in it.snapshot.parameters} == {"/r1/battery_monitor"}
        assert {e.source for e in it.snapshot.events} == {"r1.battery_monitor"}
        assert it.snapshot.low_charge == 77.0
        assert it.snapshot.other_namespaces == ("/r2",)


async def test_hidden_nodes_are_not_listed() -> None:
    hidden = lambda **options: Node("_tool", **options)  # noqa: E731
    async with robot(hidden, battery(percentage=50.0), nodes=1) as it:
        await until(lambda: it.snapshot.battery.received)
        assert "/_tool" not in {node.name for node in it.snapshot.nodes}


@pytest.mark.waits
async def test_a_robot_that_speaks_every_30_s_is_not_lost() -> None:
    slow = publisher(Float32, "battery_level", Float32(data=50.0), period=30.0)
    async with robot(slow) as it:
        for _ in range(2 if clock.current is None else 4):  # real time costs as much
            heard = it.snapshot.battery.received
            again = lambda heard=heard: it.snapshot.battery.received != heard  # noqa: E731
            await Quiet().until(again, lambda: "the next message", deadline=90.0)
            assert conditions(it.snapshot, clock.seconds() + 29.0) == {}


@pytest.mark.waits
async def test_a_new_pace_that_the_operator_sets_is_measured_anew() -> None:
    async with operated(ros_args=("-p", "drain_max:=0.0", "-p", "drain_min:=0.0")) as person:
        it = person._plain._station.robot
        await while_passes(10.0)
        outcome = it.set_parameters("/battery_monitor", {"publish_period": 10.0})
        assert (await ended(outcome)).ok
        for _ in range(4):
            await while_passes(9.0)
            view = person._plain._station.view
            assert "silent" not in header(view, 120).plain
            assert "(old" not in text(it.snapshot)


async def test_an_action_of_another_type_is_greyed_with_its_type(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants
    domain = chosen.next_domain()
    elsewhere = Ros(domain_id=domain)  # of one process, DDS allows one type a topic
    other = elsewhere.node("other")
    other.create_publisher(String, "move_to_shelf/_action/feedback", 10)
    own = lambda **options: Node("own", **options)  # noqa: E731
    async with robot(own, nodes=2, domain_id=domain) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.faults)
        fault = it.snapshot.faults["move_to_shelf"]
        assert fault.startswith("move_to_shelf is std_msgs/msg/String: expected archo_interfaces/")
        outcome = await ended(go(it, 3))
        assert (outcome.ok, outcome.text) == (False, fault)
    elsewhere.close()


@pytest.mark.waits
async def test_two_publishers_are_named_in_the_panel_and_an_alarm_when_they_stay() -> None:
    def second(**options: Any) -> Node:
        return battery(percentage=60.0)(cli_args=["--ros-args", "-r", "__node:=second"], **options)

    async with console(node_makers=[battery(percentage=50.0), second], wait=False) as op:
        begin = clock.seconds()
        await op.until("2 publishers: ")
        await op.at(begin + 20)
        assert "PUBLISHERS" not in op.text.splitlines()[1]  # one that was killed lingers so long
        await op.until("2 PUBLISHERS of battery_level: /publisher_battery_level, /second")
        names = conditions(op.app.view.snapshot, clock.seconds())
        assert "several publishers /battery_level" in names


async def test_two_nodes_of_one_name_are_an_alarm() -> None:
    twin = lambda **options: Node("twin", **options)  # noqa: E731
    async with robot(twin, twin, nodes=1) as it:
        await until(lambda: it.snapshot.duplicate_nodes == ("/twin",))
        assert "name twice /twin" in conditions(it.snapshot, clock.seconds())


async def test_clients_of_nodes_that_have_gone_are_destroyed() -> None:
    async with robot(battery(percentage=50.0)) as it:
        await until(lambda: it.snapshot.parameters)
        node = it.node
        before = len(node._kept_clients)
        for _ in range(3):
            guest = Node("guest", context=it.node.context)
            guest.declare_parameter("x", 1)
            await until(lambda: any(n.name == "/guest" for n in it.snapshot.nodes))
            guest.destroy_node()
            await until(lambda: all(n.name != "/guest" for n in it.snapshot.nodes))
        assert len(node._kept_clients) <= before


async def test_a_refusal_in_the_log_counts_only_from_the_node_that_moves() -> None:
    class Liar(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("liar", **options)
            self.create_timer(0.01, lambda: self.get_logger().info("Goal refused: I say so"))

    class Refusing(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("refusing", **options)
            self.asked = 0
            self.action = ActionServer(
                self, MoveToShelf, "move_to_shelf", lambda _: None, goal_callback=self.refuse
            )

        def refuse(self, _: Any) -> Any:
            if not self.asked:
                self.get_logger().warning("Goal refused: the road is wet")
            self.asked += 1

    async with robot(Liar, Refusing, offers="move_to_shelf") as it:
        await until(lambda: any("I say so" in e.text for e in it.snapshot.events))
        outcome = await ended(go(it, 3))
        assert (outcome.ok, outcome.text) == (False, "the road is wet")
        assert (await ended(go(it, 4))).text == "refused, no reason given"


async def test_nodes_that_come_in_another_namespace_are_seen_from_an_empty_one() -> None:
    own = lambda **options: Node("own", **options)  # noqa: E731
    async with robot(own, namespace="/r1") as it:
        await until(lambda: it.snapshot.parameters)
        begin = clock.seconds()
        await until(lambda: clock.seconds() > begin + 3)
        guest = Node("guest", context=it.node.context, namespace="/r2", use_global_arguments=False)
        await until(lambda: it.snapshot.other_namespaces == ("/r2",))
        view = View(it.snapshot, begin, begin, 0.0, "embedded", "/r1", History())
        assert "? robots seen: /r2; use --namespace /r2" in header(view, 120).plain
        guest.destroy_node()


def test_an_age_is_in_seconds_up_to_two_minutes_and_never_wide() -> None:
    told = {
        0.0: "0.0 s",
        9.94: "9.9 s",
        9.96: "10 s",
        61.0: "61 s",
        119.4: "119 s",
        119.9: "120 s",
        120.0: "2 min",
        599.0: "9 min",
        600.0: "0.2 h",
        36_000.0: "10 h",
    }
    assert {seconds: age_text(seconds) for seconds in told} == told
    assert all(len(age_text(tenth / 10)) <= 5 for tenth in range(10_000))
