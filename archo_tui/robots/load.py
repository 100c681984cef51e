"""Reads robot files: every error names file and line, and the nearest word that would do."""

from __future__ import annotations

from pathlib import Path

from archo_tui.embedded import bounded_yaml
from archo_tui.errors import ArchoError
from archo_tui.robots import faults, typed_yaml
from archo_tui.robots.model import Robot

_ROOM = Path(__file__).parent.parent
_LONGEST = 500  # characters of what is said


def default() -> Path:
    """ARCHO's own file: `config/` of the checkout, or the copy inside an installed wheel."""
    paths = [folder / "config" / "robots" / "archo.yaml" for folder in (_ROOM.parent, _ROOM)]
    return next((path for path in paths if path.is_file()), paths[0])


def load(path: Path) -> Robot:
    """The robot that a file describes. Raises ArchoError with one line that says what is wrong."""
    try:
        return _load(path)
    except OSError as error:
        said = f"{path}: cannot read the robot file: {error.strerror}"
    except (bounded_yaml.YamlError, ArchoError) as error:
        said = str(error)
    # the file's own words are in it
    shown = "".join(char if char.isprintable() else "\N{REPLACEMENT CHARACTER}" for char in said)
    raise ArchoError(shown[:_LONGEST])


def _load(path: Path) -> Robot:
    node = bounded_yaml.compose(bounded_yaml.read(path), path)
    if node is None:
        raise ArchoError(f"{path}:1: no robot is described here")
    robot: Robot = typed_yaml.read(Robot, node, path)
    for where, said in faults.of(robot):
        raise ArchoError(f"{where}: {said}")
    return robot
