"""Where POSIX is not: the console and `--plain` without its modules, signals and functions."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import chosen
from tests.support.night import corners

pytestmark = pytest.mark.real_time

BARE = """
import asyncio, os, signal, sys
import archo_tui.ros.embedded  # nothing of ours that asks the system for anything
import textual.app, textual.pilot
for name in ("fcntl", "termios", "tty", "pty", "resource", "pwd", "grp"):
    sys.modules[name] = None  # its import fails
for name in ("SIGHUP", "SIGQUIT", "SIGTSTP", "SIGCONT", "SIGUSR1", "SIGUSR2"):
    if hasattr(signal, name):
        delattr(signal, name)
for name in ("getuid", "fchown", "fchmod", "pread", "O_NOFOLLOW", "setsid", "fork", "mkfifo"):
    if hasattr(os, name):
        delattr(os, name)

def refuse(*_):
    raise NotImplementedError

asyncio.BaseEventLoop.add_signal_handler = refuse
"""
FAST = ["--ros-args", "-p", "feedback_period:=0.05", "-p", "time_scale:=75.0"]
CONSOLE = f"""
from archo_tui.screen.app import ArchoApp
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from archo_tui.station.shutdown import heed_signals
from archo_tui.screen.terminal.stderr import guarded_streams, log_file

async def until(pilot, holds):
    for _ in range(3000):
        await pilot.pause(0.02)
        if holds():
            return
    raise AssertionError(holds)

async def drive(station):
    app = ArchoApp(station)
    async with app.run_test(size=(120, 36)) as pilot:
        snapshot = lambda: app.view.snapshot
        await until(pilot, lambda: len(snapshot().offered) == 7)
        await pilot.press("g", "1", "2", "enter")
        await until(pilot, lambda: snapshot().history)
        await pilot.press("ctrl+z")  # says that it cannot
        await pilot.press("escape", "4", "ctrl+s", "enter")
        await until(pilot, lambda: os.path.exists("archo_params.yaml"))
        print(snapshot().history[0].message)

heed_signals()
with Session(Options(ros_args={FAST[1:]!r})) as session, guarded_streams(log_file()):
    asyncio.run(drive(session.station))
"""
PLAIN = f"""
from archo_tui.cli import main
sys.exit(main(["--plain", *{FAST!r}]))
"""


def run(program: str, folder: Path, said: str = "") -> str:
    root = Path(__file__).parent.parent
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(root), str(root / "nodes")]),
        "USERNAME": "reader",
        "TEXTUAL_DRIVER": "textual.drivers.headless_driver:HeadlessDriver",
        "PYTHONWARNINGS": "error",
    }
    done = subprocess.run(
        [sys.executable, "-c", BARE + program],
        input=said,
        capture_output=True,
        text=True,
        cwd=folder,
        env=environment,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="the embedded engine is what is there")
@pytest.mark.parametrize(
    ("program", "said"),
    corners([(PLAIN, "go 12\nquit\n")], [(CONSOLE, "")]),
    ids=["plain", "console"],
)
def test_a_goal_is_driven_to_its_end_without_posix(program: str, said: str, tmp_path: Path) -> None:
    assert "Arrived at shelf 12" in run(program, tmp_path, said)
