"""Parameter files: what they mean, for whom they are, what is saved, loaded and undone."""

from __future__ import annotations

import asyncio
import json
import os
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.base.yaml_text.bounded_yaml import YamlError
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import Parameter
from archo_tui.ros.embedded.parameter_files import matches, read
from archo_tui.station import parameter_files, save_load
from archo_tui.station.undo import LIMIT, UndoList
from tests.parameters import hostile
from tests.support.console import console
from tests.support.plain import operated
from tests.support.states import PARAMETERS

TEXT = """\
motor_controler:
  ros__parameters:
    max_speed: 0.5
motor_controller:
  ros__parameters:
    max_sped: 0.5
/**:
  ros__parameters:
    anything: 1
"""
DECLARED = {"/motor_controller": {"max_speed", "wheel_radius"}, "/dashboard": set[str]()}


def test_unknown_names_are_said_with_the_nearest(tmp_path: Path) -> None:
    file = tmp_path / "shared.yaml"
    file.write_text(TEXT)
    assert parameter_files.unknown_lines(read(file), DECLARED) == [
        f"{file}:3: no node /motor_controler here (nearest: /motor_controller)",
        f"{file}:6: /motor_controller has no parameter max_sped (nearest: max_speed)",
    ]


def test_what_is_typed_for_every_node_is_known_to_one_at_least() -> None:
    words = ["-r", "a:=b", "-p", "max_sped:=1", "-p", "max_speed:=1"]
    words += ["--param", "motor_controller:max_sped:=2"]
    assert parameter_files.unknown_lines(parameter_files.parse_typed(words), DECLARED) == [
        "-p max_sped:=1: no node has a parameter max_sped (nearest: max_speed)",
        "-p motor_controller:max_sped:=2: /motor_controller has no parameter max_sped "
        "(nearest: max_speed)",
    ]


def test_a_file_of_a_whole_stack_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "nav2.yaml"
    names = ("amcl", "bt_navigator", "controller_server", "map_server", "planner_server")
    parameters = "".join(f"    p{number}: 1\n" for number in range(80))
    file.write_text("".join(f"{name}:\n  ros__parameters:\n{parameters}" for name in names))
    assert parameter_files.unknown_lines(read(file), {"/motor_controller": {"max_speed"}}) == [
        f"{file}: 5 of its nodes are not here: /amcl, /bt_navigator, /controller_server ..."
    ]


async def test_unknown_names_are_events_on_the_screen_and_a_later_file_wins(here: Path) -> None:
    unknown, first, second = here / "shared.yaml", here / "1.yaml", here / "2.yaml"
    unknown.write_text(TEXT)
    for file, speed in ((first, 0.3), (second, 1.7)):
        file.write_text(f"motor_controller:\n  ros__parameters:\n    max_speed: {speed}\n")
    async with console("-p", "max_sped:=1", params_files=[unknown, first, second]) as op:
        await op.until("no node /motor_controler here (nearest: /motor_controller)")
        await op.until("has no parameter max_sped (nearest: max_speed)")
        await op.until("-p max_sped:=1: no node has a parameter max_sped (nearest: max_speed)")
        await op.until("1.7    double")


MOTOR = """
import rclpy
from rclpy.node import Node


class Motor(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 1.5)
        self.declare_parameter("wheel_radius", 7)  # An integer, unlike ARCHO's own.
        self.get_logger().warning(f"speed {self.get_parameter('max_speed').value}")


def main():
    rclpy.init()
    rclpy.spin(Motor())


if __name__ == "__main__":
    main()
"""


@pytest.fixture(autouse=True)
def _discovers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # Programs are processes.


@pytest.fixture
def motor(here: Path) -> Path:
    file = here / "motor.py"
    file.write_text(MOTOR)
    return file


async def test_a_node_in_archos_place_has_its_own_values_which_is_said(
    motor: Path,
) -> None:
    async with operated(node_files=[motor], only=True) as person:
        await person.until("WARN motor_controller: speed 1.5")
        assert "motor_params.yaml" not in person.said
    async with operated(node_files=[motor]) as person:
        await person.enter("get motor_controller wheel_radius", "wheel_radius is 7")
        await person.until(
            "INFO motor_controller: max_speed, wheel_radius: the default of motor.py; "
            "motor_params.yaml is for ARCHO's own node, --params-file gives it to yours"
        )


async def test_a_file_that_is_named_is_for_every_node(motor: Path, here: Path) -> None:
    motor.write_text(MOTOR.replace('"wheel_radius", 7', '"wheel_radius", 0.07'))
    (named,) = (
        path for path in parameter_files.default_files() if path.name == "motor_params.yaml"
    )
    async with operated(node_files=[motor], params_files=[named]) as person:
        await person.until("WARN motor_controller: speed 0.8")
        assert "the default of motor.py" not in person.said


