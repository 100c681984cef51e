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
    """Take over `--disable-stdout-logs` and `--log-level` (0: leave as it is)."""
    global _stdout_logs, _default_level
    _stdout_logs = stdout_logs
    _default_level = level or _default_level


def set_level(name: str, level: int) -> None:
    """Set the level of a logger and its children; 0 inherits again, for the root it logs all."""
    global _default_level
    if name:
        _levels[name] = level
    else:
        _default_level = level


def configured_level(name: str) -> int:
    """Return the level that was set for that name itself, 0 for none."""
    return _levels.get(name, 0) if name else _default_level


def forget_levels() -> None:
    """Make every logger inherit INFO again."""
    global _default_level
    _levels.clear()
    _default_level = _INFO


def effective_level(name: str) -> int:
    """Return the level of the nearest logger at or above the name that has one."""
    while name:
        if _levels.get(name):
            return _levels[name]
        name = name.rpartition(".")[0]
    return _default_level


def connect(name: str, publish: Publish) -> None:
    """Publish lines of that logger and its children with `publish`."""
    _rosout[name] = publish


def disconnect(name: str, publish: Publish) -> None:
    """Undo `connect`."""
    if _rosout.get(name) == publish:
        del _rosout[name]


def is_written() -> bool:
    """Return False if standard error is switched off."""
    return _stdout_logs


def write(line: str) -> None:
    """Write a line to standard error."""
    print(line, file=sys.stderr, flush=True)


def rosout(name: str) -> Publish | None:
    """Return the function that publishes a logger's lines on /rosout, or None without a node."""
    while name:
        if name in _rosout:
            return _rosout[name]
        name = name.rpartition(".")[0]
    return None
