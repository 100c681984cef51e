"""The substitutions of `launch.substitutions`, and of `launch_ros.substitutions`."""

from __future__ import annotations

import importlib
import math
import os
import random
from collections.abc import Iterable
from typing import Any

from archo_tui.launch.stand_ins import packages
from archo_tui.launch.stand_ins.core import (
    LaunchContext,
    SomeSubstitutionsType,
    Substitution,
    SubstitutionFailure,
    TextSubstitution,
    is_substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from archo_tui.launch.stand_ins.values import typed_text
from archo_tui.nearest import nearest_hint

__all__ = [
    "AllSubstitution",
    "AndSubstitution",
    "AnonName",
    "AnySubstitution",
    "EnvironmentVariable",
    "EqualsSubstitution",
    "FileContent",
    "IfElseSubstitution",
    "LaunchConfiguration",
    "NotEqualsSubstitution",
    "NotSubstitution",
    "OrSubstitution",
    "PathJoinSubstitution",
    "PathSubstitution",
    "PythonExpression",
    "SubstitutionFailure",
    "TextSubstitution",
    "ThisLaunchFile",
    "ThisLaunchFileDir",
]


def _as_texts(default: Any) -> list[Substitution] | None:
    if default is None:
        return None
    parts = default if isinstance(default, Iterable) else (default,)
    if isinstance(default, str):
        parts = (default,)
    return [
        part if isinstance(part, Substitution) else TextSubstitution(text=str(part))
        for part in parts
    ]


class LaunchConfiguration(Substitution):
    """The value of a launch configuration, such as an argument, or else the default."""

    def __init__(self, variable_name: SomeSubstitutionsType, *, default: Any = None) -> None:
        super().__init__()
        self.variable_name = normalize_to_list_of_substitutions(variable_name)
        self._default = _as_texts(default)

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.variable_name)
        context.read.add(name)
        if name in context.launch_configurations:
            value: str = context.launch_configurations[name]
            return value
        if self._default is not None:
            return perform_substitutions(context, self._default)
        near = nearest_hint(name, context.launch_configurations)
        hint = "" if near else f": declare it before, DeclareLaunchArgument('{name}')"
        raise SubstitutionFailure(f"no launch configuration {name}{near}{hint}", self.place)

    def describe(self) -> str:
        return f"LaunchConfiguration({' + '.join(p.describe() for p in self.variable_name)})"


class EnvironmentVariable(Substitution):
    """The value of an environment variable in the scope, or else the default."""

    def __init__(
        self, name: SomeSubstitutionsType, *, default_value: SomeSubstitutionsType | None = None
    ) -> None:
        super().__init__()
        self.name = normalize_to_list_of_substitutions(name)
        self.default_value = (
            None if default_value is None else normalize_to_list_of_substitutions(default_value)
        )

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        if name in context.environment:
            return context.environment[name]
        if self.default_value is None:
            hint = "export it, or give EnvironmentVariable a default_value"
            raise SubstitutionFailure(f"no environment variable {name}: {hint}", self.place)
        return perform_substitutions(context, self.default_value)

    def describe(self) -> str:
        return f"EnvironmentVariable({' + '.join(p.describe() for p in self.name)})"


class PathJoinSubstitution(Substitution):
    """Parts of a path, joined as by `os.path.join`; the operator `/` adds a part."""

    def __init__(self, substitutions: Iterable[SomeSubstitutionsType]) -> None:
        super().__init__()
        self.substitutions = [normalize_to_list_of_substitutions(part) for part in substitutions]

    def perform(self, context: LaunchContext) -> str:
        return os.path.join(*[perform_substitutions(context, p) for p in self.substitutions])

    def __truediv__(self, part: SomeSubstitutionsType) -> PathJoinSubstitution:
        return PathJoinSubstitution([*self.substitutions, part])

    def describe(self) -> str:
        return "/".join("".join(p.describe() for p in parts) for parts in self.substitutions)


