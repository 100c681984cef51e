"""What the first picture can do without does not hold it up."""

from __future__ import annotations

import subprocess
import sys

_PROGRAM = """
import sys
from archo_tui import engine
engine.activate("embedded", hosting=True)
import archo_tui.app
from archo_tui.imports import OF_THE_SCREEN, import_the_rest
dialogs = (
    "archo_tui.screens.confirm",
    "archo_tui.commands.help",
    "archo_tui.commands.palette_choices",
)
print([name in sys.modules for name in dialogs])
import_the_rest(OF_THE_SCREEN)
print([name in sys.modules for name in dialogs])
"""


def test_dialogs_are_imported_behind_the_first_picture() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM], capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    assert done.stdout.splitlines() == [str([False] * 3), str([True] * 3)]
