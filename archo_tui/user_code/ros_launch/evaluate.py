"""The evaluation of a launch file, which runs in a process of its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from archo_tui.base.errors import ArchoError, UserFileError
from archo_tui.user_code.ros_launch import child_process
from archo_tui.user_code.ros_launch.plan import (
    LaunchArgument,
    LaunchedProgram,
    LaunchNote,
    LaunchPlan,
)
from archo_tui.user_code.ros_launch.workspace import EntryPoint, Workspace

EVALUATION_TIME = 10.0  # Seconds that a launch file may take.
_LAUNCH_FILES = (".py", ".xml", ".launch", ".yaml", ".yml")  # The ends of their names.
_CHILD = "archo_tui.user_code.ros_launch.evaluation"


class LaunchFileError(UserFileError):
    """The error for a launch file that is missing or wrong, or does not return in time."""


def parse_arguments(words: Iterable[str]) -> dict[str, str]:
    """Return the values of words such as `use_sim:=true`, by name; the last one of a name wins."""
    found = {}
    for word in words:
        name, is_one, value = word.partition(":=")
        if not name or not is_one:
            raise ArchoError(f"{word}: an argument of a launch file is written name:=value")
        found[name] = value
    return found


def evaluate(
    given: str,
    workspace: Workspace,
    prefix: Path,
    arguments: Mapping[str, str] | None,
    seconds: float = EVALUATION_TIME,
) -> LaunchPlan:
    """Return what a launch file, run in a process of its own, would start; raise LaunchFileError.

    A program that is not here is left out with a note; without `arguments` all are, and the plan
    says only which arguments there are. Nodes read files in `prefix`, which the caller removes.
    Blocks: not for the UI thread.
    """
    path = Path(given).resolve()
    if not path.is_file():
        raise LaunchFileError(f"{given}: there is no such launch file")
    if path.suffix not in _LAUNCH_FILES:
        raise LaunchFileError(
            f"{given}: not the name of a launch file: NAME.launch.py, .xml, .yaml"
        )
    request = {
        "file": str(path),
        "arguments": None if arguments is None else dict(arguments),
        "packages": [str(package.folder.resolve()) for package in workspace.packages.values()],
        "prefix": str(prefix.resolve()),
    }

    def where(file: str, line: int) -> str:
        """Return a place with the launch file as typed, and others without their folder."""
        name = given if file in ("", str(path)) else Path(file).name
        return f"{name}:{line}" if line else name

    try:
        value, printed = child_process.ask(_CHILD, request, seconds)
    except child_process.ChildError as error:
        text = f"{where(error.file, error.line)}: {error}"
        raise LaunchFileError(text, error.report) from None
    notes = [LaunchNote(n["level"], where(*n["place"]), n["text"]) for n in value["notes"]]
    programs = [{**p, "entry_point": EntryPoint(**p["entry_point"])} for p in value["programs"]]
    return LaunchPlan(
        [LaunchedProgram(**program) for program in programs],
        notes + [LaunchNote("WARN", given, problem) for problem in workspace.problems],
        [LaunchArgument(**found) for found in value["arguments"]],
        value["environment"],
        printed,
        value["files"],
    )
