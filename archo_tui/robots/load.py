"""Reads robot files: every error names file and line, and the nearest word that would do."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from archo_tui.embedded import bounded_yaml
from archo_tui.errors import ArchoError
from archo_tui.robots import typed_yaml
from archo_tui.robots.model import Robot, Service

_ROOM = Path(__file__).parent.parent
_NAME = re.compile(r"[~/]?[A-Za-z_]\w*(/[A-Za-z_]\w*)*")  # as rclpy takes them
_TYPE = re.compile(r"\w+/(msg|srv|action)/\w+")
_ID = re.compile(r"[a-z][a-z0-9_]*")
_READINGS = ("battery.charging", "motion.moving", "motion.stopped")


def default() -> Path:
    """ARCHO's own file: `config/` of the checkout, or the copy inside an installed wheel."""
    paths = [folder / "config" / "robots" / "archo.yaml" for folder in (_ROOM.parent, _ROOM)]
    return next((path for path in paths if path.is_file()), paths[0])


def load(path: Path) -> Robot:
    """The robot that a file describes. Raises ArchoError with one line that says what is wrong."""
    try:
        node = bounded_yaml.compose(bounded_yaml.read(path), path)
        if node is None:
            raise ArchoError(f"{path}:1: no robot is described here")
        robot: Robot = typed_yaml.read(Robot, node, path)
    except OSError as error:
        raise ArchoError(f"{path}: cannot read the robot file: {error.strerror}") from None
    except bounded_yaml.YamlError as error:
        raise ArchoError(str(error)) from None
    for where, said in _faults(robot):
        raise ArchoError(f"{where or path}: {said}")
    return robot


def _faults(robot: Robot) -> Iterator[tuple[str, str]]:
    """What the words of a file mean and the types of its values cannot say."""
    heard = [topic for topic in (robot.battery, robot.motion) if topic is not None]
    names = [(topic.where, topic.topic) for topic in (*heard, *robot.gauges)]
    names += [(goal.where, goal.action) for goal in robot.goals]
    names += [(command.where, command.service) for command in robot.commands]
    if robot.stop is not None:
        services = (robot.stop.service, robot.stop.release)
        names += [(robot.stop.where, name) for name in services if name]
    for where, name in names:
        if not _NAME.fullmatch(name):
            yield where, f"{name!r} is no name of a topic, service or action"
    types = [(topic.where, kind, "msg") for topic in heard for kind in topic.types]
    types += [(gauge.where, gauge.type, "msg") for gauge in robot.gauges]
    types += [(goal.where, goal.type, "action") for goal in robot.goals]
    for where, kind, of in types:
        if not _TYPE.fullmatch(kind) or kind.split("/")[1] != of:
            yield where, f"{kind!r} is no type: expected package/{of}/Name"
    taken: dict[str, str] = {}
    ids = [(goal.id, goal.where) for goal in robot.goals]
    for name, where in [*ids, *((command.id, command.where) for command in robot.commands)]:
        if not _ID.fullmatch(name):
            yield where, f"{name!r} is no id: small letters, digits and _"
        if name in taken:
            yield where, f"the id {name} is that of another one"
        taken[name] = where
    for command in robot.commands:
        yield from _toggle_faults(command)


def _toggle_faults(command: Service) -> Iterator[tuple[str, str]]:
    if len(command.toggle) > 1:
        yield command.where, "toggle takes one field of the request"
    for reading in command.toggle.values():
        if reading not in _READINGS:
            yield command.where, f"toggle inverts one of {', '.join(_READINGS)}, not {reading}"
