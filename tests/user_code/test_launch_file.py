"""A launch file of the user's own, whose programs run without ROS: `archo-tui launch FILE`."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from archo_tui.cli import main
from archo_tui.robot.state.snapshot import Life
from archo_tui.session.options import Launch
from archo_tui.session.session import Session
from archo_tui.user_code import program as hosted_program
from tests.support import chosen
from tests.support.waiting import wait_until
from tests.user_code.support import is_told, life, release, running, states, stop, texts

pytestmark = [
    pytest.mark.real_time,
    pytest.mark.skipif(chosen.ENGINE != "embedded", reason="there ros2 launch does it"),
]

WHEELS = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64


class Wheels(Node):
    def __init__(self):
        super().__init__("wheels")
        self.declare_parameter("speed", 0.0)
        self.publisher = self.create_publisher(Float64, "speed", 10)
        self.create_timer(0.05, self.tick)

    def tick(self):
        self.publisher.publish(Float64(data=self.get_parameter("speed").value))


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(Wheels())


def once():
    rclpy.init()
    rclpy.create_node("once")
    with open("runs.txt", "a") as file:
        print("ran", file=file)
"""
SETUP = """
from glob import glob
from setuptools import find_packages, setup

setup(
    name="my_wheels",
    packages=find_packages(),
    data_files=[("share/my_wheels/config", glob("config/*.yaml"))],
    entry_points={
        "console_scripts": ["wheels = my_wheels.wheels:main", "once = my_wheels.wheels:once"],
    },
)
"""
PACKAGE = """
<package>
  <name>my_wheels</name>
  <export><build_type>ament_python</build_type></export>
</package>
"""
LAUNCH = """
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def wheels(**options):
    return Node(package="my_wheels", executable="wheels", **options)


def generate_launch_description():
    values = os.path.join(get_package_share_directory("my_wheels"), "config", "wheels.yaml")
    return LaunchDescription([
        DeclareLaunchArgument("side", default_value="left"),
        LogInfo(msg=["wheels on the ", LaunchConfiguration("side")]),
        {actions}
    ])
"""
TWO = """
        SetEnvironmentVariable("WHEELS", "4"),
        ExecuteProcess(cmd=["rviz2"]),
        wheels(namespace=LaunchConfiguration("side"), parameters=[values]),
        wheels(name="spare", parameters=[{"speed": 2.5}], remappings=[("speed", "spare_speed")]),
"""


