"""An operator over tmux and SSH, links and terminals that misbehave; one file for any Python."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest

from archo_tui.base.paths import journal_file
from tests.end_to_end.conftest import COMMAND, Sshd, Tmux
from tests.support.waiting import wait_until

ARCHO = shlex.join(COMMAND)
SLOW = "--ros-args -p feedback_period:=0.1 -p time_scale:=1.0"
CHATTY = "--ros-args -p publish_period:=0.02"


def journaled() -> list[dict[str, Any]]:
    file = journal_file()
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def said() -> list[str]:
    return [entry["text"] for entry in journaled()]


def running(words: str) -> list[int]:
    """Processes of archo-tui with these words on their command line."""
    found = subprocess.run(
        ["ps", "-ww", "-eo", "pid,args"], capture_output=True, text=True, check=True
    )
    lines = [line.split(maxsplit=1) for line in found.stdout.splitlines()]
    return [int(pid) for pid, args in lines if args.startswith(f"{' '.join(COMMAND)} {words}")]


def test_a_goal_in_tmux_with_the_terminal_as_before(tmux: Tmux, tmp_path: Path) -> None:
    check = "stty -a | cmp - before && echo SANE"
    tmux.start(f"cd {tmp_path}; stty -a > before; {ARCHO}; echo CODE $?; {check}")
    tmux.until("max_speed")
    tmux.type("g", "1", "2", "Enter")
    tmux.until("Arrived at shelf 12")
    tmux.type("C-q")
    tmux.until("CODE 0")
    tmux.until("SANE")


def test_operating_over_ssh_says_who_it_was(tmux: Tmux, sshd: Sshd) -> None:
    tmux.start(sshd.command(ARCHO))
    tmux.until("max_speed")
    tmux.type("r")
    tmux.until("reset encoder: Encoder reset to zero")
    tmux.type("C-x")
    tmux.until("STOPPED (R releases)")
    tmux.type("q")
    tmux.until("ENDED 0")
    entry = next(e for e in journaled() if e["text"] == "reset encoder: Encoder reset to zero")
    assert entry["from"] == "127.0.0.1"


@pytest.mark.parametrize("words", [SLOW, CHATTY])
def test_a_killed_link_ends_the_process_and_cancels_the_goal(
    tmux: Tmux, sshd: Sshd, words: str
) -> None:
    words = f"{words} -p route_length:=500.0"
    tmux.start(sshd.command(f"{ARCHO} {words}"))
    tmux.until("max_speed")
    tmux.type("g", "1", "2", "Enter")
    tmux.until("m left of")
    assert running(words)
    for pid in sshd.connections():
        os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not running(words), "the end of the process", 3.0 + 2.0)
    assert "ended by SIGHUP: cancelling the goal to shelf 12" in said()
    assert "cancel: accepted" in said()


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
