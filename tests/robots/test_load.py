"""Robot files: every mistake is one line with file and line."""
# ruff: noqa: E501

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from archo_tui.errors import ArchoError
from archo_tui.robots.load import default, load
from archo_tui.robots.model import Robot
from archo_tui.robots.save import dump

HERE = Path(__file__).parent
GOAL = "goals:\n  - id: a\n    title: t\n    action: a\n    type: a/action/B\n"


@pytest.mark.parametrize(
    "path",
    [default(), default().with_name("turtlebot4.yaml"), HERE / "tug.yaml", HERE / "rover.yaml"],
)
def test_the_files_that_come_with_it_are_read(path: Path) -> None:
    assert load(path).name.upper() in path.read_text().upper()


def test_the_readmes_file_is_a_whole_one(tmp_path: Path) -> None:
    readme = (HERE.parent.parent / "README.md").read_text(encoding="utf-8")
    section = readme.partition("## Your own robot\n")[2].partition("\n## ")[0]
    file = tmp_path / "mine.yaml"
    file.write_text(dedent(section[section.index("    version: 1") :]))
    robot = load(file)
    assert (robot.name, robot.commands[0].key, robot.goals[0].noun) == ("My robot", "b", "shelf")
    assert len(section.strip().splitlines()) <= 20


def test_what_is_written_is_read_back_the_same(tmp_path: Path) -> None:
    for path in (default(), HERE / "tug.yaml", HERE / "rover.yaml"):
        file = tmp_path / path.name
        file.write_text(dump(load(path)))
        assert load(file) == load(path)


def test_what_a_file_leaves_out_the_robot_does_not_have(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text("name: bare\nstop: none\n")
    assert load(file) == Robot(name="bare")


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("", 1, "no robot is described here"),
        ("name: x\nbatery: none\n", 2, "unknown key batery (nearest: battery)"),
        ("name: x\nxyz: 1\n", 2, "unknown key xyz: one of version, name, battery, motion"),
        ("version: 2\n", 1, "2 is not one of 1"),
        ("- a\n", 1, "expected lines like 'name: value'"),
        ("name: [a]\n", 1, "name: expected a text"),
        ("name: a\nname: b\n", 2, "name is given twice"),
        ("battery:\n  types: {}\n", 2, "topic is missing"),
        ("battery:\n  topic: a b\n  types: {}\n", 2, "'a b' is no name of a topic"),
        ("battery:\n  topic: a\n  period: soon\n  types: {}\n", 3, "period: expected a number, not soon"),
        ("battery:\n  topic: a\n  period: .nan\n  types: {}\n", 3, "expected a number, not .nan"),
        ("battery:\n  topic: a\n  types:\n    b/c: {percentage: p}\n", 2, "'b/c' is no type"),
        ("battery:\n  topic: a\n  types:\n    a/msg/B:\n      voltage: v\n", 5, "percentage is missing"),
        ("battery:\n  topic: a\n  period: 1:30\n  types: {}\n", 3, "period: expected a number, not 1:30"),
        ("battery:\n  topic: a\n  period: 1_0\n  types: {}\n", 3, "period: expected a number, not 1_0"),
        ("battery:\n  topic: a\n  period: 1e999\n  types: {}\n", 3, "too large for a number: 1e999"),
        (f"battery:\n  topic: a\n  period: {'9' * 5000}\n  types: {{}}\n", 3, "a number of 5000 digits"),
        ("battery:\n  topic: a\n  period: !!int x\n  types: {}\n", 3, "not of the kind !!int: x"),
        (GOAL + "    fixed: {a: 1, a: 2}\n", 6, "a is given twice"),
        (GOAL + "    fixed:\n      a:\n        b: 1\n        b: 2\n", 9, "b is given twice"),
        (GOAL + "    fixed: {a: !!timestamp x}\n", 6, "!!timestamp is not read here"),
        (
            "battery:\n  topic: a\n  types:\n    a/msg/B:\n      percentage: {field: p, scael: 100}\n",
            5,
            "unknown key scael (nearest: scale)",
        ),
        (
            "battery:\n  topic: a\n  types: {}\n  health:\n    ok: god\n",
            5,
            "god is not one of good, low, replace (nearest: good)",
        ),
        ("goals: {id: a}\n", 1, "expected a list"),
        ("goals:\n  - {id: A, title: t, action: a, type: a/action/B}\n", 2, "'A' is no id"),
        ("goals:\n  - {id: a, title: t, action: a, type: a/msg/B}\n", 2, "is no type: expected package/action/Name"),
        (
            "commands:\n  - {id: a, title: t, service: s}\n  - {id: a, title: t, service: s}\n",
            3,
            "the id a is that of another one",
        ),
        ("commands:\n  - {id: a, title: t, service: s, ask: nver}\n", 2, "(nearest: never)"),
        ("commands:\n  - {id: a, title: t, service: s, toggle: {on: moon}}\n", 2, "not moon"),
        ("stop: {service: s, relese: r}\n", 1, "unknown key relese (nearest: release)"),
        ("a: b: c\n", 1, "not YAML"),
    ],
)  # fmt: skip
def test_a_mistake_names_its_line(tmp_path: Path, text: str, line: int, said: str) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(text)
    with pytest.raises(ArchoError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}:{line}: "), caught.value
    assert said in str(caught.value)


def test_values_of_a_file_are_read_as_what_is_typed(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(GOAL + "    fixed: {a: 010, b: 1:30, c: [yes, 1e3], d: {on: 0x10}, e: '1'}\n")
    expected = {"a": 10, "b": "1:30", "c": ["yes", 1000.0], "d": {"on": 16}, "e": "1"}
    assert load(file).goals[0].fixed == expected
    file.write_text(dump(load(file)))
    assert load(file).goals[0].fixed == expected


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ArchoError, match="cannot read the robot file: No such file"):
        load(tmp_path / "none.yaml")
