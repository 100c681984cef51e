"""Reader of robot files; an error names file, line and the nearest valid word."""

from __future__ import annotations

from pathlib import Path

from archo_tui.errors import ArchoError
from archo_tui.robot_file import typed_yaml, validate
from archo_tui.robot_file.model import RobotFile
from archo_tui.safe_text import harmless
from archo_tui.yaml_text import bounded_yaml

_PACKAGE = Path(__file__).parent.parent


def default_path() -> Path:
    """Return the path of ARCHO's robot file, which may not exist."""
    paths = [folder / "config" / "robots" / "archo.yaml" for folder in (_PACKAGE.parent, _PACKAGE)]
    return next((path for path in paths if path.is_file()), paths[0])


def load(path: Path) -> RobotFile:
    """Read and validate a robot file; ArchoError names the first fault in one line."""
    try:
        return _load(path)
    except OSError as error:
        reason = f"{path}: cannot read the robot file: {error.strerror}"
    except (bounded_yaml.YamlError, ArchoError) as error:
        reason = str(error)
    raise ArchoError(harmless(reason))


def parse(text: str, path: Path) -> RobotFile:
    """Validate the text of a robot file, as `load` does; `path` is only named in errors."""
    try:
        return _parse(text, path)
    except (bounded_yaml.YamlError, ArchoError) as error:
        raise ArchoError(harmless(str(error))) from None


def _load(path: Path) -> RobotFile:
    """Do what `load` does; errors, also YamlError and OSError, may quote control characters."""
    return _parse(bounded_yaml.read(path), path)


def _parse(text: str, path: Path) -> RobotFile:
    """Do what `parse` does; errors, also YamlError, may quote control characters."""
    node = bounded_yaml.compose(text, path)
    if node is None:
        raise ArchoError(f"{path}:1: the file is empty: it describes no robot")
    robot: RobotFile = typed_yaml.read(RobotFile, node, path)
    for where, reason in validate.find_faults(robot):
        raise ArchoError(f"{where}: {reason}")
    return robot
