"""A limit that a node holds as a parameter."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from archo_tui.robot.state.graph import Parameter, linked_number
from archo_tui.robot_file.model import ParameterRef
from tests.support.console import console
from tests.support.plain import plain


def test_a_node_that_is_named_from_the_root_is_not_of_the_namespace() -> None:
    fleet = Parameter("/fleet", "racks", "integer", 40, 40)
    ours = fleet._replace(node="/tb1/fleet", value=7)
    assert linked_number([fleet, ours], "/tb1", ParameterRef("fleet", "racks")) == 7
    assert linked_number([fleet, ours], "/tb1", ParameterRef("/fleet", "racks")) == 40


class Strange(Node):
    """ARCHO's motor under another name of its parameter, as far as this goes."""

    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", **options)
        from archo_interfaces.action import MoveToShelf
        from rclpy.action import ActionServer

        self.declare_parameter("shelf_count", "many", ignore_override=True)
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.drive)

    async def drive(self, goal: Any) -> Any:
        goal.succeed()
        from archo_interfaces.action import MoveToShelf

        return MoveToShelf.Result(success=True, final_message=f"At {goal.request.shelf_number}")


async def test_the_robot_alone_decides_where_no_number_is_reported() -> None:
    async with console(node_makers=[Strange], wait=False) as op:
        await op.until(lambda: op.app.view.snapshot.parameter("shelf_count"))
        await op.press("g", *"4711", "enter")
        await op.until("ARRIVED")


async def test_a_line_that_is_typed_at_once_is_held_to_the_limit_too() -> None:
    code, heard = await plain("go 41\n")
    assert code == 1
    assert "failed: go: Shelf: at most 40, not 41" in heard
    assert "Goal refused" not in heard
