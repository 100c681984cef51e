"""Goals that other clients send: seen, followed to their end, cancelled after a question."""

from __future__ import annotations

import random
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import Any, cast

import pytest
from action_msgs.msg import GoalStatus
from archo_interfaces.srv import EmergencyStop
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from std_msgs.msg import String

from archo_tui.robot.outcome import Code
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.session.session import _robots_nodes
from tests.support.archo import go, reset
from tests.support.clock import seconds
from tests.support.console import BRISK, FAST, LONG, Console, console
from tests.support.quiet import ended, until
from tests.support.robot import robot
from tests.support.ros import begin
from tests.support.stand_in import Made, Other, StandIn

ROBOT = [*_robots_nodes(False).values()]


@asynccontextmanager
async def shared(*ros_args: str) -> AsyncIterator[tuple[Console, Other]]:
    """The console with ARCHO, and another client of it."""
    other = Made(Other)
    async with console(*ros_args, node_makers=[*ROBOT, other]) as op:
        await op.until(other.node.client.server_is_ready)
        yield op, other.node


async def test_the_goal_of_another_client_is_shown_and_its_end_is_history() -> None:
    async with shared(*BRISK) as (op, other):
        other.go(shelf=12)
        await op.until("MOVING (another client's goal)")
        await op.until("m left of 18.0 m")
        assert "MOVING (another client's goal)" in op.line(" ARCHO ")
        await op.until("✓ ARRIVED")
        assert "Arrived at shelf 12" in op.line("✓ ARRIVED")
        await op.until("✓ arrived (another client)")
        await op.until("another client's goal arrived: Arrived at shelf 12")
        assert other.told == [GoalStatus.STATUS_SUCCEEDED]


async def test_a_console_that_comes_in_the_middle_of_a_goal_sees_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants
    other = Made(Other)
    slow = ("-p", "feedback_period:=0.1", "-p", "route_length:=1000.0")
    async with robot(*ROBOT, other, ros_args=slow) as first:
        await until(lambda: other.node.client.server_is_ready())
        other.node.go(shelf=7)
        await until(lambda: first.snapshot.goal and first.snapshot.goal.remaining)
        began = seconds()
        await until(lambda: seconds() > began + 1.5)  # by its age it has not just begun
        domain = other.node.context.get_domain_id()
        async with robot(only=True, nodes=4, domain_id=domain) as second:
            await until(lambda: second.snapshot.goal and second.snapshot.goal.remaining)
            goal = second.snapshot.goal
            assert goal is not None
            assert (goal.mine, goal.phase) == (False, Phase.MOVING)
            assert goal.is_found
            assert not cast("Goal", first.snapshot.goal).is_found
            assert not (await ended(second.send(goal.kind, {"shelf_number": 3}))).ok
            assert not (await ended(second.cancel())).ok  # it has no goal of its own
            assert (await ended(second.cancel(another=True))).ok
            await until(lambda: other.node.told == [GoalStatus.STATUS_CANCELED])
            await until(lambda: second.snapshot.goal and not second.snapshot.goal.is_running)


async def test_what_would_touch_another_clients_goal_asks_first() -> None:
    async with shared(*LONG) as (op, other):
        other.go(shelf=12)
        await op.until("MOVING (another client's goal)")
        await op.press("r")
        await op.until("The robot is carrying out another client's goal. Reset")
        await op.press("n", "q")
        await op.until("the nodes of this console would")
        await op.press("n", "5", "home", "down", "down", "s")
        await op.until("carrying out another client's goal, and")
        await op.press("n", "ctrl+z")
        await op.until("its nodes would")
        await op.press("n")
        await op.settle()
        assert other.told == []
        assert "MOVING (another client's goal)" in op.text

        await op.press("ctrl+c")
        await op.until("Another client sent this goal. Cancel it?")
        await op.press("n")
        await op.settle()
        assert other.told == []
        await op.press("ctrl+c")
        await op.until("Another client sent this goal. Cancel it?")
        await op.press("y")
        await op.until(lambda: other.told == [GoalStatus.STATUS_CANCELED])
        await op.until("✗ cancelled (another client)")

        other.go(shelf=7)
        await op.until("MOVING (another client's goal)")
        await op.press("ctrl+p")
        await op.type("cancel every goal")
        await op.until("whoever sent it")
        await op.press("enter")
        await op.until("other clients' too?")
        await op.press("y")
        await op.until(lambda: other.told == [GoalStatus.STATUS_CANCELED] * 2)
        await op.until("cancel every goal: cancelling 1 goal")


