"""A node's dialog: what it has on the graph, and what of its lines it logs."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from rclpy.node import Node
from std_msgs.msg import Float32

from archo_tui.robot.outcome import WATCHING
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.screen.commands.nodes import NodeDialog
from tests.support.console import FAST, LONG, Console, console
from tests.support.quiet import ended
from tests.widgets.test_nodes import select


async def opened(op: Console, node: str) -> None:
    """Open the dialog of a node and wait for what the graph says."""
    await select(op, node)
    await op.press("enter")
    await op.until("log level   ")


async def test_it_has_what_a_node_offers_with_types_and_leads_to_its_topics() -> None:
    async with console(*FAST) as op:
        await opened(op, "/motor_controller")
        assert "in the console's process" in op.text
        for title, name, kind in (
            ("topics published", "/motor_status", "archo_interfaces/msg/MotorStatus"),
            ("topics subscribed", "/battery_level", "archo_interfaces/msg/BatteryStatus"),
            ("services", "/emergency_stop", "archo_interfaces/srv/EmergencyStop"),
            ("services", "/release_emergency_stop", "std_srvs/srv/Trigger"),
            ("actions", "/move_to_shelf", "archo_interfaces/action/MoveToShelf"),
        ):
            below = op.text[op.text.index(title) :]
            assert re.search(rf"  {name} +{kind}", below), name
        dialog = op.text[op.text.index("/motor_controller") :]
        assert "rcl_interfaces" not in dialog
        assert "_action" not in dialog
        assert "/rosout" not in dialog

        await op.press("escape")
        await opened(op, "/motor_controller")
        await op.press("enter")
        await op.until("Topics of motor_controller")
        await op.press(*"motor_st")
        await op.press("down")  # Enter is not held.
        await op.press("enter")
        await op.until(lambda: "speed" in op.line("m/s"))
        await op.press("escape")
        await op.until("topics published")

        await op.press("escape")
        await select(op, "/battery_monitor")
        op.send(*["enter"] * 5)
        await op.until("log level   INFO")
        assert not [e for e in op.app.view.snapshot.events if e.level == "YOU"]


async def test_the_level_of_its_log_is_set_and_its_lines_follow() -> None:
    async with console(*FAST) as op:
        await opened(op, "/battery_monitor")
        await op.until("log level   INFO and above, the level of its process")
        await op.press("tab", "right", "right", "right", "right", "enter")
        await op.until("log level   ERROR and above")
        await op.press("escape")
        await op.until("log level of battery_monitor ERROR: ERROR and above, was INFO and above")
        await op.press("c")
        await op.until("✓  charge")
        await op.settle()
        sources = [event.source for event in op.app.view.snapshot.events]
        assert "battery_monitor" not in sources
        await opened(op, "/battery_monitor")
        await op.press("tab", "enter")
        await op.until("log level   INFO and above, the level of its process")
        await op.press("escape", "c")
        await op.until(
            lambda: "battery_monitor" in [event.source for event in op.app.view.snapshot.events]
        )


async def test_stop_works_in_it_and_is_final_for_a_level_set_before_it() -> None:
    async with console(*LONG) as op:
        await op.press("g", *"12", "enter")
        await op.until("MOVING to 12")
        await op.press("escape")
        await opened(op, "/motor_controller")
        await op.press("tab", "right", "ctrl+x")
        await op.until(lambda: op.app.view.snapshot.motion.stopped)
        await op.until(lambda: op.app.view.snapshot.running_goal is None)
        op.app.stops.register()  # one more, of another driver, before this is carried out
        with op.app.stops.typed_at(op.app.stops.count - 1):
            outcome = await op.app.verbs["log_level"].run(
                op.app.station, {"node": "/motor_controller", "level": "DEBUG"}
            )
        assert outcome.text == NOT_SENT


class Mute(Node):
    """Does not offer the level of its log."""

    def __init__(self, **options: Any) -> None:
        super().__init__("mute", **options)
        self.create_publisher(Float32, "noise", 1)


async def test_a_node_without_the_services_of_its_log_says_so() -> None:
    async with console(node_makers=[Mute], wait=False) as op:
        await op.until("● mute")
        await opened(op, "/mute")
        await op.until("log level   not offered by the node")
        assert "/noise  std_msgs/msg/Float32" in op.text
        assert "Debug" not in op.text


async def test_whoever_watches_sees_the_level_and_sets_none() -> None:
    async with console(*FAST, watch=True) as op:
        await opened(op, "/dashboard")
        await op.until("log level   INFO and above, the level of its process")
        await op.press("tab", "right", "enter")
        await op.until(WATCHING)
        await op.until("log level   INFO and above, the level of its process")


async def test_a_node_that_has_left_or_is_stopped_meanwhile_is_up_no_more() -> None:
    async with console(*FAST) as op:
        await opened(op, "/dashboard")
        snapshot = op.app.view.snapshot
        nodes = tuple(node for node in snapshot.nodes if node.name != "/dashboard")
        view = replace(op.app.view, snapshot=snapshot._replace(nodes=nodes), hosted=())
        assert isinstance(op.app.screen, NodeDialog)
        op.app.screen.show_view(view)
        await op.settle()
        assert "? not on the graph any more" in op.text

        await op.press("escape")
        await opened(op, "/dashboard")
        assert "● up" in op.text
        halted = op.app.verbs["halt"].run(op.app.station, {"node": "/dashboard"})
        assert (await ended(halted)).ok  # as from a shell, beside the dialog
        await op.until("○ stopped by you")
        assert "● up" not in op.text

        await op.press("escape", "5", "s")
        await op.until("● dashboard")
        await select(op, "/dashboard")
        await op.press("s")
        await op.until("stopped by you")
        await op.press("enter")
        await op.until("not on the graph")
        assert "log level" not in op.text
