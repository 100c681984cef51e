"""The output of log lines: standard error in ROS's format, and the /rosout of their node."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

Publish = Callable[[Any], None]

_stdout_logs = True
_default_level = _INFO = 20  # The root's level, which all loggers without one inherit.
_levels: dict[str, int] = {}
_rosout: dict[str, Publish] = {}


def configure(stdout_logs: bool, level: int) -> None:
    """Set whether log lines are written to standard error, and the level of the root logger."""
    global _stdout_logs, _default_level
    _stdout_logs = stdout_logs
    _default_level = level or _default_level


def set_level(name: str, level: int) -> None:
    """Set the level of a logger and of its children that have none of their own."""
    global _default_level
    if name:
        _levels[name] = level
    else:
        _default_level = level


def configured_level(name: str) -> int:
    """Return the level that was set for that logger itself, 0 if it inherits one.

    The root, "", always has a level of its own.
    """
    return _levels.get(name, 0) if name else _default_level


def forget_levels() -> None:
    """Reset the root's level to INFO, and let every other logger inherit it."""
    global _default_level
    _levels.clear()
    _default_level = _INFO


def effective_level(name: str) -> int:
    """Return the level in force for a logger: its own, or the nearest parent's, or the root's."""
    while name:
        if _levels.get(name):
            return _levels[name]
        name = name.rpartition(".")[0]
    return _default_level


def connect(name: str, publish: Publish) -> None:
    """Publish the lines of a logger and of its children with `publish` from now on.

    A function that was connected to the same name before is replaced.
    """
    _rosout[name] = publish


def disconnect(name: str, publish: Publish) -> None:
    """Undo `connect`, unless another function has been connected to the name since."""
    if _rosout.get(name) == publish:
        del _rosout[name]


def is_written() -> bool:
    """Return True if log lines are written to standard error."""
    return _stdout_logs


def write(line: str) -> None:
    """Write a line to standard error, unbuffered."""
    print(line, file=sys.stderr, flush=True)


def rosout(name: str) -> Publish | None:
    """Return the function that publishes a logger's lines on /rosout.

    The nearest parent's counts if the logger has none itself. None means that no node has connected
    one.
    """
    while name:
        if name in _rosout:
            return _rosout[name]
        name = name.rpartition(".")[0]
    return None
