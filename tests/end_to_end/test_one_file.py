"""The .pyz: one file, run by Pythons that have nothing else."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.end_to_end.conftest import Tmux

ROOT = Path(__file__).parent.parent.parent
BARE = Path(sys.base_prefix) / "bin" / "python3"  # outside of the environment of the tests


@pytest.fixture(scope="module")
def pyz(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("elsewhere")
    subprocess.run([ROOT / ".ci" / "pyz", folder / "made.pyz"], check=True)
    return (folder / "made.pyz").rename(folder / "console of mine.pyz")


@pytest.fixture(autouse=True)
def _unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHIV_ROOT", str(tmp_path / "unpacked"))


def test_it_is_small_and_has_nothing_that_is_compiled(pyz: Path) -> None:
    assert pyz.stat().st_size < 6_000_000
    kinds = {Path(name).suffix for name in ZipFile(pyz).namelist()}
    assert kinds.isdisjoint({".so", ".pyd", ".dylib", ".pyc"})


def test_every_python_runs_it_that_is_new_enough(pyz: Path) -> None:
    others = (shutil.which(f"python3.{minor}") for minor in range(10, 15))
    for python in {str(BARE), *filter(None, others)}:
        if subprocess.run([python, "-c", ""], check=False, capture_output=True).returncode:
            continue  # a shim of pyenv for a version that is not chosen
        command = [python, str(pyz), "--plain", "--ros-args", "-p", "time_scale:=75.0"]
        done = subprocess.run(command, input="go 12\n", capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, ""), python
        assert "Arrived at shelf 12" in done.stdout


def test_it_begins_again_after_an_interface_was_saved(
    pyz: Path, tmp_path: Path, tmux: Tmux
) -> None:
    package = tmp_path / "src" / "mine"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>mine</name></package>")
    (package / "msg" / "Said.msg").write_text("int32 first\n")
    node = tmp_path / "teller.py"
    node.write_text(
        "from mine.msg import Said\nfrom rclpy.node import Node\n\n"
        "class Teller(Node):\n    def __init__(self):\n        super().__init__('teller')\n"
        "        name = [*Said.get_fields_and_field_types()][0]\n"
        "        self.get_logger().warning(f'{name} is it')\n"
    )
    words = f"{shlex.quote(str(pyz))} --interfaces src --node teller.py"
    tmux.start(f"cd {tmp_path}; env SHIV_ROOT={os.environ['SHIV_ROOT']} {BARE} {words}")
    tmux.until("first is it")
    (package / "msg" / "Said.msg").write_text("int32 second\n")
    tmux.until("second is it")
    tmux.type("C-q")
    tmux.until("ENDED 0")
