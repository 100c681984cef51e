"""The evaluation of a launch file, which runs in a process of its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from archo_tui.errors import ArchoError, UserFileError
from archo_tui.launch import child_process
from archo_tui.launch.plan import LaunchArgument, LaunchedProgram, LaunchNote, LaunchPlan
from archo_tui.launch.stand_ins.markup import ENDINGS
from archo_tui.launch.workspace import Workspace

EVALUATION_TIME = 10.0  # Seconds that a launch file may take.
_LAUNCH_FILES = (".py", *ENDINGS)  # The ends of their names.
_CHILD = "archo_tui.launch.evaluation"


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
    arguments: Mapping[str, str],
    seconds: float = EVALUATION_TIME,
) -> LaunchPlan:
    """Return what a launch file, run in a process of its own, would start.

    A program that is not here is left out with a note. Nodes read files in `prefix`, which the
    caller removes. Blocks: not for the UI thread. Raises LaunchFileError.
    """
    value, printed = _evaluate_in_process(given, workspace, prefix, arguments, False, seconds)
    names = _Names(given)
    notes = [names.note(note) for note in value["notes"]]
    notes += [LaunchNote("WARN", given, problem) for problem in workspace.problems]
    programs = []
    for program in value["programs"]:
        try:
            programs.append(_program(program, workspace))
        except ArchoError as error:
            notes.append(names.note({**program, "level": "WARN", "text": str(error)}))
    found = _arguments(value["arguments"])
    files = tuple(value["files"])
    return LaunchPlan(tuple(programs), tuple(notes), found, value["environment"], printed, files)


def launch_arguments(
    given: str, workspace: Workspace, prefix: Path, seconds: float = EVALUATION_TIME
) -> Sequence[LaunchArgument]:
    """Return the arguments that a launch file, whose code is run, declares; blocks."""
    value, _ = _evaluate_in_process(given, workspace, prefix, {}, True, seconds)
    return _arguments(value["arguments"])


def _evaluate_in_process(
    given: str,
    workspace: Workspace,
    prefix: Path,
    arguments: Mapping[str, str],
    only_arguments: bool,
    seconds: float,
) -> tuple[Any, str]:
    """Return the answer of `evaluation.py` about a file, and what the code of the file printed."""
    path = Path(given).resolve()
    if not path.is_file():
        raise LaunchFileError(f"{given}: there is no such launch file")
    if path.suffix not in _LAUNCH_FILES:
        raise LaunchFileError(
            f"{given}: not the name of a launch file: NAME.launch.py, .xml, .yaml"
        )
    request = {
        "file": str(path),
        "arguments": dict(arguments),
        "packages": [str(package.folder.resolve()) for package in workspace.packages.values()],
        "prefix": str(prefix.resolve()),
        "only_arguments": only_arguments,
    }
    reply = child_process.ask(_CHILD, request, seconds)
    if reply.value is None:
        how = f"it ended Python, exit code {reply.exit_code}"
        if reply.exit_code < 0:
            how = f"it does not return within {seconds:g} s"
        raise LaunchFileError(f"{given}: {how}", reply.printed)
    if "error" in reply.value:
        file, line, text, report = reply.value["error"]
        raise LaunchFileError(f"{_Names(given).where(file, line)}: {text}", report)
    return reply.value, reply.printed


class _Names:
    """The names of files in messages: the launch file as typed, others without their folder."""

    def __init__(self, given: str) -> None:
        self._given, self._path = given, str(Path(given).resolve())

    def where(self, file: str, line: int) -> str:
        name = self._given if file in ("", self._path) else Path(file).name
        return f"{name}:{line}" if line else name

    def note(self, note: Mapping[str, Any]) -> LaunchNote:
        return LaunchNote(note["level"], self.where(note["file"], note["line"]), note["text"])


def _program(found: Mapping[str, Any], workspace: Workspace) -> LaunchedProgram:
    """Return a program that was found, with its function; may block on a setup.py."""
    entry_point = workspace.entry_point(found["package"], found["executable"])
    changed: dict[str, Any] = {name: tuple(found[name]) for name in ("ros_args", "arguments")}
    changed["file"] = str(Path(found["file"]).resolve())  # Share folders have links.
    return LaunchedProgram(entry_point=entry_point, **{**found, **changed})


def _arguments(found: Iterable[Mapping[str, Any]]) -> tuple[LaunchArgument, ...]:
    return tuple(
        LaunchArgument(
            argument["name"],
            argument["description"],
            argument["default"],
            tuple(argument["choices"] or ()),
            argument["is_conditional"],
        )
        for argument in found
    )
