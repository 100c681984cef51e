"""The command line with which the console starts itself again."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from archo_tui.cli.options import split_ros_args

_added: list[str] = []  # Options that take the place of those that were typed.


def use_namespace(namespace: str) -> None:
    """Set the namespace that `command_line` adds when the console starts itself again."""
    _added[:] = ["--namespace", namespace]


def command_line(given: Sequence[str]) -> list[str]:
    """Return the command line that starts the console again, in the chosen namespace."""
    own, ros_args = split_ros_args(given)
    ros = ["--ros-args", *ros_args] if ros_args else []
    return [sys.executable, *_this_program(), *own, *_added, *ros]


def _this_program() -> list[str]:
    """Return the arguments with which Python runs this program: its zip file, or `-m archo_tui`."""
    from zipfile import is_zipfile

    return [sys.argv[0]] if is_zipfile(sys.argv[0]) else ["-m", "archo_tui"]
