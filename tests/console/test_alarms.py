"""The operator and the alarms: banner, list, acknowledging, shelving; when nothing is found."""

from __future__ import annotations

import json
from functools import partial
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.base.paths import journal_file
from archo_tui.robot.stop.sender import FIRST_FOUND
from archo_tui.ros import engine
from tests.support import chosen
from tests.support.clock import seconds
from tests.support.console import FAST, Console, click, console, console_with
from tests.support.stand_in import StandIn


async def test_an_alarm_that_is_over_stays_until_acknowledged_by_key_or_click() -> None:
    async with console(*FAST) as op:
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        await op.press("R")
        await op.until("Release the stop?")
        await op.press("tab", "enter")
        await op.until("was: STOPPED, since ")
        await op.press("a")
        await op.until(lambda: "was: STOPPED" not in op.text)

        await op.press("escape", "escape")
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        row = next(n for n, line in enumerate(op.text.splitlines()) if "(a acknowledge)" in line)
        click(op.app, op.text.splitlines()[row].index("acknowledge"), row)
        await op.until(lambda: "(a acknowledge)" not in op.text)
        assert "STOPPED: look for the cause" in op.text


async def test_the_list_acknowledges_one_or_all_and_shelves() -> None:
    quiet = ("-p", "drain_min:=0.0", "-p", "drain_max:=0.0", "-p", "low_battery_threshold:=90.0")
    async with console(*FAST, *quiet) as op:
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        await op.until("+1 alarm")
        await op.press("A")
        await op.until("▲ MED   since ")
        assert "STOPPED: look for the cause, then press R to release" in op.words
        assert op.text.count(", unacknowledged") == 2
        await op.press("a")
        await op.until(", acknowledged")
        await op.press("s")
        await op.until(", shelved until ")
        await op.press("A")
        await op.until(lambda: "unacknowledged" not in op.text)
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)
        await op.until("shelved: low battery")
        assert "(a acknowledge)" not in op.text


async def test_stop_is_never_greyed_and_says_when_it_is_not_confirmed() -> None:
    async with console(*FAST) as op:
        motor = next(n for n in op.session.host.nodes if n.name == "/motor_controller")
        motor.begin_to_stop()  # its thread ends, the node stays on the graph and answers nothing
        await op.until(lambda: not motor._thread.is_alive())
        await op.press("ctrl+x")
        await op.until(
            "STOP SENT, no answer for 2 s (not confirmed by the robot): use the hardware"
        )
        await op.until("STOP SENT, no answer for")
        await op.until("STOP: no answer in 2 s")


async def test_a_grave_alarm_is_shelved_with_a_reason_that_the_journal_keeps() -> None:
    class Crashes(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("crashes", **options)
            self.create_timer(0.1, self.crash)

        def crash(self) -> None:
            raise RuntimeError("boom")

    async with console(node_makers=[Crashes], wait=False) as op:
        await op.until("NODE CRASHED /crashes")
        op.send("A", "s", *"a test", "enter")  # as it comes over a slow link
        await op.until(", shelved until ")
        assert ": a test" in op.line("✗ HIGH  since ")
        await op.press("s")
        await op.until(", unacknowledged")
        await op.press("s", "enter")
        await op.until("type a reason")
        await op.press("escape")
        await op.until(", unacknowledged")
        await op.press("s", *"again", "enter", "escape")
        await op.until("shelved: node crashed /crashes")
    kept = [json.loads(line) for line in journal_file().read_text().splitlines()]
    reasons = [e["reason"] for e in kept if e["kind"] == "alarm" and "reason" in e]
    assert reasons == ["a test", "again"]


async def test_a_stop_that_nobody_serves_is_said_before_it_is_pressed_and_at_once() -> None:
    async with console(node_makers=[partial(StandIn, "no_stop", moving=True)], wait=False) as op:
        await op.until("● online")
        assert "no STOP" in op.line(" ARCHO ")
        await op.at(seconds() + FIRST_FOUND)
        pressed = seconds()
        await op.press("ctrl+x")
        await op.until(lambda: "✗ STOP NOT SENT" in op.line(" ARCHO "))
        reason = "/emergency_stop is not offered by any node"
        assert f"STOP NOT SENT ({reason}): use the hardware stop" in op.text
        await op.until(lambda: any(e.level == "YOU" for e in op.app.view.snapshot.events))
        assert seconds() - pressed < 1.0
        (said,) = (e for e in op.app.view.snapshot.events if e.level == "YOU")
        assert said.text == f"STOP: {reason}: use the hardware stop"
        assert op.text.count(reason) == 2  # in the banner and among the events


async def test_a_goal_that_outlives_a_stop_is_cancelled_and_the_operator_is_told() -> None:
    drives_on = partial(StandIn, "drives_on", "yes", goals="drive")
    async with console_with(drives_on, "move_to_shelf", "emergency_stop") as (op, node):
        node.drives_on = True
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.at(seconds() + 0.5)
        await op.press("ctrl+x")
        await op.until("✗ STOP WAS ANSWERED, BUT shelf 12 STILL RUNS: use the hardware stop")
        await op.until(lambda: node.cancels)
        assert node.cancels[0] - node.stops[0] == pytest.approx(0.3, abs=0.3)
        node.drives_on = False
        await op.until("called back")
        await op.until("STOPPED: look for the cause   +1 alarm")
        await op.press("a")
        await op.until("✗ was: STOP WAS ANSWERED, BUT shelf 12 STILL RUNS, since ")


def alarm_names(op: Console) -> list[str]:
    return [alarm.name for alarm in op.app.view.alarms]


async def test_without_any_node_the_banner_says_where_was_looked() -> None:
    async with console(only=True, wait=False) as op:
        await op.until("NO NODES ")
        assert alarm_names(op) == ["no nodes"]
        if chosen.ENGINE == "embedded":
            await op.until("NO NODES in this process: give one by --node FILE")
        else:
            await op.until(f"NO NODES on domain {op.session.options.domain_id}")


async def test_a_node_whose_simulated_time_has_no_clock_is_named() -> None:
    async with console(node_makers=[partial(Node, "waiting")], wait=False) as op:
        await op.until(lambda: op.app.view.snapshot.parameters)
        assert (await op.session.robot.set_parameters("/waiting", {"use_sim_time": True})).ok
        await op.until("NO CLOCK for /waiting: use_sim_time is true and nobody publishes /clock")
        assert alarm_names(op) == ["no clock"]
        assert (await op.session.robot.set_parameters("/waiting", {"use_sim_time": False})).ok
        await op.until("was: NO CLOCK for /waiting")


@pytest.mark.parametrize(
    ("variables", "reach", "tries"),
    [
        ({}, "SUBNET", "start the robot, or match its ROS_DOMAIN_ID (`archo-tui look` tries 0 to"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"}, "LOCALHOST", "for a robot elsewhere set"),
        ({"ROS_LOCALHOST_ONLY": "1"}, "LOCALHOST", "for a robot elsewhere unset ROS_LOCAL"),
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
