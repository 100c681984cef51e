"""The node files of the workspaces that are given in place of files.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from archo_tui.errors import ArchoError

if TYPE_CHECKING:
    from archo_tui.launch.workspace import Workspace


class WorkspaceNodes(NamedTuple):
    """The node files of a command line, with each workspace replaced by its modules.

    Attributes:
        names: The files, and the dotted names of modules.
        workspaces: The workspaces.
    """

    names: list[str]
    workspaces: list[Workspace]


def found_in_workspaces(given: Iterable[Path | str]) -> WorkspaceNodes:
    """Return the given files, with each workspace replaced by the modules of its executables.

    The setup.py of each Python package runs, while this waits. The source folders of these packages
    can be imported from afterwards.

    Args:
        given: Python files, modules by dotted names, and folders of workspaces.

    Raises:
        ArchoError: A folder is no workspace, no Python package of it has an executable, or a
            setup.py has a mistake.
    """
    names, workspaces = found = WorkspaceNodes([], [])
    for item in given:
        if not Path(item).is_dir():
            names.append(str(item))
            continue
        from archo_tui.launch.workspace import Workspace

        workspace = Workspace.below(Path(item))
        workspaces.append(workspace)
        packages = workspace.packages.values()
        points = [point for p in packages for point in p.executables().values()]
        if not points:
            raise ArchoError(f"{item}: no setup.py of its packages names a node: console_scripts")
        for point in points:
            point.make_importable()
        names.extend(dict.fromkeys(point.module for point in points))
    return found
