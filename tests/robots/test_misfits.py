"""A robot file that asks of a type what it does not take: said by line, and nothing is sent."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("depot_interfaces")

from tests.robots.rover import Rover
from tests.support.console import console
from tests.support.plain import plain
from tests.support.stand_in import Made

GOAL = """version: 1
goals:
  - id: navigate
    title: Go
    action: go_to
    type: depot_interfaces/action/GoTo
    form:
      target.pose.position.x: {label: x}
      CHANGED
    fixed: {FIXED}
"""
X, TURN, FRAME = "target.pose.position.x", "target.pose.orientation", "target.frame_id"
MISFITS = [
    (f"{FRAME}: {{label: y, low: 1}}", "", 9, f"{FRAME} is string: low and high are for numbers"),
    (f"{FRAME}: {{label: y, high: 1}}", "", 9, "low and high are for numbers"),
    (f"{X[:-1]}y: {{convert: yaw}}", "", 9, "is double: convert: yaw is for a quaternion"),
    (f"{TURN}: {{label: y}}", "", 9, "is depot_interfaces/Quaternion: name one of its fields"),
    (f"{X[:-1]}y: {{}}", f"{X[:-1]}z: far", 3, "fixed: target.pose.position.z: "),
    (f"{X[:-1]}y: {{}}", f"{X[:-2]}: {{z: 1}}, {X[:-1]}z: 1", 3, "z is given twice, also by "),
    (f"{X[:-1]}y: {{}}", f"{TURN}: 3", 3, "fixed: target.pose.orientation: 3 is not the fields of"),
]


def misfit(folder: Path, changed: str, fixed: str) -> Path:
    file = folder / "robot.yaml"
    file.write_text(GOAL.replace("CHANGED", changed).replace("FIXED", fixed))
    return file


@pytest.mark.parametrize(("changed", "fixed", "line", "said"), MISFITS)
async def test_a_form_that_does_not_fit_is_said_and_nothing_is_sent(
    here: Path, changed: str, fixed: str, line: int, said: str
) -> None:
    file = misfit(here, changed, fixed)
    made = Made(Rover)
    code, out = await plain("go x=1 y=2\ngo x=1 y=[2]\nstatus\n", made, robot=file)
    assert code == 1
    warned = [text for text in out.splitlines() if "WARN console: " in text]
    assert [text for text in warned if f"{file}:{line}: " in text and said in text], out
    assert made.node.heard == []
    assert "Traceback" not in out


async def test_the_screen_names_a_range_on_a_text_and_lives(here: Path) -> None:
    file = misfit(here, *MISFITS[0][:2])
    async with console(robot=file, node_makers=[Rover], wait=False) as op:
        await op.until(f"{file}:9: {FRAME} is string: low and high are for numbers")
        await op.press("g", "1", "enter", *"map", "enter")
        await op.settle()
        assert "low and high are for numbers" in op.text
        assert op.app.view.snapshot.goal is None