class PathSubstitution(PathJoinSubstitution):
    """A path, to which the operator `/` adds parts."""

    def __init__(self, path: SomeSubstitutionsType) -> None:
        super().__init__([path])


class PythonExpression(Substitution):
    """The result of a Python expression as text.

    The expression can use the given modules by their names, and what `math` contains without that
    name.
    """

    def __init__(
        self, expression: SomeSubstitutionsType, python_modules: Iterable[Any] = ("math",)
    ) -> None:
        super().__init__()
        self.expression = normalize_to_list_of_substitutions(expression)
        self.python_modules = normalize_to_list_of_substitutions(python_modules)

    def perform(self, context: LaunchContext) -> str:
        text = perform_substitutions(context, self.expression)
        names: dict[str, Any] = {}
        for part in self.python_modules:
            module = importlib.import_module(part.perform(context))
            names |= vars(module) if module is math else {}
            names[module.__name__] = module
        try:
            return str(eval(text, {}, names))
        except Exception as error:
            why = f"PythonExpression {text}: {type(error).__name__}: {error}"
            if isinstance(error, NameError):
                why += ': a text needs quotes in it, ["\'", LaunchConfiguration(...), "\'"]'
            raise SubstitutionFailure(why, self.place) from error

    def describe(self) -> str:
        return f"PythonExpression({' + '.join(p.describe() for p in self.expression)})"


class _Boolean(Substitution):
    """The base of the substitutions that compute with YAML's booleans, `1` and `0`."""

    def perform(self, context: LaunchContext) -> str:
        return str(self._holds(context)).lower()

    def _holds(self, context: LaunchContext) -> bool:
        raise NotImplementedError

    def _as_bool(self, context: LaunchContext, parts: list[Substitution]) -> bool:
        try:
            return bool(typed_text(perform_substitutions(context, parts), bool))
        except ValueError as error:
            raise SubstitutionFailure(error, self.place) from None


class NotSubstitution(_Boolean):
    """The text `true` if a boolean is false, else `false`."""

    def __init__(self, value: SomeSubstitutionsType) -> None:
        super().__init__()
        self.value = normalize_to_list_of_substitutions(value)

    def _holds(self, context: LaunchContext) -> bool:
        return not self._as_bool(context, self.value)


class AnySubstitution(_Boolean):
    """The text `true` if at least one of several booleans is true, else `false`."""

    def __init__(self, *args: SomeSubstitutionsType) -> None:
        super().__init__()
        self.args = [normalize_to_list_of_substitutions(part) for part in args]

    def _holds(self, context: LaunchContext) -> bool:
        return any([self._as_bool(context, part) for part in self.args])


class AllSubstitution(AnySubstitution):
    """The text `true` if all of several booleans are true, else `false`."""

    def _holds(self, context: LaunchContext) -> bool:
        return all([self._as_bool(context, part) for part in self.args])


class OrSubstitution(AnySubstitution):
    """The text `true` if at least one of two booleans is true, else `false`."""

    def __init__(self, left: SomeSubstitutionsType, right: SomeSubstitutionsType) -> None:
        super().__init__(left, right)


class AndSubstitution(AllSubstitution):
    """The text `true` if both of two booleans are true, else `false`."""

    def __init__(self, left: SomeSubstitutionsType, right: SomeSubstitutionsType) -> None:
        super().__init__(left, right)


class EqualsSubstitution(_Boolean):
    """The text `true` if two values are equal, else `false`.

    They are compared as booleans, which `1` and `0` are, too, or as numbers, if both are such; else
    as texts.
    """

    def __init__(self, left: Any, right: Any) -> None:
        super().__init__()
        self.left, self.right = _compared(left), _compared(right)

    def _holds(self, context: LaunchContext) -> bool:
        left = perform_substitutions(context, self.left)
        right = perform_substitutions(context, self.right)
        words = {"true": True, "1": True, "false": False, "0": False}
        if left.lower() in words and right.lower() in words:
            return words[left.lower()] == words[right.lower()]
        try:
            return math.isclose(float(left), float(right))
        except ValueError:
            return left == right


