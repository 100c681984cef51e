"""The packages that a launch file can find: `ament_index_python.packages`, `launch_ros`'s too."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from archo_tui.launch.package import INDEX, Package
from archo_tui.launch.stand_ins.core import (
    LaunchContext,
    Place,
    Substitution,
    Text,
    calling_place,
    perform,
)
from archo_tui.launch.workspace import Workspace


class PackageNotFoundError(KeyError):
    """The error of ament_index_python for an unknown package; it is never raised here."""


class PackageIndex:
    """The packages of the workspace, and of the prefixes on AMENT_PREFIX_PATH."""

    def __init__(self, workspace: Workspace, prefix: Path) -> None:
        self.workspace, self.prefix = workspace, prefix
        # Packages that are not here, and a line that needs each.
        self.missing: dict[str, Place] = {}
        self._absent = prefix / "not_here"

    def prefix_of(self, name: str) -> Path:
        """Return the install prefix of a package; for a missing one a path that does not exist.

        So a launch file that also needs other packages is evaluated all the same; they are kept in
        `missing`. The share folder of a workspace's package is filled. Raises ArchoError.
        """
        package = self.workspace.find(name)
        if package is not None:
            package.fill_share_folder(self.prefix)
            return self.prefix
        for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
            if (Path(prefix) / INDEX / name).is_file():
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
        for package in self.workspace.packages.values():
            share = package.share_folder(self.prefix)
            if share in Path(path).parents:
                return _why_missing(package, Path(path).relative_to(share))
        return f"no file {path}"


def _why_missing(package: Package, inside: Path) -> str:
    if not (package.folder / inside).is_file():
        return f"{package.name} has no {inside.as_posix()}"
    rule = "name it in data_files" if package.is_python else "name its folder in install(DIRECTORY"
    file = package.build_file.name
    return f"{file} of {package.name} does not install {inside.as_posix()}: {rule}"


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


@dataclass(eq=False)
class FindPackagePrefix(Substitution):
    """The install prefix of a package; for a missing package a folder that does not exist."""

    package: Text

    def find(self, package_name: str) -> str:
        """Return the folder that the substitution stands for."""
        return get_package_prefix(package_name)

    def perform(self, context: LaunchContext) -> str:
        package = perform(context, self.package)
        found = self.find(package)
        if package in index.missing:  # The caller is no line of the launch file.
            index.missing[package] = self.place
        return found


class FindPackageShare(FindPackagePrefix):
    """The share folder of a package; for a missing package a folder that does not exist."""

    def find(self, package_name: str) -> str:
        return get_package_share_directory(package_name)
