"""The stand-in for `ament_index_python` that running nodes import where none is installed."""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from archo_tui.launch.workspace import Workspace
from archo_tui.nearest import nearest_hint

_NAME = "ament_index_python"


class PackageNotFoundError(KeyError):
    """The error of ament_index_python for an unknown package."""


class PackageShares:
    """The share folders of the packages of workspaces, each made when a node first asks for it.

    Making one runs the setup.py of the package, while the node that asks waits.
    """

    def __init__(self, workspaces: Iterable[Workspace]) -> None:
        """Make `ament_index_python` importable until `close`.

        Do nothing if it is installed, or there is no workspace.
        """
        self._workspaces = list(workspaces)
        self._prefix: tempfile.TemporaryDirectory[str] | None = None
        if self._workspaces and importlib.util.find_spec(_NAME) is None:
            self._prefix = tempfile.TemporaryDirectory(prefix="archo-shares-")
            for name in (_NAME, f"{_NAME}.packages"):
                sys.modules[name] = self._module(name)

    def close(self) -> None:
        """Remove the stand-in for ament_index_python and the share folders.

        Packages are not found any more.
        """
        if self._prefix is not None:
            for name in (_NAME, f"{_NAME}.packages"):
                sys.modules.pop(name, None)
            self._prefix.cleanup()
            self._prefix = None

    def _module(self, name: str) -> ModuleType:
        module = ModuleType(name)
        module.__dict__.update(
            PackageNotFoundError=PackageNotFoundError,
            get_package_prefix=self.get_package_prefix,
            get_package_share_directory=self.get_package_share_directory,
            get_package_share_path=self.get_package_share_path,
            __path__=[],
            packages=module,
        )
        return module

    def get_package_prefix(self, package_name: str) -> str:
        """Make the share folder of a workspace's package, and return the prefix that it is in.

        Raises:
            PackageNotFoundError: No workspace has such a package, or `close` was called.
            ArchoError: Its setup.py has a mistake.
        """
        prefix = self._prefix
        for workspace in self._workspaces if prefix is not None else ():
            package = workspace.find(package_name)
            if package is not None and prefix is not None:
                package.fill_share_folder(Path(prefix.name))
                return prefix.name
        known = [name for workspace in self._workspaces for name in workspace.packages]
        near = nearest_hint(package_name, known)
        raise PackageNotFoundError(f"package '{package_name}' not found{near}")

    def get_package_share_directory(self, package_name: str, print_warning: bool = True) -> str:
        """Return the share folder of a package, as ament_index_python does.

        The folder is made if necessary. `print_warning` is ignored.

        Raises:
            PackageNotFoundError: No workspace has such a package, or `close` was called.
            ArchoError: Its setup.py has a mistake.
        """
        return os.path.join(self.get_package_prefix(package_name), "share", package_name)

    def get_package_share_path(self, package_name: str, print_warning: bool = True) -> Path:
        """Return the share folder of a package as a path; see `get_package_share_directory`."""
        return Path(self.get_package_share_directory(package_name))