FAKED = "12:00:00 goal ABORTED"
SIGN = f"""
from rclpy.node import Node

class Sign(Node):
    def __init__(self):
        super().__init__("sign")
        text = "first\\n{FAKED}\\x1b[31m"
        self.declare_parameter("text", text)
        self.declare_parameter("texts", ["a", text])
        self.declare_parameter("name\\n{FAKED}", 1)
        self.create_timer(0.5, lambda: self.get_logger().warning(text))
"""


async def test_a_newline_in_a_value_or_a_log_line_begins_no_line(here: Path) -> None:
    file = here / "sign.py"
    file.write_text(SIGN)
    loads = here / "other.yaml"
    loads.write_text('sign:\n  ros__parameters:\n    text: "second\\n12:00:00 goal ABORTED"\n')
    async with operated(node_files=[file], only=True) as person:
        await person.until("WARN sign: first")
        person.type("params\nget sign text\nget sign texts\nload other.yaml\nno\nget sign text\n")
        await person.until("would be second")
        await person.enter("load other.yaml --yes\nget sign text", "sign text is second")
        lines = person.said.splitlines()
        assert sum(FAKED in line for line in lines) >= 7
        assert [line for line in lines if line.startswith(FAKED)] == []
        assert "\x1b[31m" not in person.said
    async with console(node_files=[file], only=True, wait=False) as op:
        await op.until("text")
        await op.until("first")
        lines = [line.strip(" │┃") for line in op.text.splitlines()]
        assert [line for line in lines if line.startswith(FAKED)] == []


async def test_a_long_list_is_cut_with_its_length(here: Path) -> None:
    file = here / "long.py"
    file.write_text(SIGN.replace('"name\\n12:00:00 goal ABORTED", 1', '"long", [7] * 70_000'))
    async with operated(node_files=[file], only=True) as person:
        await person.until("WARN sign: first")
        await person.enter("get sign long", "7, 7 ... (210000 characters), integer[]")
        assert len(person.said) < 5000


SHARE = Path(__file__).parent.parent / "share"
ANSWERS = json.loads((SHARE / "parameter_files_jazzy.json").read_text())
# The answers to the forms are those of Jazzy (rclpy 7.1), taken down once: each file was given to
# `rclpy.init` by `--params-file`, and the overrides of six nodes were read.
# What rcl reads as something else without a word, by a fault of its own, is refused here.
STRICTER = {
    *("value [[1]]", "value [[]]", "value [1, [2]]", "value [{a: 1}]", "block list of maps"),
    *("value {}", "parameter twice, other type", "scalar"),
}
# Numbers that nobody writes: too small for a double, or hexadecimal and no integer of 64 bits.
OTHER = {"value 1e-400", "value 0x1.8p1", "value 0x1p3", "value 0xffffffffffffffff"}
NODES = ("/n", "/m", "/a/n", "/a/b/n", "/n/m", "/motor")


def kind_of(value: Any) -> str:
    if isinstance(value, list):
        return f"{type(value[0]).__name__}[]" if value else "none"
    return type(value).__name__


def meaning(file: Path) -> Any:
    """What each node gets of a file, or that it is refused."""
    try:
        overrides = read(file)
    except YamlError as error:
        return "refused" if re.match(r".*file\.yaml(:\d+)?: ", str(error)) else str(error)
    found: dict[str, Any] = {}
    for node in NODES:
        for override in overrides:
            if matches(override.pattern, node):
                value = None if override.value == [] else override.value
                kind = kind_of(override.value)
                found.setdefault(node, {})[override.name] = [kind, repr(value)]
    return found


def test_a_file_means_what_rcl_makes_of_it(tmp_path: Path) -> None:
    file, wrong = tmp_path / "file.yaml", list[str]()
    for answer in ANSWERS:
        if answer["form"] in OTHER:
            continue
        file.write_bytes(answer["text"].encode())
        is_refused = "refused" in answer or answer["form"] in STRICTER
        if meaning(file) != ("refused" if is_refused else answer["nodes"]):
            wrong.append(answer["form"])
    assert wrong == []


# Saved and loaded: the same values, whole or not at all, planned before.


def one(kind: str, value: Any, **options: Any) -> Parameter:
    return Parameter("/ns/node", "name", kind, value, value, **options)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("double", 1.0),
        ("double", 1e-12),
        ("double", 1e300),
        ("double", float("inf")),
        ("integer", -(2**63)),
        ("bool", True),
        ("string", ""),
        ("string", "yes"),
        ("string", "1.0"),
        ("string", "a: 'b' \"c\" # d \\ e"),
        ("string", "übung 棚 \U0001f916"),
        ("string", "x" * 5000),
        ("double[]", [1.0, 2.0]),
        ("string[]", ["no", "2", ""]),
        ("bool[]", [True, False]),
    ],
)
def test_what_is_saved_is_loaded_as_the_same_value(tmp_path: Path, kind: str, value: Any) -> None:
    text, left_out = save_load.dump([one(kind, value)])
    assert left_out == []
    file = tmp_path / "saved.yaml"
    save_load.write_atomically(file, text)
    (override,) = read(file)
    assert (override.pattern, override.name, override.value) == ("/ns/node", "name", value)
    assert type(override.value) is type(value)
    assert save_load.plan_load(file, [one(kind, value)]).changes == ()


