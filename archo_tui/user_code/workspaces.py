"""The workspaces of the user's programs: the nodes of their packages, and the shared files.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import contextlib
import importlib.util
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from archo_tui.base.errors import ArchoError

if TYPE_CHECKING:
    from archo_tui.user_code.ros_launch.workspace import Workspace

_INDEX = "ament_index_python"


def find_nodes(given: Iterable[Path | str]) -> tuple[list[str], list[Workspace]]:
    """Return files and modules with each workspace among them replaced by the modules of its nodes.

    Return the workspaces, too, whose setup.py files run, and whose modules can be imported
    afterwards. ArchoError if a folder has no workspace or no node, or a setup.py has a mistake.
    """
    names: list[str] = []
    workspaces: list[Workspace] = []
    for item in given:
        if not Path(item).is_dir():
            names.append(str(item))
            continue
        from archo_tui.user_code.ros_launch.workspace import Workspace

        workspace = Workspace.below(Path(item))
        workspaces.append(workspace)
        packages = workspace.packages.values()
        points = [point for p in packages for point in p.executables().values()]
        if not points:
            raise ArchoError(f"{item}: no setup.py of its packages names a node: console_scripts")
        for point in points:
            point.make_importable()
        names.extend(dict.fromkeys(point.module for point in points))
    return names, workspaces


@contextlib.contextmanager
def package_shares(workspaces: Sequence[Workspace]) -> Iterator[None]:
    """Let nodes import `ament_index_python` during the block, unless it is installed.

    It knows the packages of the workspaces, whose share folders are made once they are asked for.
    """
    if not workspaces or importlib.util.find_spec(_INDEX) is not None:
        yield
        return
    from archo_tui.user_code.ros_launch.stand_ins.packages import AmentIndex

    with tempfile.TemporaryDirectory(prefix="archo-shares-") as prefix:
        module = ModuleType(_INDEX)
        contents = AmentIndex(workspaces, Path(prefix)).contents()
        module.__dict__.update(contents, __path__=[], packages=module)
        names = (_INDEX, f"{_INDEX}.packages")
        sys.modules.update(dict.fromkeys(names, module))
        yield
        for name in names:
            sys.modules.pop(name, None)
