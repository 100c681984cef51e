"""The substitutions of `launch_ros.substitutions`."""

from __future__ import annotations

from typing import Any

from archo_tui.launch.stand_ins import ament_index
from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.failures import SubstitutionFailure
from archo_tui.launch.stand_ins.substitution import (
    SomeSubstitutionsType,
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = ["FindPackagePrefix", "FindPackageShare", "Parameter"]


class FindPackagePrefix(Substitution):
    """The install prefix of a package; for a missing package a folder that does not exist."""

    def __init__(self, package: SomeSubstitutionsType) -> None:
        super().__init__()
        self.package = normalize_to_list_of_substitutions(package)

    def find(self, package_name: str) -> str:
        """Return the folder that the substitution stands for."""
        return ament_index.get_package_prefix(package_name)

    def perform(self, context: LaunchContext) -> str:
        package = perform_substitutions(context, self.package)
        found = self.find(package)
        if package in ament_index.index.missing:  # The caller is no line of the launch file.
            ament_index.index.missing[package] = self.place
        return found

    def describe(self) -> str:
        return f"{type(self).__name__}({' + '.join(p.describe() for p in self.package)})"


class FindPackageShare(FindPackagePrefix):
    """The share folder of a package; for a missing package a folder that does not exist."""

    def find(self, package_name: str) -> str:
        return ament_index.get_package_share_directory(package_name)


class Parameter(Substitution):
    """The first value, as text, of a parameter that SetParameter has set, else the default."""

    def __init__(self, name: SomeSubstitutionsType, *, default: Any = None) -> None:
        super().__init__()
        self.name = normalize_to_list_of_substitutions(name)
        self._default = (
            None
            if default is None or isinstance(default, (bool, int, float))
            else normalize_to_list_of_substitutions(default)
        )
        if self._default is None and default is not None:
            self._default = normalize_to_list_of_substitutions(str(default))

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        for entry in context.launch_configurations.get("global_params", ()):
            if isinstance(entry, tuple) and entry[0] == name:
                return str(entry[1])
        if self._default is None:
            raise SubstitutionFailure(f"no parameter {name}: SetParameter sets it", self.place)
        return perform_substitutions(context, self._default)
