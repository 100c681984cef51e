"""`interface TYPE`: the definition of a type, in `--plain`, from a shell, and on the screen."""

from __future__ import annotations

import json

import pytest

from tests.support.console import console
from tests.support.plain import plain
from tests.support.shells import served, typed

COMMENT = "# State of the drive, published on motor_status."


async def test_a_type_may_be_typed_with_or_without_its_package() -> None:
    names = [
        *("archo_interfaces/msg/MotorStatus", "archo_interfaces/MotorStatus", "MotorStatus"),
        *("MoveToShelf", "std_srvs/Trigger"),
    ]
    code, said = await plain("".join(f"interface {name}\n" for name in names))
    assert code == 0, said
    assert said.count(f"{COMMENT}\nint64 encoder_ticks") == 3
    assert "# Drive to a shelf.\nint32 shelf_number" in said
    assert "---\nbool success" in said


WRONG = [
    ("MotorStatu", "no type MotorStatu is on the graph (nearest: MotorStatus)"),
    (
        "archo_interfaces/msg/MotorStat",
        "no type archo_interfaces/msg/MotorStat is installed here "
        "(nearest: archo_interfaces/msg/MotorStatus)",
    ),
    (
        "std_msgs/Strin",
        "no type std_msgs/Strin is installed here (nearest: std_msgs/String)",
    ),
    (
        "archo_interface/msg/MotorStatus",
        "no package of interfaces archo_interface is installed here (nearest: archo_interfaces)",
    ),
    ("../a", "no package of interfaces .. is installed here"),
]


async def test_a_wrong_type_is_one_line_with_the_nearest() -> None:
    code, said = await plain("".join(f"interface {name}\n" for name, _ in WRONG))
    told = [line.partition(" failed: interface: ")[2] for line in said.splitlines()]
    assert (code, told) == (1, [why for _, why in WRONG])


@pytest.mark.real_time
async def test_a_shell_gets_the_text_or_an_object() -> None:
    async with served() as person:
        shown = await typed("interface", "archo_interfaces/msg/MotorStatus")
        assert (shown.code, shown.err) == (0, "")
        assert shown.out.startswith(f"{COMMENT}\n")
        result = json.loads((await typed("interface", "MotorStatus", "--json")).out)
        assert result["data"]["type"] == "archo_interfaces/msg/MotorStatus"
        assert result["data"]["definition"].startswith(f"{COMMENT}\n")
        await person.end()


async def test_t_on_a_topic_shows_the_definition_of_its_type() -> None:
    async with console() as op:
        await op.press("8")
        while not (row := op.app.main.graph.selected) or row.resource.name != "/motor_status":
            await op.press("down")
        await op.press("enter")
        await op.until("t type")
        await op.press("t")
        await op.until(COMMENT)
        await op.until("# archo_interfaces/msg/MotorStatus")
        await op.press("escape")
        await op.until("t type")
        await op.press("escape")
