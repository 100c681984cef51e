"""What the first picture can do without does not hold it up."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

_PROGRAM = """
import sys
from archo_tui.ros import engine
engine.activate("embedded", hosting=True)
import archo_tui.screen.app
from archo_tui.base.imports import OF_THE_SCREEN, import_the_rest
replay = "archo_tui.screen.commands.replay", "archo_tui.recordings.replay.player"
print([name in sys.modules for name in replay])
import_the_rest(OF_THE_SCREEN)
print([name in sys.modules for name in replay])
"""

_WITH_INTERFACES = """
import sys
from pathlib import Path
import archo_tui.session.session
from archo_tui.user_code import interfaces
print("archo_tui.user_code.ros_launch.workspace" in sys.modules)
interfaces.find([Path("interfaces")], "embedded")
print("archo_tui.user_code.ros_launch.setup_script" in sys.modules)
"""


def test_what_runs_a_setup_is_not_imported_to_read_interfaces() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _WITH_INTERFACES],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parent.parent,
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["False", "False"]


def test_a_replay_is_imported_behind_the_first_picture() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM], capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    assert done.stdout.splitlines() == [str([False] * 2), str([True] * 2)]