async def test_a_late_yes_cancels_no_other_goal_than_the_one_that_was_asked_about() -> None:
    async with shared(*LONG) as (op, other):
        other.go(shelf=12)
        await op.until("MOVING (another client's goal)")
        first = op.app.view.snapshot.running_goal
        assert first is not None
        await op.press("ctrl+c")
        await op.until("Another client sent this goal. Cancel it?")
        begin(other, other.sent.cancel_goal_async)
        await op.until(lambda: other.told == [GoalStatus.STATUS_CANCELED])
        other.go(shelf=7)

        def is_another() -> bool:
            goal = op.app.view.snapshot.running_goal
            return goal is not None and goal.number != first.number

        await op.until(is_another)
        await op.press("y")
        await op.until("the goal that was asked about has ended")
        await op.settle()
        assert other.told == [GoalStatus.STATUS_CANCELED]
        assert op.app.view.snapshot.running_goal is not None


async def test_a_cancel_of_anothers_goal_that_the_robot_rejects_says_so() -> None:
    other, stubborn = Made(Other), partial(StandIn, "stubborn", goals="drive", heeds=False)
    async with console(node_makers=[stubborn, other], wait=False) as op:
        await op.until(other.node.client.server_is_ready)
        other.node.go(shelf=1)
        await op.until("MOVING (another client's goal)")
        await op.press("ctrl+c", "y")
        await op.until("the robot rejected the cancel")
        await op.until("MOVING (another client's goal)")


async def test_what_the_console_says_ended_is_what_each_client_was_told_forty_of_forty() -> None:
    chance, other = random.Random(13), Made(Other)
    async with robot(*ROBOT, other, ros_args=FAST) as it:
        await until(lambda: other.node.client.server_is_ready())
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        for number in range(40):
            ours, told = number % 2 == 0, len(other.node.told)
            before = it.snapshot.history[:1]
            if ours:
                assert (await ended(go(it, 12))).ok
            else:
                other.node.go(shelf=12)

            def was_seen(ours: bool = ours, before: tuple[Goal, ...] = before) -> bool:
                goal = it.snapshot.goal
                if goal is not None and goal.is_running:
                    return goal.mine == ours and goal.remaining is not None
                # In real time, on a busy machine, it may have arrived between two looks.
                return it.snapshot.history[:1] != before

            await until(was_seen)
            if number == 0:  # what was asked about is gone by now, and another one runs
                assert not (await ended(it.cancel(another=ours))).ok
            refused = False
            if chance.random() < 0.5:
                refused = not (await ended(it.cancel(another=not ours))).ok
            await until(lambda: it.snapshot.goal and not it.snapshot.goal.is_running)
            over = it.snapshot.history[0]
            assert over.mine == ours
            assert not refused or over.phase == Phase.ARRIVED  # before the cancel came
            if not ours:
                await until(lambda told=told: len(other.node.told) == told + 1)  # type: ignore[misc]
                succeeded = other.node.told[-1] == GoalStatus.STATUS_SUCCEEDED
                assert succeeded == (over.phase == Phase.ARRIVED)