class NotEqualsSubstitution(EqualsSubstitution):
    """The text `true` if two values differ by the rules of EqualsSubstitution, else `false`."""

    def _holds(self, context: LaunchContext) -> bool:
        return not super()._holds(context)


def _compared(value: Any) -> list[Substitution]:
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    text = "" if value is None else str(value)
    return [TextSubstitution(text=text.lower() if isinstance(value, bool) else text)]


class IfElseSubstitution(_Boolean):
    """The first of two texts if a boolean is true, else the second; both are empty by default."""

    def __init__(
        self,
        condition: SomeSubstitutionsType,
        if_value: SomeSubstitutionsType = "",
        else_value: SomeSubstitutionsType = "",
    ) -> None:
        super().__init__()
        self.condition = normalize_to_list_of_substitutions(condition)
        self.if_value = normalize_to_list_of_substitutions(if_value)
        self.else_value = normalize_to_list_of_substitutions(else_value)

    def perform(self, context: LaunchContext) -> str:
        holds = self._as_bool(context, self.condition)
        return perform_substitutions(context, self.if_value if holds else self.else_value)


class FileContent(Substitution):
    """The text of a file; SubstitutionFailure is raised if the file cannot be opened."""

    def __init__(self, path: SomeSubstitutionsType) -> None:
        super().__init__()
        self.path = normalize_to_list_of_substitutions(path)

    def perform(self, context: LaunchContext) -> str:
        path = perform_substitutions(context, self.path)
        try:
            with open(path, encoding="utf-8") as file:
                return file.read()
        except OSError as error:
            raise SubstitutionFailure(f"{path}: {error.strerror}", self.place) from None


class AnonName(Substitution):
    """A unique name that begins with a given name; in a scope, the same for the same name."""

    def __init__(self, name: SomeSubstitutionsType) -> None:
        super().__init__()
        self.name = normalize_to_list_of_substitutions(name)

    def perform(self, context: LaunchContext) -> str:
        name = perform_substitutions(context, self.name)
        unique = f"{name}_{os.getpid()}_{random.randrange(10**9)}"
        text: str = context.launch_configurations.setdefault(f"anon{name}", unique)
        return text


class ThisLaunchFile(Substitution):
    """The path of the launch file that is performed, or was included last."""

    def perform(self, context: LaunchContext) -> str:
        return str(context.locals.current_launch_file_path)


class ThisLaunchFileDir(Substitution):
    """The folder of the launch file that is performed, or was included last."""

    def perform(self, context: LaunchContext) -> str:
        return str(context.locals.current_launch_file_directory)


OF_ROS = ("FindPackagePrefix", "FindPackageShare", "Parameter")  # In `launch_ros.substitutions`.


class FindPackagePrefix(Substitution):
    """The install prefix of a package; for a missing package a folder that does not exist."""

    def __init__(self, package: SomeSubstitutionsType) -> None:
        super().__init__()
        self.package = normalize_to_list_of_substitutions(package)

    def find(self, package_name: str) -> str:
        """Return the folder that the substitution stands for."""
        return packages.get_package_prefix(package_name)

    def perform(self, context: LaunchContext) -> str:
        package = perform_substitutions(context, self.package)
        found = self.find(package)
        if package in packages.index.missing:  # The caller is no line of the launch file.
            packages.index.missing[package] = self.place
        return found

    def describe(self) -> str:
        return f"{type(self).__name__}({' + '.join(p.describe() for p in self.package)})"


class FindPackageShare(FindPackagePrefix):
    """The share folder of a package; for a missing package a folder that does not exist."""

    def find(self, package_name: str) -> str:
        return packages.get_package_share_directory(package_name)


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
