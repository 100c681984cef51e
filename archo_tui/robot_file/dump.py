"""Writer of robot files: only what differs from the defaults, in the model's order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

from archo_tui.robot_file.model import RobotFile
from archo_tui.yaml_text import dump as yaml_dump

_HEAD = "# Written by archo-tui. What the words mean: docs/own_robot.md.\n"


def dump(robot: RobotFile) -> str:
    """Return YAML text from which `load` makes an equal robot."""
    return _HEAD + yaml_dump.block({"version": robot.version, **_plain(robot)})


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