@pytest.fixture
def workspace(here: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A workspace with a package of nodes."""
    monkeypatch.setattr("sys.path", [*sys.path])
    names = ("my_wheels", "my_wheels.wheels", "my_wheels.bridge")
    for name in names:  # Of another test's workspace.
        sys.modules.pop(name, None)
    robot = Path("ws/src/my_wheels")
    for name in ("my_wheels", "launch", "config"):
        (robot / name).mkdir(parents=True)
    (robot / "package.xml").write_text(PACKAGE)
    (robot / "setup.py").write_text(SETUP)
    (robot / "my_wheels/__init__.py").touch()
    (robot / "my_wheels/wheels.py").write_text(WHEELS)
    (robot / "config/wheels.yaml").write_text("/**:\n  ros__parameters:\n    speed: 1.5\n")
    yield Path("ws")
    for name in names:
        sys.modules.pop(name, None)


def launch_file(actions: str) -> Path:
    file = Path("ws/src/my_wheels/launch/robot.launch.py")
    file.write_text(LAUNCH.replace("{actions}", actions))
    return file


def launched(file: Path, **options: Any) -> AbstractContextManager[Session]:
    return running(**{"launch": Launch(file, {}), **options})


def test_a_launch_file_runs_its_programs_each_as_it_says(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WHEELS", "2")
    file = launch_file(TWO)
    given = {"launch": Launch(file, {"side": "right"})}
    with launched(file, **given) as session:
        wait_until(lambda: set(states(session)) == {"/right/wheels", "/spare"})
        topics = {t for t in session.context._graph.topics if "speed" in t}
        assert topics == {"/right/speed", "/spare_speed"}
        nodes = {n.get_fully_qualified_name(): n for n in session.context._graph.nodes}
        assert nodes["/right/wheels"].get_parameter("speed").value == 1.5
        assert nodes["/spare"].get_parameter("speed").value == 2.5
        assert os.environ["WHEELS"] == "4"
        said = [f"{file}:18: wheels on the right"]
        said += [f"{file}:21: ExecuteProcess does not run here"]
        wait_until(lambda: all(is_told(session, text) for text in said))
        # One of them ends, and the other goes on.
        assert session.host.stop_node("/spare").ok
        assert states(session)["/right/wheels"].life is Life.UP


STEPS = """
import rclpy
from rclpy.node import Node
from my_steps.size import SIZE
from std_msgs.msg import Int32

if __name__ == "__main__":
    rclpy.init()
    node = Node("steps")
    publisher = node.create_publisher(Int32, "steps", 10)
    node.create_timer(0.05, lambda: publisher.publish(Int32(data=SIZE)))
    rclpy.spin(node)
"""
CMAKE = """
project(my_steps)
ament_python_install_package(${PROJECT_NAME})
install(PROGRAMS scripts/steps.py DESTINATION lib/${PROJECT_NAME})
"""


def test_the_script_of_an_ament_cmake_package_runs_with_the_modules_of_its_package(
    workspace: Path,
) -> None:
    package = workspace / "src" / "my_steps"
    for name in ("my_steps", "scripts", "launch"):
        (package / name).mkdir(parents=True)
    text = PACKAGE.replace("my_wheels", "my_steps").replace("ament_python", "ament_cmake")
    (package / "package.xml").write_text(text)
    (package / "CMakeLists.txt").write_text(CMAKE)
    (package / "my_steps/size.py").write_text("SIZE = 7")
    (package / "scripts/steps.py").write_text(STEPS)
    file = package / "launch/steps.launch.xml"
    file.write_text(
        '<launch><node pkg="my_steps" exec="steps.py" name="climb" namespace="tower"/></launch>'
    )
    with launched(file) as session:
        wait_until(lambda: "/tower/steps" in session.context._graph.topics)
        wait_until(lambda: states(session)["/tower/climb"].life is Life.UP)


def test_what_is_respawned_is_not_behind_a_stop(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hosted_program, "LEAST_RESPAWN_DELAY", 0.2)
    once = 'Node(package="my_wheels", executable="once", respawn=True),'
    runs = Path("runs.txt")
    with launched(launch_file(once), only=False) as session:
        wait_until(lambda: runs.exists() and runs.read_text().count("ran") >= 3)
        stop(session)
        wait_until(lambda: session.host._early_stop_request()[0])
        count = runs.read_text().count("ran")
        asyncio.run(asyncio.sleep(0.6))
        assert runs.read_text().count("ran") <= count + 1  # It may have begun just before.
        count = runs.read_text().count("ran")
        wait_until(lambda: states(session)["/once"].life is Life.WAITING)
        release(session)
        asyncio.run(asyncio.sleep(0.6))
        assert runs.read_text().count("ran") == count  # Never by the release itself.
        assert session.host.start_node("/once").ok
        wait_until(lambda: runs.read_text().count("ran") > count)


EXITS = """
import sys


def main():
    print("no serial port")
    sys.exit(1)
"""
BRIDGE = 'Node(package="my_wheels", executable="once", name="bridge"),'


def bridge(text: str) -> None:
    """Let the executable `once` be that text."""
    setup = Path("ws/src/my_wheels/setup.py")
    setup.write_text(setup.read_text().replace("wheels:once", "bridge:main"))
    (setup.parent / "my_wheels/bridge.py").write_text(text)


@pytest.mark.parametrize(
    ("text", "error"), [(EXITS, "exit code 1"), ("def", "line 1: SyntaxError")]
)
def test_of_programs_that_exit_at_once_or_are_not_python_the_others_run_on(
    workspace: Path, text: str, error: str
) -> None:
    bridge(text)
    with launched(launch_file(BRIDGE + "wheels(),")) as session:
        wait_until(lambda: life(session, "/wheels") is Life.UP)
        assert life(session, "/bridge") is Life.CRASHED
        assert states(session)["/bridge"].error.startswith(error)
        wait_until(lambda: is_told(session, f"crashed: {error}"))
        wait_until(lambda: "no serial port" in texts(session) or text != EXITS)


def test_a_launch_file_whose_programs_all_exit_says_what_they_said(
    workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bridge(EXITS)
    file = launch_file(BRIDGE)
    assert main(["launch", str(file), "--plain", "--no-remote"]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines[1:] == [
        "archo-tui: bridge stdout: no serial port",
        "archo-tui: bridge: crashed: exit code 1",
        f"archo-tui: nothing of {file} runs here",
    ]


def test_a_saved_launch_file_restarts_the_console_unless_it_is_wrong(workspace: Path) -> None:
    file = launch_file(TWO)
    restarts: list[str] = []
    with launched(file) as session:
        watched = session._launch_file
        assert watched is not None
        reload = partial(watched.reload, session.robot.note, restarts.append)
        session._watch.watched = [(watched, reload)]
        launch_file("1 / 0,")
        wrong = f"the saved text does not run: {file}:19: ZeroDivisionError"
        wait_until(lambda: is_told(session, wrong))
        assert restarts == []
        Path("ws/src/my_wheels/config/wheels.yaml").write_text("/**: {ros__parameters: {speed: 2}}")
        launch_file(TWO)
        wait_until(lambda: restarts)
        assert restarts[0] == "robot.launch.py, or a file that it reads, was saved"


def test_a_workspace_in_the_place_of_a_node_file_is_hosted(workspace: Path) -> None:
    with running(workspace) as session:
        wait_until(lambda: "/wheels" in states(session))
        assert "/speed" in session.context._graph.topics


READS = """
import rclpy
from ament_index_python.packages import PackageNotFoundError, get_package_share_directory


def main():
    rclpy.init()
    node = rclpy.create_node("reader")
    with open(get_package_share_directory("my_wheels") + "/config/wheels.yaml") as file:
        print(file.read().split()[-1])
    try:
        get_package_share_directory("my_robt")
    except PackageNotFoundError as error:
        print(error)
    rclpy.spin(node)
"""


def test_a_node_finds_the_files_of_its_package_as_it_runs(workspace: Path) -> None:
    (workspace / "src/my_wheels/my_wheels/wheels.py").write_text(READS)
    with launched(launch_file("wheels()")) as session:
        wait_until(lambda: "1.5" in texts(session))
        wait_until(lambda: any("my_robt' not found" in text for text in texts(session)))
    assert "ament_index_python" not in sys.modules


def test_the_arguments_of_a_launch_file_are_printed(
    workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    launch_file(
        """
        DeclareLaunchArgument("robot", description="which one"),
        DeclareLaunchArgument("mode", default_value="slow", choices=["slow", "fast"]),
    """
    )
    assert main(["launch", "ws", "--show-args"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "side:=  (default: left)",
        "robot:=  which one  (no default)",
        "mode:=  (default: slow, one of slow fast)",
    ]


@pytest.mark.pure
@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["none.launch.py"], "none.launch.py: there is no such launch file"),
        (["ws/src/my_wheels/setup.py", "right"], "right: an argument of a launch file is written"),
        (["ws"], "ws: no package of it has launch/*.launch.py"),
        (["."], "several launch files, name one: a/launch/x.launch.py a/launch/y.launch.py"),
        (["--engine", "ros2", "x.launch.py"], "on ROS 2, ros2 launch x.launch.py does it"),
    ],
)
def test_a_launch_that_is_typed_wrong_is_one_line(
    words: list[str], error: str, workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if words == ["."]:
        package = Path("a")
        (package / "launch").mkdir(parents=True)
        (package / "package.xml").write_text(PACKAGE.replace("my_wheels", "a"))
        for name in "xy":
            (package / f"launch/{name}.launch.py").touch()
    assert main(["launch", *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert error in line
