"""The node files and interface packages of the workspaces that are given in place of files.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from archo_tui.errors import ArchoError


def found_in_workspaces(given: Iterable[Path | str]) -> tuple[list[str], list[Path]]:
    """Return node files, with the modules of a workspace's executables in its place.

    The source folders of the workspace's packages can be imported from afterwards.

    Args:
        given: Python files, modules by dotted names, and folders of workspaces.

    Returns:
        The files and the dotted names of modules, and the folders of interface packages.

    Raises:
        ArchoError: A folder is no workspace, or no Python package of it has an executable.
    """
    names: list[str] = []
    interfaces: list[Path] = []
    for item in given:
        if not Path(item).is_dir():
            names.append(str(item))
            continue
        from archo_tui.launch.workspace import Workspace

        workspace = Workspace.below(Path(item))
        packages = workspace.packages.values()
        points = [point for p in packages for point in workspace.executables(p).values()]
        if not points:
            raise ArchoError(f"{item}: no setup.py of its packages names a node: console_scripts")
        for point in points:
            if point.source is not None and str(point.source) not in sys.path:
                sys.path.insert(0, str(point.source))
        names += dict.fromkeys(point.module for point in points)
        interfaces += workspace.interface_packages.values()
    return names, interfaces
