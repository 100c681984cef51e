"""Writer of robot files: only what differs from the defaults, in the model's order."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Any

from archo_tui.robot_file.model import RobotFile
from archo_tui.yaml_text import dump as yaml_dump

_HEAD = "# Written by archo-tui. What the words mean: docs/own_robot.md.\n"


def dump(robot: RobotFile) -> str:
    """Return YAML text from which `load` makes an equal robot; defaults are left out of it."""
    return _HEAD + yaml_dump.block({"version": robot.version, **plain(robot)})


def without(robot: RobotFile, names: Collection[str]) -> RobotFile:
    """Return a copy of a robot file without the parts that need something which is not there.

    Parts are left out for their topic, their action, or the service that they call; `record` and
    the STOP's release stay. A copy that lacks a part gets the name of a robot without a name.
    """
    battery, motion, pose, stop = robot.battery, robot.motion, robot.pose, robot.stop
    kept = replace(
        robot,
        battery=None if battery is None or battery.topic in names else battery,
        motion=None if motion is None or motion.topic in names else motion,
        pose=None if pose is None or pose.topic in names else pose,
        goals=tuple(kind for kind in robot.goals if kind.action not in names),
        stop=None if stop is None or stop.service in names else stop,
        commands=tuple(command for command in robot.commands if command.service not in names),
        gauges=tuple(gauge for gauge in robot.gauges if gauge.topic not in names),
        diagnostics="" if robot.diagnostics in names else robot.diagnostics,
    )
    return kept if kept == robot else replace(kept, name=RobotFile.name)


def plain(value: Any) -> Any:
    """Return a dataclass of a robot file as mappings and lists, without defaults and `where`.

    A dataclass of which only `field` is set becomes the value of `field`.
    """
    if is_dataclass(value):
        found = {}
        for item in fields(value):
            given = getattr(value, item.name)
            default = item.default
            if item.default_factory is not MISSING:
                default = item.default_factory()
            if item.name != "where" and given != default:
                found[item.name] = plain(given)
        return next(iter(found.values())) if list(found) == ["field"] else found
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, tuple) else value