def test_names_are_quoted_and_what_a_file_cannot_hold_is_said(tmp_path: Path) -> None:
    names = ["a.b", "x: y", "[z]", "#1"]  # which YAML would read otherwise
    parameters = [Parameter("/node", name, "integer", 1, 1) for name in names]
    odd = [one("byte[]", [b"x"]), Parameter("/wheels", "ids", "integer[]", [], [1, 2])]
    text, left_out = save_load.dump([*parameters, *odd])
    (tmp_path / "saved.yaml").write_text(text)
    assert [override.name for override in read(tmp_path / "saved.yaml")] == names
    empty = "/wheels ids: an empty list, which ROS reads as not set"
    assert left_out == ["/ns/node name: byte[]", empty]


def test_what_ros2_param_dump_writes_is_planned(tmp_path: Path) -> None:
    file = tmp_path / "dump.yaml"
    file.write_text(
        "/motor_controller:\n  ros__parameters:\n    max_speed: 0.7\n    use_sim_time: false\n"
        "    ticks_per_revolution: 1024\n    wheel_radius: 0.05\n"
    )
    plan = save_load.plan_load(file, PARAMETERS)
    assert [(p.name, p.value, value) for p, value in plan.changes] == [("max_speed", 0.5, 0.7)]
    assert plan.problems == ()
    assert len(plan.left_out) == 1
    assert "has no parameter use_sim_time" in plan.left_out[0]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("max_speed: 9.0", "allowed 0.05 .. 2, not 9.0"),
        ("max_speed: .nan", "allowed 0.05 .. 2, not nan"),
        ("max_speed: fast", "needs a value of type double, not fast (string)"),
        ("max_speed: true", "needs a value of type double, not true (bool)"),
        ("max_speed: [1.0]", "needs a value of type double, not [1.0] (double[])"),
        ("ticks_per_revolution: 5", "read-only; its value is 1024"),
    ],
)
def test_a_value_that_cannot_be_is_a_problem_with_its_line(
    tmp_path: Path, line: str, said: str
) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text(f"motor_controller:\n  ros__parameters:\n    wheel_radius: 0.1\n    {line}\n")
    plan = save_load.plan_load(file, PARAMETERS)
    name = line.partition(":")[0]
    assert plan.problems == (f"{file}:4: motor_controller {name}: {said}",)


@pytest.mark.parametrize("text", ["{", "just words", "\x00", "a: b"])
def test_what_is_no_parameter_file_is_one_line(tmp_path: Path, text: str) -> None:
    file = tmp_path / "no.yaml"
    file.write_text(text)
    with pytest.raises(ArchoError) as caught:
        save_load.plan_load(file, PARAMETERS)
    assert str(caught.value).startswith(f"{file}:1: ")
    assert "\n" not in str(caught.value)


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    file = tmp_path / "kept.yaml"
    file.write_text("old")
    file.chmod(0o600)
    with pytest.raises(UnicodeEncodeError):
        save_load.write_atomically(file, "new\udcff")  # fails half way
    assert file.read_text() == "old"
    save_load.write_atomically(file, "new")
    assert (file.read_text(), file.stat().st_mode & 0o777) == ("new", 0o600)
    (tmp_path / "folder").mkdir()
    with pytest.raises(ArchoError):
        save_load.write_atomically(tmp_path / "folder", "a: 1\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "kept.yaml"]


def test_of_two_lines_the_later_one_counts_and_a_whole_number_is_a_double(tmp_path: Path) -> None:
    file = tmp_path / "f.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    name: 2.0\n/ns/node:\n  ros__parameters:\n    name: 3\n"
    )
    ((_, value),) = save_load.plan_load(file, [one("double", 1.0)]).changes
    assert (value, type(value)) == (3.0, float)


def test_a_place_that_is_no_file_is_one_line(tmp_path: Path) -> None:
    for typed, said in hostile.places(tmp_path).items():
        for work in (
            lambda path: save_load.write_atomically(path, "x"),
            lambda path: save_load.plan_load(path, PARAMETERS),
        ):
            with pytest.raises(ArchoError) as caught:
                work(Path(typed))
            assert said in str(caught.value).replace("cannot read the parameter file: ", "")
            assert "\n" not in str(caught.value)
    with pytest.raises(ArchoError, match="a link to a file that does not exist"):
        save_load.write_atomically(tmp_path / "dangling", "x")
    assert not (tmp_path / "nowhere").exists()


