"""The process that evaluates a launch file with the stand-ins, and prints what it found as JSON."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from types import FrameType
from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.launch import child_process, user_errors
from archo_tui.launch.stand_ins import frontend, markup, packages
from archo_tui.launch.stand_ins.core import (
    DeclaredArgument,
    LaunchContext,
    LaunchDescription,
    Place,
    SubstitutionFailure,
    declared_arguments,
    visit,
    visit_delayed,
)
from archo_tui.launch.stand_ins.modules import importable_stand_ins
from archo_tui.launch.stand_ins.sources import LOADERS, load_launch_file, loaded_files
from archo_tui.launch.workspace import Workspace
from archo_tui.nearest import nearest_hint
from archo_tui.ros_release import EMBEDDED_RELEASE, distribution

LOADERS.update(dict.fromkeys(markup.ENDINGS, frontend.load))
_own_folders: list[Path] = []  # Of the packages, whose modules a launch file may import.


def main() -> None:
    """Answer the request of `evaluate.evaluate` or `launch_arguments`, and end the process."""
    os.environ.setdefault("ROS_DISTRO", distribution() or EMBEDDED_RELEASE)
    child_process.serve(evaluate, lambda frame, seconds: {"error": _hang(frame, seconds)})


def _hang(frame: FrameType | None, seconds: float) -> user_errors.UserError:
    return user_errors.describe_hang(frame, seconds, _is_own)


def _is_own(filename: str) -> bool:
    beside = any(folder in Path(filename).parents for folder in _own_folders)
    return filename in loaded_files or beside


def evaluate(request: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a launch file would start, or only `error`, a UserError."""
    workspace = Workspace(Path(folder) for folder in request["packages"])
    _own_folders[:] = [package.folder for package in workspace.packages.values()]
    packages.use(packages.PackageIndex(workspace, Path(request["prefix"])))
    context = LaunchContext()
    before = list(sys.path)
    # Built packages are on Python's path, so a launch file can import their modules.
    sys.path += map(str, _own_folders)
    try:
        with importable_stand_ins():
            return _evaluate(request, context)
    except BaseException as error:
        return {"error": _user_error_of(error, context)}
    finally:
        sys.path[:] = before


def _evaluate(request: Mapping[str, Any], context: LaunchContext) -> dict[str, Any]:
    path, given = request["file"], dict(request["arguments"])
    description = load_launch_file(path)
    declared = declared_arguments(description.entities)
    if not request["only_arguments"]:
        _perform(path, description, declared, given, context)
    return {
        "programs": context.programs,
        "notes": context.notes,
        "arguments": [_as_json(found) for found in declared],
        "environment": context.changed_environment(),
        "files": sorted(loaded_files),
    }


def _perform(
    path: str,
    description: LaunchDescription,
    declared: list[DeclaredArgument],
    given: dict[str, str],
    context: LaunchContext,
) -> None:
    context.locals.current_launch_file_path = path
    context.locals.current_launch_file_directory = os.path.dirname(path)
    for found in declared:
        if found.is_required and found.argument.name not in {*given, *found.given}:
            raise SubstitutionFailure(found.argument.missing_text(), found.argument.place)
    context.launch_configurations.update(given)
    visit(description, context, Place(path, 1))
    visit_delayed(context)
    known = {found.argument.name for found in declared} | context.read
    for name in given.keys() - known:
        near = nearest_hint(name, known)
        context.note(
            Place(path, 0), f"{name}:={given[name]}: this launch file has no argument {name}{near}"
        )
    notes = " ".join(note["text"] for note in context.notes)
    for package, place in packages.index.missing.items():
        if f"{package} is not here" not in notes:
            near = packages.index.workspace.nearest_package_hint(package)
            context.note(place, f"package {package} is not here{near}: its folder has no files")


def _as_json(found: DeclaredArgument) -> dict[str, Any]:
    argument, default = found.argument, found.argument.default_value
    return {
        "name": argument.name,
        "description": argument.description,
        "default": None if default is None else "".join(part.describe() for part in default),
        "choices": argument.choices,
        "is_conditional": found.is_conditional,
        "file": argument.place.file,
        "line": argument.place.line,
    }


def _user_error_of(error: BaseException, context: LaunchContext) -> user_errors.UserError:
    """Describe an error of a launch file, with the file and line to mend, or "" and 0."""
    described = user_errors.describe(error, _is_own)
    place: Place | None = getattr(error, "place", None)
    missing = packages.index.missing_package(str(getattr(error, "filename", "")))
    if missing:
        described = described._replace(text=f"package {missing} is not here, nor its files")
    elif isinstance(error, ArchoError):  # A setup.py, which is named.
        described = described._replace(text=str(error))
    if isinstance(error, SubstitutionFailure):
        described = described._replace(text=str(error))
    elif described.file:
        return described
    place = place or context.failed_at
    if place is None:
        return described
    return described._replace(file=place.file, line=place.line)
