"""A parameter gets the value that was meant, or the console says why not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.graph.parameter_values import fit
from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.graph import Parameter
from archo_tui.station.save_load import plan_load
from tests.support.quiet import ended, until
from tests.support.robot import robot

DECLARED = {
    "count": 3,
    "speed": 0.5,
    "name": "a",
    "on": False,
    "counts": [1, 2],
    "speeds": [0.5],
    "names": ["a"],
    "bits": [b"\x01", b"\xff"],
}


class Tunable(Node):
    """Has a parameter of each type."""

    def __init__(self, made: list[Tunable], **options: Any) -> None:
        super().__init__("tunable", **options)
        for name, value in DECLARED.items():
            self.declare_parameter(name, value)
        made.append(self)

    def has(self, name: str) -> Any:
        value = self.get_parameter(name).value
        return value if isinstance(value, str) or not hasattr(value, "__len__") else list(value)


async def known(it: Robot) -> None:
    await until(lambda: it.snapshot.parameter("count") is not None)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("count", 2**63 - 1),
        ("count", -(2**63)),
        ("speed", 1e300),
        ("speed", float("inf")),
        ("name", "yes"),
        ("name", "it's\n\u2028 \U0001f600"),
        ("counts", [2**63 - 1, 0]),
        ("counts", []),
        ("speeds", []),
        ("names", []),
        ("names", ["", "1"]),
        ("bits", [b"\x00", b"\x80"]),
    ],
)
async def test_a_node_gets_the_value_that_was_meant(name: str, value: Any) -> None:
    made: list[Tunable] = []
    async with robot(lambda **options: Tunable(made, **options)) as it:
        await known(it)
        outcome = await ended(it.set_parameters("/tunable", {name: value}))
        assert outcome.ok, outcome.text
        assert made[0].has(name) == value


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("count", 2**63, "count: 9223372036854775808 is not within -9223372036854775808 .. "),
        ("counts", [1, -(2**63) - 1], "counts[1]: -9223372036854775809 is not within"),
        ("name", "a\0b", 'name: "a\\0b" contains a null character'),
        ("names", ["a", "\ud800"], 'names[1]: "\\uD800" contains half of a surrogate pair'),
    ],
)
async def test_a_value_that_no_parameter_can_have_is_not_sent(
    name: str, value: Any, said: str
) -> None:
    made: list[Tunable] = []
    async with robot(lambda **options: Tunable(made, **options)) as it:
        await known(it)
        outcome = await ended(it.set_parameters("/tunable", {"on": True, name: value}))
        assert outcome.code == Code.MISUSE
        assert outcome.text.startswith(said)
        assert made[0].has(name) == DECLARED[name]
        assert made[0].has("on") is False


def test_a_number_in_a_file_that_is_too_large_is_a_problem(here: Path) -> None:
    path = here / "p.yaml"
    path.write_text("node:\n  ros__parameters:\n    count: 9223372036854775808\n")
    found = plan_load(path, [Parameter("/node", "count", "integer", 1, 1)])
    assert found.changes == ()
    assert found.problems == (
        # rcl reads what has no room in an int64 as a double
        "p.yaml:3: node count: needs a value of type integer, not 9.223372036854776e+18 (double)",
    )


@pytest.mark.pure
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_is_no_number_is_outside_of_every_range(value: float) -> None:
    limited = Parameter("/node", "speed", "double", 1.0, 1.0, low=0.0, high=2.0)
    with pytest.raises(ValueError, match=r"allowed 0 .. 2, not"):
        fit(limited, value)
