"""Launch files that are written by a test and evaluated beside the packages of tests/share."""

from __future__ import annotations

import json
import os
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

from archo_tui.user_code.ros_launch import child_process, evaluation
from archo_tui.user_code.ros_launch.evaluate import evaluate, parse_arguments
from archo_tui.user_code.ros_launch.plan import LaunchedProgram, LaunchPlan
from archo_tui.user_code.ros_launch.workspace import Workspace

WORKSPACE = Path(__file__).parent.parent / "share" / "workspace"
_IMPORTS = """\
import launch_ros, os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import *
from launch.event_handlers import OnProcessExit
from launch.launch_description_sources import *
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.parameter_descriptions import *
from launch_ros.substitutions import FindPackageShare

def described(*actions):
    return LaunchDescription(actions)

def n(name, **options):
    return Node(package='my_robot', executable='talker', name=name, **options)
"""


_setups: dict[tuple[Any, int], tuple[Any, str]] = {}  # What each setup.py says, as it was saved.


@contextmanager
def in_this_process() -> Iterator[None]:
    """Evaluate launch files here, each setup.py once: a process takes a tenth of a second."""

    def ask(module: str, request: Any, seconds: float) -> tuple[Any, str]:
        if module != evaluation.__name__:
            key = request, Path(request).stat().st_mtime_ns
            _setups[key] = _setups.get(key) or asked(module, request, seconds)
            return _setups[key]
        answer = evaluation.evaluate(json.loads(json.dumps(request)))
        return json.loads(json.dumps(answer)), ""

    asked = child_process.ask
    with patch.object(child_process, "ask", ask):
        yield


class Launcher:
    """What launches the files of a test."""

    def __init__(self, folder: Path, workspace: Workspace, prefix: Path) -> None:
        self.folder, self.prefix = folder, prefix
        self.file = folder / "test.launch.py"
        self._workspace = workspace

    def write(self, text: str, name: str = "test.launch.py") -> Path:
        """Write a launch file, and return its path."""
        path = self.folder / name
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return path

    def plan(self, path: Path, *arguments: str) -> LaunchPlan:
        """Evaluate a launch file in this process."""
        with in_this_process():
            return evaluate(str(path), self._workspace, self.prefix, parse_arguments(arguments))

    def of_actions(self, text: str, *arguments: str, before: str = "") -> LaunchPlan:
        """Evaluate a launch file that describes some actions, with what stands before them."""
        return self.plan(self.describing(text, before), *arguments)

    def describing(self, text: str, before: str = "") -> Path:
        """Write such a launch file, and return its path."""
        actions = textwrap.indent(textwrap.dedent(text).strip(), "        ")
        generate = f"def generate_launch_description():\n    return described(\n{actions}\n    )\n"
        return self.write(f"{_IMPORTS}{before}\n{generate}")

    def commands(self, plan: LaunchPlan) -> list[str]:
        """Return the plan's programs as `ros2 run` would be given them."""
        found = [command(program).replace(str(self.prefix), "PREFIX") for program in plan.programs]
        return [text.replace(os.sep, "/") for text in found]


def command(program: LaunchedProgram) -> str:
    """Return a program as `ros2 run` would be given it."""
    ros_args = ("--ros-args", *program.ros_args) if program.ros_args else ()
    return " ".join([program.package, program.executable, *program.arguments, *ros_args])