def test_a_file_that_would_hang_or_exhaust_is_one_line(tmp_path: Path) -> None:
    for path, said in hostile.readable(tmp_path).items():
        with pytest.raises(ArchoError) as caught:
            save_load.plan_load(Path(path), PARAMETERS)
        assert str(caught.value).startswith(f"{path}{said}")


def test_a_link_stays_and_a_new_file_is_as_the_umask_leaves_it(
    tmp_path: Path,
) -> None:
    (tmp_path / "there").mkdir()
    file, link = tmp_path / "there" / "real.yaml", tmp_path / "link.yaml"
    file.write_text("old")
    file.chmod(0o640)
    link.symlink_to(file)
    save_load.write_atomically(link, "new")
    assert link.is_symlink()
    assert (file.read_text(), file.stat().st_mode & 0o777) == ("new", 0o640)
    assert [path.name for path in (tmp_path / "there").iterdir()] == ["real.yaml"]
    before = os.umask(0o027)
    try:
        save_load.write_atomically(tmp_path / "new.yaml", "x")
    finally:
        os.umask(before)
    assert (tmp_path / "new.yaml").stat().st_mode & 0o777 == 0o640


# Changes of parameters are undone one by one, and only those that happened.


class Robot:
    """Has one parameter, which it may refuse to change."""

    def __init__(self) -> None:
        self.value, self.refuses = 0, False
        self.answer: asyncio.Event | None = None
        self.has_left = False

    @property
    def snapshot(self) -> Any:
        parameters = (Parameter("/n", "p", "integer", self.value, 0),)
        return SimpleNamespace(parameters=() if self.has_left else parameters)

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        if self.answer:
            await self.answer.wait()
        if self.refuses:
            return Outcome(Code.REFUSED, "no")
        self.value = values["p"]
        return Outcome(Code.DONE, "done")


@pytest.fixture
def robot() -> Any:
    return Robot()


async def test_as_many_changes_as_are_kept_are_undone(robot: Any) -> None:
    edits = UndoList()
    for value in range(1, LIMIT + 51):
        await edits.set_parameters(robot, "/n", {"p": value})
    undone = 0
    while (await edits.undo(robot)).ok:
        undone += 1
    assert (undone, robot.value) == (LIMIT, 50)


async def test_a_change_that_was_refused_cannot_be_undone(robot: Any) -> None:
    edits = UndoList()
    robot.refuses = True
    assert not (await edits.set_parameters(robot, "/n", {"p": 1})).ok
    assert edits.last is None
    assert (await edits.undo(robot)).text == "nothing to undo"
    robot.refuses = False
    await edits.set_parameters(robot, "/n", {"p": 1})
    robot.refuses = True
    assert not (await edits.undo(robot)).ok
    robot.refuses = False  # What cannot be undone now can be undone later.
    assert (await edits.undo(robot)).ok
    assert robot.value == 0


async def test_changes_are_under_way_until_answered_and_are_undone_one_by_one(robot: Any) -> None:
    edits, answer = UndoList(), asyncio.Event()
    robot.answer = answer
    changes = [
        asyncio.create_task(edits.set_parameters(robot, "/n", {"p": value})) for value in (1, 2)
    ]
    await asyncio.sleep(0)
    assert (edits.is_changing, edits.last) == (True, None)
    answer.set()
    await asyncio.gather(*changes)
    assert not edits.is_changing
    for value in (1, 0):
        assert (await edits.undo(robot)).ok
        assert robot.value == value


async def test_of_equal_changes_the_last_one_is_undone(robot: Any) -> None:
    edits = UndoList()
    for value in (1, 0, 1):
        await edits.set_parameters(robot, "/n", {"p": value})
    for value in (0, 1, 0):
        assert edits.changed_since(robot.snapshot) == {}
        assert (await edits.undo(robot)).ok
        assert robot.value == value
    assert edits.last is None


async def test_a_change_that_is_not_the_last_one_any_more_is_not_undone(robot: Any) -> None:
    edits = UndoList()
    await edits.set_parameters(robot, "/n", {"p": 1})
    asked = edits.last
    await edits.set_parameters(robot, "/n", {"p": 2})
    refused = await edits.undo(robot, asked)
    assert refused == (Code.REFUSED, "another change is the last one now: nothing was undone")
    assert robot.value == 2
    assert (await edits.undo(robot, edits.last)).ok
    assert robot.value == 1


async def test_what_a_node_that_left_has_no_more_is_not_set(robot: Any) -> None:
    edits = UndoList()
    robot.has_left = True
    outcome = await edits.set_parameters(robot, "/n", {"p": 1})
    assert outcome == (Code.NOT_OFFERED, "/n does not report p any more")
    assert (robot.value, edits.last) == (0, None)
