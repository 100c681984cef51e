"""The process that evaluates a launch file with the stand-ins, and prints what it found as JSON."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.ros.release import EMBEDDED_RELEASE, distribution
from archo_tui.user_code.ros_launch import child_process
from archo_tui.user_code.ros_launch.child_process import ChildError
from archo_tui.user_code.ros_launch.stand_ins import core, markup, packages
from archo_tui.user_code.ros_launch.stand_ins.actions import (
    DeclareLaunchArgument,
    load_launch_file,
    loaded,
    loaders,
)
from archo_tui.user_code.ros_launch.stand_ins.core import LaunchContext, Place, SubstitutionFailure
from archo_tui.user_code.ros_launch.stand_ins.modules import importable_stand_ins
from archo_tui.user_code.ros_launch.workspace import Workspace

loaders.update(markup.LOADERS)
_own_folders: list[Path] = []  # Of the packages, whose modules a launch file may import.


def main() -> None:
    """Answer the request of `evaluate.evaluate`, and end the process."""
    os.environ.setdefault("ROS_DISTRO", distribution() or EMBEDDED_RELEASE)
    child_process.serve(evaluate, _is_own)


def _is_own(filename: str) -> bool:
    beside = any(folder in Path(filename).parents for folder in _own_folders)
    return filename in loaded or beside


def evaluate(request: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a launch file would start; raise ChildError."""
    workspace = Workspace(Path(folder) for folder in request["packages"])
    _own_folders[:] = [package.folder for package in workspace.packages.values()]
    packages.use(packages.PackageIndex(workspace, Path(request["prefix"])))
    loaded.clear()
    context = LaunchContext()
    before = list(sys.path)
    # Built packages are on Python's path, so a launch file can import their modules.
    sys.path += map(str, _own_folders)
    try:
        with importable_stand_ins():
            return _evaluate(request["file"], request["arguments"], context)
    except BaseException as error:
        raise _with_place(error, context) from error
    finally:
        sys.path[:] = before


def _evaluate(path: str, given: Mapping[str, str] | None, context: LaunchContext) -> dict[str, Any]:
    description = load_launch_file(path)
    declared: dict[str, dict[str, Any]] = {}
    for entity, is_conditional in core.known_entities([description]):
        if isinstance(entity, DeclareLaunchArgument):
            declared.setdefault(entity.name, _as_json(entity, is_conditional))
    if given is not None:
        context.launch_file = path
        context.launch_configurations.update(given)
        core.visit(description, context, Place(path, 1))
        core.visit_delayed(context)
        _note_unknown(path, given, declared.keys() | context.read, context)
    return {
        "programs": context.programs,
        "notes": context.notes,
        "arguments": list(declared.values()),
        "environment": context.changed_environment(),
        "files": sorted(loaded),
    }


def _note_unknown(
    path: str, given: Mapping[str, str], known: set[str], context: LaunchContext
) -> None:
    """Note the given arguments that the file does not have, and the packages that are not here."""
    for name in given.keys() - known:
        near = nearest_hint(name, known)
        text = f"{name}:={given[name]}: this launch file has no argument {name}{near}"
        context.note(Place(path, 0), text)
    notes = " ".join(note["text"] for note in context.notes)
    for package, place in packages.index.missing.items():
        if f"{package} is not here" not in notes:
            near = packages.index.workspaces[0].nearest_package_hint(package)
            context.note(place, f"package {package} is not here{near}: its folder has no files")


def _as_json(argument: DeclareLaunchArgument, is_conditional: bool) -> dict[str, Any]:
    default = argument.default_value
    return {
        "name": argument.name,
        "description": argument.description or "",
        "default": None if default is None else core.described(default),
        "choices": argument.choices or (),
        "is_conditional": is_conditional,
    }


def _with_place(error: BaseException, context: LaunchContext) -> ChildError:
    """Describe an error of a launch file, with the file and line to mend if they are known."""
    found = child_process.described(error, _is_own)
    text, place = str(found), getattr(error, "place", None) or context.failed_at
    missing = packages.index.missing_package(str(getattr(error, "filename", "")))
    if missing:
        text = f"package {missing} is not here, nor its files"
    elif isinstance(error, RecursionError) and not found.file:
        text = "these launch files include each other without end"
    elif isinstance(error, (SubstitutionFailure, ArchoError)):  # Of a setup.py, which is named.
        text = str(error)
    if place is None or (found.file and not isinstance(error, SubstitutionFailure)):
        return ChildError(text, found.file, found.line, found.report)
    return ChildError(text, place.file, place.line, found.report)
