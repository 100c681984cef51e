"""The packages that a launch file or a node can find: `ament_index_python`, and `launch_ros`'s."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from archo_tui.base.nearest import nearest_hint
from archo_tui.user_code.ros_launch.stand_ins.core import (
    LaunchContext,
    Place,
    Substitution,
    Text,
    calling_place,
    perform,
)
from archo_tui.user_code.ros_launch.workspace import Workspace


class PackageNotFoundError(KeyError):
    """The error of ament_index_python for an unknown package."""


class AmentIndex:
    """The packages of workspaces, with the functions of `ament_index_python.packages`."""

    def __init__(self, workspaces: Sequence[Workspace], prefix: Path) -> None:
        self.workspaces, self.prefix = workspaces, prefix

    def get_package_prefix(self, package_name: str) -> str:
        """Return the install prefix of a package, and fill its share folder.

        This may run its setup.py, and blocks. Raises PackageNotFoundError, and ArchoError for a
        mistake in setup.py.
        """
        for workspace in self.workspaces:
            package = workspace.find(package_name)
            if package is not None:
                package.fill_share_folder(self.prefix)
                return str(self.prefix)
        known = [name for workspace in self.workspaces for name in workspace.packages]
        near = nearest_hint(package_name, known)
        raise PackageNotFoundError(f"package '{package_name}' not found{near}")

    def get_package_share_directory(self, package_name: str, print_warning: bool = True) -> str:
        """Return the share folder of a package; see `get_package_prefix`."""
        return os.path.join(self.get_package_prefix(package_name), "share", package_name)

    def get_package_share_path(self, package_name: str, print_warning: bool = True) -> Path:
        """Return the share folder of a package as a path."""
        return Path(self.get_package_share_directory(package_name))

    def get_packages_with_prefixes(self) -> dict[str, str]:
        """Return the prefix of each package of the workspaces; see `get_package_prefix`."""
        names = [name for workspace in self.workspaces for name in workspace.packages]
        return {name: self.get_package_prefix(name) for name in names}

    def contents(self) -> dict[str, Any]:
        """Return the names of the module."""
        functions = {name: getattr(self, name) for name in dir(self) if name.startswith("get_")}
        return {"PackageNotFoundError": PackageNotFoundError, **functions}


class PackageIndex(AmentIndex):
    """The index of a launch file, for which a missing package has a path that does not exist.

    So a launch file that also needs other packages is evaluated all the same.
    """

    def __init__(self, workspace: Workspace, prefix: Path) -> None:
        super().__init__([workspace], prefix)
        # Packages that are not here, and a line that needs each.
        self.missing: dict[str, Place] = {}
        self._absent = prefix / "not_here"

    def get_package_prefix(self, package_name: str) -> str:
        """Return a prefix, also of a package that is missing; raise ArchoError."""
        try:
            return super().get_package_prefix(package_name)
        except PackageNotFoundError:
            self.missing.setdefault(package_name, calling_place())
            return str(self._absent / package_name)

    def has_resource(self, resource_type: str, resource_name: str) -> str | bool:
        """Return the prefix of a package, for the resource type `packages`; else False."""
        found = self.get_package_prefix(resource_name) if resource_type == "packages" else ""
        return found if found and resource_name not in self.missing else False

    def missing_package(self, path: str) -> str:
        """Return the name of the missing package whose prefix a path is below, or ""."""
        try:
            return Path(path).relative_to(self._absent).parts[0]
        except (ValueError, IndexError):
            return ""

    def why_missing(self, path: str) -> str:
        """Return the reason why there is no file at a path, and what to do if that is known."""
        for package in self.workspaces[0].packages.values():
            share = self.prefix / "share" / package.name
            if share in Path(path).parents:
                inside = Path(path).relative_to(share)
                if not (package.folder / inside).is_file():
                    return f"{package.name} has no {inside.as_posix()}"
                place = "data_files" if package.is_python else "install(DIRECTORY"
                file = f"{package.build_file.name} of {package.name}"
                return f"{file} does not install {inside.as_posix()}: name it in {place}"
        return f"no file {path}"


index = PackageIndex(Workspace(()), Path(os.devnull))


def use(packages: PackageIndex) -> None:
    """Set the index in which all launch files of this process find their packages."""
    global index
    index = packages


@dataclass(eq=False)
class FindPackagePrefix(Substitution):
    """The install prefix of a package; for a missing package a folder that does not exist."""

    package: Text

    def find(self, package_name: str) -> str:
        """Return the folder that the substitution stands for."""
        return index.get_package_prefix(package_name)

    def perform(self, context: LaunchContext) -> str:
        package = perform(context, self.package)
        found = self.find(package)
        if package in index.missing:  # The caller is no line of the launch file.
            index.missing[package] = self.place
        return found


class FindPackageShare(FindPackagePrefix):
    """The share folder of a package; for a missing package a folder that does not exist."""

    def find(self, package_name: str) -> str:
        return index.get_package_share_directory(package_name)
