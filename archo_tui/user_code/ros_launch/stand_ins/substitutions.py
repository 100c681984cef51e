"""The substitutions of `launch.substitutions`."""

from __future__ import annotations

import importlib
import math
import os
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any

from archo_tui.base.nearest import nearest_hint
from archo_tui.user_code.ros_launch.stand_ins.core import (
    LaunchContext,
    Substitution,
    SubstitutionFailure,
    Text,
    Texts,
    described,
    flag,
    is_substitution,
    perform,
)


@dataclass(eq=False)
class LaunchConfiguration(Substitution):
    """The value of a launch configuration, such as an argument, or else the default."""

    variable_name: Text
    _: KW_ONLY
    default: Any = None

    def perform(self, context: LaunchContext) -> str:
        name = perform(context, self.variable_name)
        context.read.add(name)
        if name in context.launch_configurations:
            value: str = context.launch_configurations[name]
            return value
        if self.default is not None:
            is_plain = isinstance(self.default, (bool, int, float))
            return perform(context, str(self.default) if is_plain else self.default)
        near = nearest_hint(name, context.launch_configurations)
        hint = near or f": declare it before, DeclareLaunchArgument('{name}')"
        raise SubstitutionFailure(f"no launch configuration {name}{hint}", self.place)


@dataclass(eq=False)
class EnvironmentVariable(Substitution):
    """The value of an environment variable in the scope, or else the default."""

    name: Text
    _: KW_ONLY
    default_value: Text | None = None

    def perform(self, context: LaunchContext) -> str:
        name = perform(context, self.name)
        if name in context.environment:
            return context.environment[name]
        if self.default_value is None:
            hint = "export it, or give EnvironmentVariable a default_value"
            raise SubstitutionFailure(f"no environment variable {name}: {hint}", self.place)
        return perform(context, self.default_value)


@dataclass(eq=False)
class PathJoinSubstitution(Substitution):
    """Parts of a path, joined as by `os.path.join`; the operator `/` adds a part."""

    substitutions: Texts

    def perform(self, context: LaunchContext) -> str:
        return os.path.join(*[perform(context, part) for part in self.substitutions])

    def describe(self) -> str:
        return "/".join(map(described, self.substitutions))

    def __truediv__(self, part: Text) -> PathJoinSubstitution:
        return PathJoinSubstitution([*self.substitutions, part])


class PathSubstitution(PathJoinSubstitution):
    """A path, to which the operator `/` adds parts."""

    def __init__(self, path: Text) -> None:
        super().__init__([path])


@dataclass(eq=False)
class PythonExpression(Substitution):
    """The result of a Python expression as text.

    It can use the given modules by their names, and what `math` contains without that name.
    """

    expression: Text
    python_modules: Texts = ("math",)

    def perform(self, context: LaunchContext) -> str:
        text = perform(context, self.expression)
        names: dict[str, Any] = {}
        modules = [perform(context, part) for part in self.python_modules]
        for name in ",".join(modules).split(","):  # In XML they are one text.
            module = importlib.import_module(name.strip())
            names |= vars(module) if module is math else {}
            names[module.__name__] = module
        try:
            return str(eval(text, {}, names))
        except Exception as error:
            why = f"PythonExpression {text}: {type(error).__name__}: {error}"
            if isinstance(error, NameError):
                why += ': a text needs quotes in it, ["\'", LaunchConfiguration(...), "\'"]'
            raise SubstitutionFailure(why, self.place) from error


class _Boolean(Substitution):
    """The base of the substitutions that compute with YAML's booleans, `1` and `0`."""

    def _is_true(self, context: LaunchContext, given: Text) -> bool:
        try:
            return flag(context, given)
        except ValueError as error:
            raise SubstitutionFailure(error, self.place) from None


@dataclass(eq=False)
class NotSubstitution(_Boolean):
    """The text `true` if a boolean is false, else `false`."""

    value: Text

    def perform(self, context: LaunchContext) -> str:
        return str(not self._is_true(context, self.value)).lower()


@dataclass(eq=False)
class AndSubstitution(_Boolean):
    """The text `true` if both of two booleans are true, else `false`."""

    left: Text
    right: Text

    def perform(self, context: LaunchContext) -> str:
        both = self._is_true(context, self.left) & self._is_true(context, self.right)
        return str(both).lower()


class OrSubstitution(AndSubstitution):
    """The text `true` if at least one of two booleans is true, else `false`."""

    def perform(self, context: LaunchContext) -> str:
        one = self._is_true(context, self.left) | self._is_true(context, self.right)
        return str(one).lower()


@dataclass(eq=False)
class EqualsSubstitution(Substitution):
    """The text `true` if two values are equal as booleans, as numbers or as texts."""

    left: Any
    right: Any

    def perform(self, context: LaunchContext) -> str:
        return str(self._are_equal(context)).lower()

    def _are_equal(self, context: LaunchContext) -> bool:
        left, right = [_compared(context, value) for value in (self.left, self.right)]
        words = {"true": True, "1": True, "false": False, "0": False}
        if left.lower() in words and right.lower() in words:
            return words[left.lower()] == words[right.lower()]
        try:
            return math.isclose(float(left), float(right))
        except ValueError:
            return left == right


class NotEqualsSubstitution(EqualsSubstitution):
    """The text `true` if two values differ by the rules of EqualsSubstitution, else `false`."""

    def _are_equal(self, context: LaunchContext) -> bool:
        return not super()._are_equal(context)


def _compared(context: LaunchContext, value: Any) -> str:
    if is_substitution(value):
        return perform(context, value)
    return "" if value is None else str(value)


@dataclass(eq=False)
class IfElseSubstitution(_Boolean):
    """The first of two texts if a boolean is true, else the second; both are empty by default."""

    condition: Text
    if_value: Text = ""
    else_value: Text = ""

    def perform(self, context: LaunchContext) -> str:
        holds = self._is_true(context, self.condition)
        return perform(context, self.if_value if holds else self.else_value)


@dataclass(eq=False)
class FileContent(Substitution):
    """The text of a file; SubstitutionFailure is raised if the file cannot be opened."""

    path: Text

    def perform(self, context: LaunchContext) -> str:
        path = perform(context, self.path)
        try:
            return Path(path).read_text(encoding="utf-8")
        except OSError as error:
            raise SubstitutionFailure(f"{path}: {error.strerror}", self.place) from None


class ThisLaunchFile(Substitution):
    """The path of the launch file that is performed, or was included last."""

    def perform(self, context: LaunchContext) -> str:
        return context.launch_file


class ThisLaunchFileDir(Substitution):
    """The folder of the launch file that is performed, or was included last."""

    def perform(self, context: LaunchContext) -> str:
        return os.path.dirname(context.launch_file)
