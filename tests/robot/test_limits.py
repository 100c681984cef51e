"""A limit that a node holds as a parameter: what is said when nobody reports it."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.limits import Limits
from archo_tui.robot.state import Parameter, linked_number
from archo_tui.robot_file.model import FormField, ParameterRef
from tests.support.archo import ARCHO
from tests.support.console import console
from tests.support.plain import plain

MOTOR = "/motor_controller"
OFFERED = {"move_to_shelf"}
SPEED = Parameter(MOTOR, "max_speed", "double", 0.8, 0.8)


def shelves(value: Any) -> Parameter:
    return Parameter(MOTOR, "shelf_count", "integer", value, value)


def said(
    limits: Limits, now: float, *parameters: Parameter, nodes: Any = (MOTOR,)
) -> list[tuple[str, str]]:
    return list(limits.unknown_limits(now, OFFERED, "/", nodes, parameters))


@pytest.mark.parametrize(
    ("nodes", "parameters", "why"),
    [
        ((), (), "no node motor_controller is on the graph"),
        ((MOTOR,), (), "motor_controller does not report its parameters"),
        ((MOTOR,), (SPEED,), "motor_controller has no parameter shelf_count"),
        ((MOTOR,), (shelves("many"),), "shelf_count of motor_controller is many, not a number"),
        ((MOTOR,), (shelves(True),), "shelf_count of motor_controller is true, not a number"),
        ((MOTOR,), (shelves(None),), "shelf_count of motor_controller is --, not a number"),
        ((MOTOR,), (shelves(float("nan")),), "shelf_count of motor_controller is nan, not a"),
    ],
)
def test_why_a_limit_is_not_known_is_said_once_with_file_and_line(
    nodes: Any, parameters: Any, why: str
) -> None:
    limits = Limits(ARCHO)
    assert said(limits, 10.0, *parameters, nodes=nodes) == []
    ((level, line),) = said(limits, 15.0, *parameters, nodes=nodes)
    assert level == ("WARN" if "not a" in why else "INFO")
    assert line.startswith(f"Shelf has no upper limit yet: {why}")
    assert re.search(r" \(archo\.yaml:\d+\)$", line)
    assert said(limits, 20.0, *parameters, nodes=nodes) == []


def test_it_is_said_again_when_it_was_known_meanwhile() -> None:
    limits = Limits(ARCHO)
    said(limits, 0.0)
    assert said(limits, 5.0)
    assert said(limits, 6.0, shelves(40)) == []
    assert said(limits, 7.0) == []
    assert said(limits, 12.0)


def test_of_a_goal_that_nobody_serves_nothing_is_said() -> None:
    limits = Limits(ARCHO)
    for now in (0.0, 10.0):
        assert list(limits.unknown_limits(now, (), "/", (), ())) == []


def test_a_node_that_is_named_from_the_root_is_not_of_the_namespace() -> None:
    fleet = Parameter("/fleet", "racks", "integer", 40, 40)
    ours = fleet._replace(node="/tb1/fleet", value=7)
    assert linked_number([fleet, ours], "/tb1", ParameterRef("fleet", "racks")) == 7
    assert linked_number([fleet, ours], "/tb1", ParameterRef("/fleet", "racks")) == 40
    shelf = ARCHO.goals[0]
    form = {"shelf_number": FormField("Shelf", high=ParameterRef("/fleet", "racks"))}
    limits = Limits(replace(ARCHO, goals=(replace(shelf, form=form),)))
    for now in (0.0, 10.0):
        told = list(limits.unknown_limits(now, OFFERED, "/tb1", (), ()))
    assert [line for _, line in told] == [
        "Shelf has no upper limit yet: fleet is no node of the namespace /tb1 ()"
    ]


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


async def test_the_operator_sees_it_and_the_robot_alone_decides() -> None:
    async with console(node_makers=[Strange], wait=False) as op:
        await op.until("Shelf has no upper limit yet: shelf_count of motor_controller is many, not")
        await op.press("g", *"4711", "enter")
        await op.until("ARRIVED")


async def test_a_line_that_is_typed_at_once_is_held_to_the_limit_too() -> None:
    code, heard = await plain("go 41\n")
    assert code == 1
    assert "failed: go: Shelf: at most 40, not 41" in heard
    assert "Goal refused" not in heard
