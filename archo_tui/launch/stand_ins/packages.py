"""The packages that a launch file can find: `ament_index_python.packages`."""

from __future__ import annotations

import os
from pathlib import Path

from archo_tui.launch.install_prefix import missing_file_text, share_folder
from archo_tui.launch.stand_ins.core import Place, calling_place
from archo_tui.launch.workspace import Workspace

_INDEX = Path("share", "ament_index", "resource_index", "packages")


class PackageNotFoundError(KeyError):
    """The error of ament_index_python for an unknown package; it is never raised here."""


class PackageIndex:
    """The packages of the workspace, and of the prefixes on AMENT_PREFIX_PATH."""

    def __init__(self, workspace: Workspace, prefix: Path) -> None:
        self.workspace, self.prefix = workspace, prefix
        # Packages that are not here, and a line that needs each.
        self.missing: dict[str, Place] = {}

    def prefix_of(self, name: str) -> Path:
        """Return the install prefix of a package; for a missing one a path that does not exist.

        So a launch file that also needs other packages is evaluated all the same; they are kept in
        `missing`. The share folder of a workspace's package is filled. Raises ArchoError.
        """
        package = self.workspace.find(name)
        if package is not None:
            share_folder(self.prefix, package)
            return self.prefix
        for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
            if (Path(prefix) / _INDEX / name).is_file():
                return Path(prefix)
        self.missing.setdefault(name, calling_place())
        return self._absent / name

    def missing_package(self, path: str) -> str:
        """Return the name of the missing package whose prefix a path is below, or ""."""
        try:
            return Path(path).relative_to(self._absent).parts[0]
        except (ValueError, IndexError):
            return ""

    def why_missing(self, path: str) -> str:
        """Return the reason why there is no file at a path, and what to do if that is known."""
        known = (
            missing_file_text(self.prefix, package, Path(path))
            for package in self.workspace.packages.values()
        )
        return next(filter(None, known), f"no file {path}")

    @property
    def _absent(self) -> Path:
        return self.prefix / "not_here"


index = PackageIndex(Workspace(()), Path(os.devnull))


def use(packages: PackageIndex) -> None:
    """Set the index in which all launch files of this process find their packages."""
    global index
    index = packages


def get_package_prefix(package_name: str) -> str:
    """Return the install prefix of a package, as `PackageIndex.prefix_of` does."""
    return str(index.prefix_of(package_name))


def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:  # noqa: ARG001
    """Return the share folder of a package; for a missing one a path that does not exist."""
    return str(get_package_share_path(package_name))


def get_package_share_path(package_name: str, print_warning: bool = True) -> Path:  # noqa: ARG001
    """Return the share folder of a package as a Path."""
    return index.prefix_of(package_name) / "share" / package_name


def get_packages_with_prefixes() -> dict[str, str]:
    """Return the install prefix of each package of the workspace; each setup.py runs for it."""
    return {name: get_package_prefix(name) for name in index.workspace.packages}


def has_resource(resource_type: str, resource_name: str) -> str | bool:
    """Return the prefix of a package that is here, for the resource type `packages`; else False."""
    found = get_package_prefix(resource_name) if resource_type == "packages" else ""
    return found if found and resource_name not in index.missing else False
