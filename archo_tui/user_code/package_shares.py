"""The stand-in for `ament_index_python` that running nodes import where none is installed."""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from archo_tui.launch.stand_ins.packages import AmentIndex
from archo_tui.launch.workspace import Workspace

_NAME = "ament_index_python"


class PackageShares:
    """The share folders of the packages of workspaces, each made when a node first asks for it."""

    def __init__(self, workspaces: Sequence[Workspace]) -> None:
        """Make `ament_index_python` importable until `close`.

        Do nothing if it is installed, or there is no workspace.
        """
        self._prefix: tempfile.TemporaryDirectory[str] | None = None
        if workspaces and importlib.util.find_spec(_NAME) is None:
            self._prefix = tempfile.TemporaryDirectory(prefix="archo-shares-")
            module, index = ModuleType(_NAME), AmentIndex(workspaces, Path(self._prefix.name))
            module.__dict__.update(index.contents(), __path__=[], packages=module)
            sys.modules.update({_NAME: module, f"{_NAME}.packages": module})

    def close(self) -> None:
        """Remove the stand-in for ament_index_python and the share folders."""
        if self._prefix is not None:
            for name in (_NAME, f"{_NAME}.packages"):
                sys.modules.pop(name, None)
            self._prefix.cleanup()
            self._prefix = None
