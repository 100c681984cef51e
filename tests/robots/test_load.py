"""Robot files: every mistake is one line with file and line."""
# ruff: noqa: E501

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

from archo_tui.base.errors import ArchoError
from archo_tui.console.plain import help_text
from archo_tui.robot.messages.values import read
from archo_tui.robot_file.load import default_path, dump, load
from archo_tui.robot_file.model import MessageField, ParameterRef, RobotFile
from archo_tui.screen.commands import registry
from archo_tui.verbs import verbs

pytestmark = pytest.mark.pure

HERE = Path(__file__).parent
FILES = [*default_path().parent.glob("*.yaml"), *HERE.glob("*.yaml")]
ONE_GOAL = "goals:\n  - id: a\n    title: t\n    action: a\n    type: a/action/B\n"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_files_that_come_with_it_are_read(path: Path) -> None:
    assert load(path).name.upper() in path.read_text().upper()


def test_the_file_of_the_page_is_a_whole_one(tmp_path: Path) -> None:
    page = (HERE.parent.parent / "docs" / "own_robot.md").read_text(encoding="utf-8")
    file = tmp_path / "mine.yaml"
    file.write_text(page.partition("```yaml\n")[2].partition("```")[0])
    robot = load(file)
    assert (robot.name, robot.commands[0].key, robot.goals[0].noun) == ("My robot", "b", "shelf")


def test_what_is_written_is_read_back_the_same(tmp_path: Path) -> None:
    for path in FILES:
        file = tmp_path / path.name
        file.write_text(dump(load(path)))
        assert load(file) == load(path)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("", 1, "the file is empty: it describes no robot"),
        ("name: x\nbatery: none\n", 2, "unknown key batery (nearest: battery)"),
        ("version: 2\n", 1, "2 is not one of 1"),
        ("- a\n", 1, "expected lines like 'name: value'"),
        ("name: [a]\n", 1, "name: expected a text"),
        ("name: a\nname: b\n", 2, "name is given twice"),
        ("battery:\n  types: {}\n", 2, "topic is missing"),
        ("battery:\n  topic: a b\n  types: {}\n", 2, "'a b' is not a name of a topic"),
        ("battery:\n  topic: a\n  period: soon\n  types: {}\n", 3, "period: expected a number, not soon"),
        ("battery:\n  topic: a\n  period: .nan\n  types: {}\n", 3, "expected a number, not .nan"),
        ("battery:\n  topic: a\n  types:\n    b/c: {percentage: p}\n", 4, "'b/c' is not a type"),
        ("battery:\n  topic: a\n  types:\n    a/msg/B:\n      voltage: v\n", 5, "percentage is missing"),
        (f"battery:\n  topic: a\n  period: {'9' * 5000}\n  types: {{}}\n", 3, "a number of 5000 digits"),
        ("battery:\n  topic: a\n  period: !!int x\n  types: {}\n", 3, "not of the kind !!int: x"),
        (ONE_GOAL + "    fixed:\n      a:\n        b: 1\n        b: 2\n", 9, "b is given twice"),
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
        ("goals:\n  - {id: A, title: t, action: a, type: a/action/B}\n", 2, "'A' is not a valid id"),
        ("goals:\n  - {id: a, title: t, action: a, type: a/msg/B}\n", 2, "is not a type: expected package/action/Name"),
        (
            "commands:\n  - {id: a, title: t, service: s}\n  - {id: a, title: t, service: s}\n",
            3,
            "duplicate id a",
        ),
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


