"""A robot as the text of its file: what differs from the defaults, in the model's order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

from archo_tui.robot_file import written
from archo_tui.robot_file.model import RobotFile

_HEAD = "# Written by archo-tui. What the words mean: docs/own_robot.md.\n"


def dump(robot: RobotFile) -> str:
    """The text that `load` reads back as the same robot."""
    return _HEAD + written.block({"version": robot.version, **_plain(robot)})


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        found = {}
        for item in fields(value):
            given = getattr(value, item.name)
            default = item.default
            if item.default_factory is not MISSING:
                default = item.default_factory()
            if item.name != "where" and given != default:
                found[item.name] = _plain(given)
        return next(iter(found.values())) if list(found) == ["field"] else found
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
