"""archo-tui: an interactive terminal console for the warehouse robot ARCHO."""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from archo_tui.remote.api import Robot

__version__ = "0.1.0"

if sys.version_info < (3, 10):  # noqa: UP036  # pip sees to it, but nobody asks pip to run a .pyz
    found = ".".join(map(str, sys.version_info[:2]))
    sys.stderr.write("archo-tui: needs Python 3.10 or newer, this is " + found + "\n")
    sys.exit(2)


def connect(to: str = "") -> Robot:
    """The robot of the console that runs here; `to` chooses by process number or namespace.

    Raises archo_tui.remote.api.Unreached when none runs, or several.
    """
    from archo_tui.remote.api import Robot

    return Robot(to)