BATTERY = "battery:\n  topic: a\n  types: {a/msg/B: {percentage: {field: p, CHANGED}}}\n"
LOW = "battery:\n  topic: a\n  low: CHANGED\n  types: {a/msg/B: {percentage: p}}\n"
GOAL = "goals:\n- {id: a, title: t, action: a, type: a/action/B}\n- {id: b, title: t, action: a, type: a/action/B,\n   CHANGED}\n"
MOVING = "motion:\n  topic: a\n  types: {a/msg/B: {moving: CHANGED}}\n"
STOP = "stop: {service: halt, CHANGED}\n"
COMMAND = "commands:\n  - {id: a, title: t, service: s, CHANGED}\n"
TOGGLE = "commands:\n- {id: a, title: t, service: s}\n- {title: t, service: s, toggle: {on: motion.moving}, CHANGED}\n"
GAUGE = "gauges:\n  - {title: t, topic: a, type: a/msg/B, field: f, CHANGED}\n"


@pytest.mark.parametrize(
    ("text", "changed", "line", "said"),
    [
        (GOAL, "form: {x: {low: 5, high: 1}}", 4, "low 5 is above high 1: swap them"),
        (GOAL, "form: {x: {high: {node: n, paramter: p}}}", 4, "unknown key paramter (nearest: parameter)"),
        (GOAL, "form: {x: {low: 5, high: {node: n, parameter: p, otherwise: 1}}}", 4, "low 5 is above high 1"),
        (GAUGE, "warn_below: 60, warn_above: 20", 2, "warn_below 60 is above warn_above 20: swap them"),
        (GAUGE + GAUGE.partition("\n")[2], "unit: m", 3, "duplicate title t"),
        (GOAL, "form: {x: {label: X}, y: {label: X}}", 4, "duplicate label x"),
        (GOAL, "form: {x: {}, x.z: {}}", 4, "x.z is a part of x: give one of them"),
        (GOAL, "form: {x: {}}, fixed: {x: 1}", 4, "x is both in the form and fixed: give one of them"),
        ("goals:\n- {id: a, title: CHANGED, action: a, type: a/action/B}\n", "null", 2, "title: expected a text, not null"),
        ("name: CHANGED\n", '"\\uD800"', 1, "contains half of a surrogate pair"),
        (BATTERY, "scale: !!int x", 3, "scale: expected a number: not of the kind !!int: x"),
        (BATTERY, "scale: !!python/object:os.system x", 3, "scale: expected a number: !!python/object:os.system is not read here"),
        (BATTERY, 'scale: "\\UFFFFFFFF"', 3, "not YAML: "),
        (BATTERY, 'scale: "\\x1b[2J"', 3, "scale: expected a number, not \N{REPLACEMENT CHARACTER}[2J"),
        (BATTERY, "scale: 0", 3, "scale is 0: every reading would be the same"),
        (BATTERY, "equals: 1, beyond: 2", 3, "equals and beyond exclude each other"),
        (BATTERY, "beyond: -1", 3, "beyond is -1: it must not be negative"),
        (LOW, "{node: n, parameter: p, otherwise: 500}", 3, "low is 500: a charge is within 0 .. 100"),
        (LOW, "none\n  period: 0", 4, "period is 0: a time in s, above 0"),
        (GOAL, "remaining: {field: f, length: {node: n, parameter: p, otherwise: 0}}", 4, "a length is above 0"),
        (MOVING, "[]", 3, "moving is empty"),
        (MOVING, "[x, {beyond: 1}]", 3, "field is missing"),
        (STOP, "release: halt", 1, "release is the service that stops, halt: give it a release_request of its own"),
        (STOP, "release_request: {on: false}", 1, "release_request is for a release: name its service"),
        (STOP, "request: {on: [true]}", 1, "on: expected a single value"),
        (COMMAND, "toggle: {}", 2, "toggle is empty: expected lines like 'name: value'"),
        (COMMAND, "off: b", 2, "off is for a toggle: a has none"),
        ("battery: {topic: a, types: {}}\n", "", 1, "types is empty: name the type of the topic"),
        (TOGGLE, "id: b, off: stop", 3, "the word stop is the console's own: choose another"),
        (TOGGLE, "id: b, off: a", 3, "duplicate word a: choose another"),
        (TOGGLE, "id: b, off: plug out", 3, "'plug out' is not a valid word: small letters, digits and _"),
        (TOGGLE.replace("id: a", "id: b_off"), "id: b", 3, "duplicate word b_off"),
        (TOGGLE, "id: check", 3, "the id check is the console's own: choose another"),
        ("stop: {service: ''}\n", "", 1, "'' is not a name of a topic"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused_with_its_line(
    tmp_path: Path, text: str, changed: str, line: int, said: str
) -> None:
    test_a_mistake_names_its_line(tmp_path, text.replace("CHANGED", changed), line, said)


def test_a_file_that_is_not_utf_8_or_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ArchoError, match="cannot read the robot file: No such file"):
        load(tmp_path / "none.yaml")
    file = tmp_path / "robot.yaml"
    file.write_bytes(b"version: 1\nname: Caf\xe9\n")
    with pytest.raises(ArchoError) as caught:
        load(file)
    assert str(caught.value) == f"{file}:2: not UTF-8: save it as that"


LINK, LINKED = "{node: n, parameter: p, otherwise: 9}", ParameterRef("n", "p", 9.0)
FORM = ONE_GOAL + "    form: {x: {low: 1, high: CHANGED}}\n"
LEFT = ONE_GOAL + "    remaining: {field: f, length: CHANGED}\n"
FIXED = ONE_GOAL + "    form: {x.z: {}}\n    fixed: CHANGED\n"
EQUALS = "battery:\n  topic: a\n  types: {a/msg/B: {percentage: {field: p, equals: CHANGED}}}\n"
X, Y = MessageField("x"), MessageField("y", beyond=0.1)


def moving(robot: Any) -> Any:
    return robot.motion.types["a/msg/B"].moving


def equals(robot: Any) -> Any:
    return robot.battery.types["a/msg/B"].percentage.equals


def length(robot: Any) -> Any:
    return robot.goals[0].remaining.length


@pytest.mark.parametrize(
    ("text", "changed", "read_as", "meant"),
    [
        *(
            (LOW, text, lambda robot: robot.battery.low, meant)
            for text, meant in (("20", 20.0), (LINK, LINKED))
        ),
        *((LEFT, text, length, meant) for text, meant in (("20", 20.0), (LINK, LINKED))),
        (FORM, LINK, lambda robot: robot.goals[0].form["x"].high, LINKED),
        (FORM, "9", lambda robot: robot.goals[0].form["x"].high, 9.0),
        (MOVING, "x", moving, X),
        (MOVING, "{field: x}", moving, X),
        (MOVING, "[x, {field: y, beyond: 0.1}]", moving, (X, Y)),
        (EQUALS, '"none"', equals, "none"),
        (EQUALS, "'null'", equals, "null"),
        (EQUALS, "''", equals, ""),
        (EQUALS, "none", equals, None),
        *(
            (
                f"name: {none}\nstop: {{service: halt, release: CHANGED}}\n",
                none,
                lambda robot: (robot.name, robot.stop.release),
                ("robot", ""),
            )
            for none in ("", "none", "null", "~")
        ),
        ("name: bare\nstop: none\n", "", lambda robot: robot, RobotFile(name="bare")),
        (FIXED, "{x: {y: 1}}", lambda robot: robot.goals[0].fixed, {"x": {"y": 1}}),
        (
            FIXED,
            "{a: 010, b: 1:30, c: [yes, 1e3], d: {on: 0x10}, e: '1'}",
            lambda robot: robot.goals[0].fixed,
            {"a": 10, "b": "1:30", "c": ["yes", 1000.0], "d": {"on": 16}, "e": "1"},
        ),
    ],
)
def test_what_is_typed_is_read_as_it_is_meant_and_written_so(
    text: str, changed: str, read_as: Any, meant: Any, tmp_path: Path
) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(text.replace("CHANGED", changed))
    robot = load(file)
    assert read_as(robot) == meant
    file.write_text(dump(robot))
    assert load(file) == robot


@pytest.mark.parametrize(
    ("values", "moving"),
    [((0.0, 0.0), False), ((0.5, 0.0), True), ((0.0, -0.5), True), ((math.nan, 0.5), True)],
)
def test_of_several_readings_one_is_enough_to_move(
    values: tuple[float, float], moving: bool
) -> None:
    fields = tuple(MessageField(name, beyond=0.1) for name in ("x", "y"))
    assert read(fields, SimpleNamespace(x=values[0], y=values[1])) is moving
    assert read(fields, SimpleNamespace(x=0.0, y=math.nan)) is None


# what a value, or a piece of a line, is replaced by
ODD = (
    *("none", "~", '"none"', "''", "yes", "word", "a b", "stop", "quit", "é", "'\\xe9'"),
    *("-1", "0", "1e999", ".nan", "-.inf", "1:30", "0x1F", "010", "9" * 5000, "2020-99-99"),
    *("[]", "{}", "[a, [b]]", "{a: 1}", "{a: 1, a: 2}", "[[[[", "{{{{", "- a\n  - b"),
    *("!!int x", '!!int ""', "!!bool q", "!!float z", "!!null x", "!!timestamp bad"),
    *("!!binary x", "!!set {a}", "!!omap [a: 1]", "!!pairs [a]", "!!map x", "!!seq x"),
    *("!!python/object:os.system x", "&a [*a]", "{<<: {a: 1}}", "{? [a] : b}", "|", ">"),
    *("%YAML 9.9", f"%YAML {'9' * 5000}.1", "---", "...", "# x", "\\xff", "\t", "\r"),
    *('"\\x1b[2J\\n"', '"\\uD800"', '"\\UFFFFFFFF"', "\x1b", "\0", "\x85", "\u2028", "\u202e"),
)


def mutated(files: list[Path], number: int, seed: int) -> Iterator[bytes]:
    """So many texts made from these files."""
    chance = random.Random(seed)
    known = []
    for file in files:
        text = file.read_text(encoding="utf-8")
        known.append((text, sorted(_places(yaml.compose(text, Loader=yaml.SafeLoader)))))
    for _ in range(number):
        text, places = chance.choice(known)
        last = len(text)
        for start, end in reversed(chance.sample(places, chance.choice((0, 1, 1, 1, 2, 3)))):
            if end <= last:  # not in what was replaced already
                text, last = text[:start] + chance.choice(ODD) + text[end:], start
        data = text.encode()
        yield data if chance.random() < 0.7 else chance.choice((_line, _bytes))(data, chance)


def _places(node: Any) -> Iterator[tuple[int, int]]:
    """Where names and values stand."""
    yield node.start_mark.index, node.end_mark.index
    if isinstance(node, yaml.ScalarNode):
        return
    for item in node.value:
        for part in item if isinstance(item, tuple) else (item,):
            yield from _places(part)


def _line(data: bytes, chance: random.Random) -> bytes:
    """A line less, or twice."""
    lines = data.split(b"\n")
    place = chance.randrange(len(lines))
    lines[place : place + 1] = chance.choice(([], [lines[place]] * 2))
    return b"\n".join(lines)


def _bytes(data: bytes, chance: random.Random) -> bytes:
    """A few bytes less, or another one."""
    place = chance.randrange(len(data) + 1)
    new = chance.choice((b"", bytes([chance.randrange(256)])))
    return data[:place] + new + data[place + chance.randrange(12) :]


def test_whatever_is_changed_in_a_file_it_loads_or_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    refusals = []
    for data in mutated(FILES, 300, seed=24):
        file.write_bytes(data)
        try:
            robot = load(file)
        except ArchoError as error:
            refusals.append(str(error))
        else:
            assert help_text(verbs(robot, {}))
            assert registry(robot)
    assert 0 < len(refusals) < 300
    for said in refusals:
        assert said.isprintable(), said
        assert re.match(rf"{re.escape(str(file))}:\d+: .", said), said