async def test_two_consoles_see_each_other_come_and_go_and_what_the_other_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants
    async with shared(*FAST) as (op, other):
        domain = other.context.get_domain_id()
        assert "consoles" not in op.line(" ARCHO ")
        async with robot(only=True, nodes=4, domain_id=domain) as second:
            await op.until("2 consoles")
            await op.until(f"console {op.app.view.snapshot.consoles[0]} came")
            await until(lambda: len(second.snapshot.consoles) == 1)
            assert second.snapshot.duplicate_nodes == ()
            assert not any("_archo_console" in node.name for node in second.snapshot.nodes)
            await until(lambda: "reset_encoder" in second.snapshot.offered)
            assert (await ended(reset(second))).ok
            await op.until("reset encoder: Encoder reset to zero")
            name = op.app.view.snapshot.consoles[0]
            assert f"✓  {name}: reset encoder: Encoder reset to zero" in op.text
            events = op.app.view.snapshot.events
            (event,) = [event for event in events if event.text.startswith("reset encoder")]
            assert event.audit_record == ("reset", {}, Code.DONE)
            await until(lambda: second.snapshot.motion.count == 0)
            await op.press("ctrl+x")
            await until(lambda: any("STOP: " in event.text for event in second.snapshot.events))
        await op.until("left")
        await op.until(lambda: "consoles" not in op.line(" ARCHO "))
        assert "by another client" not in op.text


class Older(Node):
    """A console that publishes what it does in another form; the log is as it was."""

    def __init__(self, **options: Any) -> None:
        super().__init__("_archo_console_older_lab_1", **options)
        self.create_publisher(String, "_archo_console/acts_0", 10)
        self.client = self.create_client(EmergencyStop, "emergency_stop")

    def stop(self) -> None:
        self.client.call_async(EmergencyStop.Request())
        self.get_logger().info("STOP: confirmed")


async def test_what_a_console_does_that_does_not_tell_it_is_another_consoles() -> None:
    older = Made(Older)
    async with console(*FAST, node_makers=[*ROBOT, older]) as op:
        await op.until("2 consoles")
        await op.until(older.node.client.service_is_ready)
        older.node.stop()
        await op.until("older_lab_1: STOP: confirmed")
        await op.until("stopped by another console")


async def test_what_no_console_did_is_by_another_client_whatever_that_publishes() -> None:
    async with shared(*FAST) as (op, other):
        publisher = other.create_publisher(String, audit_records.TOPIC, 10)
        await op.until(lambda: publisher.get_subscription_count() == 1)
        stop = audit_records.to_json(
            "nobody", audit_records.AuditRecord("stop", {}, Code.DONE), "STOP: by nobody"
        )
        for form in ("", "\x1b[2J", "[" * 10_000, "{}", stop):
            publisher.publish(String(data=form))
        client = other.create_client(EmergencyStop, "emergency_stop")
        await op.until(client.service_is_ready)
        client.call_async(EmergencyStop.Request())
        await op.until("stopped by another client")
        levels = {event.level for event in op.app.view.snapshot.events}
        assert "ERROR" not in levels
        assert "by nobody" not in op.text
        parameters = AsyncParameterClient(other, "motor_controller")
        await op.until(parameters.services_are_ready)
        parameters.set_parameters([Parameter("max_speed", value=0.5)])
        await op.until("motor_controller max_speed changed by another client: 0.5, was 0.8")


async def test_watching_shows_everything_and_commands_nothing() -> None:
    other = Made(Other)
    async with console(*LONG, node_makers=[*ROBOT, other], watch=True) as op:
        await op.until(other.node.client.server_is_ready)
        assert "watching" in op.line(" ARCHO ")
        assert not op.app.main.starts_in_field
        assert op.focused_panel == 4
        own = op.session.robot.node
        clients = {client.service_name for client in own.clients}
        assert not any("send_goal" in name or "cancel_goal" in name for name in clients)
        assert not any("emergency_stop" in name or "/set_parameters" in name for name in clients)
        other.node.go(shelf=12)
        await op.until("MOVING (another client's goal)")
        await op.until("m left of")
        for key in ("ctrl+x", "r", "ctrl+c", "c"):
            await op.press(key)
            await op.until("watching only: start archo-tui without --watch")
            op.app.clear_notifications()
            await op.until(lambda: "watching only" not in op.text)
        await op.press("4", "enter")
        await op.until("watching only: start archo-tui without --watch")
        assert op.app.screen is op.app.main
        assert not op.app.view.snapshot.motion.stopped
        assert other.node.told == []
        assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]
