"""Reads robot files: every error names file and line, and the nearest word that would do."""

from __future__ import annotations

from pathlib import Path

from archo_tui.embedded import bounded_yaml
from archo_tui.errors import ArchoError
from archo_tui.robot_file import faults, typed_yaml
from archo_tui.robot_file.model import RobotFile

_ROOM = Path(__file__).parent.parent
_LONGEST = 500  # characters of what is said


def default() -> Path:
    """ARCHO's own file: `config/` of the checkout, or the copy inside an installed wheel."""
    paths = [folder / "config" / "robots" / "archo.yaml" for folder in (_ROOM.parent, _ROOM)]
    return next((path for path in paths if path.is_file()), paths[0])


def load(path: Path) -> RobotFile:
    """The robot that a file describes. Raises ArchoError with one line that says what is wrong."""
    try:
        return _load(path)
    except OSError as error:
        said = f"{path}: cannot read the robot file: {error.strerror}"
    except (bounded_yaml.YamlError, ArchoError) as error:
        said = str(error)
    raise ArchoError(_shown(said))


def read(text: str, path: Path) -> RobotFile:
    """As `load`, of a text that says it stands in that file."""
    try:
        return _read(text, path)
    except (bounded_yaml.YamlError, ArchoError) as error:
        raise ArchoError(_shown(str(error))) from None


def _load(path: Path) -> RobotFile:
    return _read(bounded_yaml.read(path), path)


def _shown(said: str) -> str:
    """The file's own words are in it."""
    shown = "".join(char if char.isprintable() else "\N{REPLACEMENT CHARACTER}" for char in said)
    return shown[:_LONGEST]


def _read(text: str, path: Path) -> RobotFile:
    node = bounded_yaml.compose(text, path)
    if node is None:
        raise ArchoError(f"{path}:1: the file is empty: it describes no robot")
    robot: RobotFile = typed_yaml.read(RobotFile, node, path)
    for where, said in faults.of(robot):
        raise ArchoError(f"{where}: {said}")
    return robot
