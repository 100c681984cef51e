"""`archo-tui chapter`: the files that a reader begins with."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from archo_tui.cli import main

pytestmark = pytest.mark.posix


def test_the_files_run_and_only_the_exercise_is_left_to_the_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["chapter", "my robot"]) == 0
    *written, _, _, _, hint = capsys.readouterr().out.splitlines()
    assert hint == "On ROS 2:     cd 'my robot' && colcon build"
    assert sorted(written) == sorted(
        str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()
    )
    checked = subprocess.run(
        [sys.executable, "-m", "archo_tui", "check", "my robot"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    failed = [line for line in checked.stdout.splitlines() if line.startswith("not ok")]
    assert failed == ["not ok 8 - a cancel at 9 m ends the move as CANCELED"], checked
    launch = "my robot/src/archo_comms/launch/archo_comms.launch.py"
    assert main(["check", launch]) == 0


def test_every_node_is_an_executable_of_the_package(tmp_path: Path) -> None:
    assert main(["chapter", str(tmp_path)]) == 0
    package = tmp_path / "src/archo_comms"
    setup = ast.parse((package / "setup.py").read_text(encoding="utf-8"))
    texts = {node.value for node in ast.walk(setup) if isinstance(node, ast.Constant)}
    nodes = {path.stem for path in (package / "archo_comms").glob("[!_]*.py")}
    assert {f"{node} = archo_comms.{node}:main" for node in nodes} <= texts
    launch = (package / "launch/archo_comms.launch.py").read_text(encoding="utf-8")
    assert all(f'executable="{node}"' in launch for node in nodes)


def test_an_installed_console_writes_the_same_files_as_a_clone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = Path(__file__).parent.parent
    project = (root / "pyproject.toml").read_text(encoding="utf-8")
    listed = project.partition("[tool.hatch.build.targets.wheel.force-include]\n")[2]
    for source, place in re.findall('^"(.+)" = "(.+)"$', listed.partition("\n\n")[0], re.MULTILINE):
        target = tmp_path / "installed" / place
        target.parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (root / source).is_dir() else shutil.copyfile
        copy(root / source, target)
    assert main(["chapter", str(tmp_path / "clone")]) == 0
    monkeypatch.setattr("archo_tui.cli.subcommands._PACKAGE", tmp_path / "installed/archo_tui")
    assert main(["chapter", str(tmp_path / "wheel")]) == 0
    clone, wheel = (
        {path.relative_to(folder) for path in folder.rglob("*")}
        for folder in (tmp_path / "clone", tmp_path / "wheel")
    )
    assert wheel == clone


def test_no_file_is_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "src/archo_comms/archo_comms/dashboard.py"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    assert main(["chapter", str(tmp_path)]) == 2
    assert f"{mine} is there already: nothing was written" in capsys.readouterr().err
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [mine]
    assert mine.read_text() == "mine"
