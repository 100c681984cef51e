"""The actions of `launch.actions`."""

from __future__ import annotations

import contextlib
import heapq
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

from archo_tui.launch.stand_ins.core import (
    Action,
    Flag,
    LaunchContext,
    Number,
    SubstitutionFailure,
    Text,
    at,
    perform,
)
from archo_tui.launch.stand_ins.sources import AnyLaunchDescriptionSource
from archo_tui.launch.stand_ins.values import flag, number
from archo_tui.nearest import nearest_hint

_entered: list[str] = []  # The included files in which arguments are looked for.


@dataclass(eq=False)
class DeclareLaunchArgument(Action):
    """The action that declares an argument of the launch file, and sets its default if need be.

    SubstitutionFailure is raised without a value or a default, and for one that is not among the
    choices.
    """

    name: str
    _: KW_ONLY
    default_value: Text | None = None
    description: str | None = None
    choices: Iterable[str] | None = None

    def __post_init__(self) -> None:
        default = self.default_value
        super().__post_init__()
        self.choices = None if self.choices is None else [*map(str, self.choices)]
        if isinstance(default, str):
            self._check(default)

    def execute(self, context: LaunchContext) -> None:
        if self.name not in context.launch_configurations:
            if self.default_value is None:
                about = f" ({self.description})" if self.description else ""
                text = f"argument {self.name}{about} has no value: give {self.name}:=VALUE"
                raise SubstitutionFailure(text, self.place)
            value = perform(context, self.default_value)
            context.launch_configurations[self.name] = value
        self._check(context.launch_configurations[self.name])

    def _check(self, value: str) -> None:
        if self.choices is not None and value not in self.choices:
            wanted, near = ", ".join(self.choices), nearest_hint(value, self.choices)
            text = f"argument {self.name} is {value!r}: one of {wanted} is wanted{near}"
            raise SubstitutionFailure(text, self.place)


@dataclass(eq=False)
class SetLaunchConfiguration(Action):
    """The action that sets a launch configuration, until the scope ends."""

    name: Text
    value: Text

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations[perform(context, self.name)] = perform(context, self.value)


@dataclass(eq=False)
class UnsetLaunchConfiguration(Action):
    """The action that removes a launch configuration, until the scope ends."""

    name: Text

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations.pop(perform(context, self.name), None)


@dataclass(eq=False)
class ResetLaunchConfigurations(Action):
    """The action that replaces all launch configurations by those given, by default by none."""

    launch_configurations: Mapping[Any, Any] | None = None

    def execute(self, context: LaunchContext) -> None:
        given = self.launch_configurations or {}
        kept = {perform(context, name): perform(context, value) for name, value in given.items()}
        context.launch_configurations.clear()
        context.launch_configurations.update(kept)


class PushLaunchConfigurations(Action):
    """The action that begins a scope of launch configurations, with a copy of those around it."""

    def execute(self, context: LaunchContext) -> None:
        context.begin_scope("launch_configurations")


class PopLaunchConfigurations(Action):
    """The action that ends a scope of launch configurations, and restores those before it."""

    def execute(self, context: LaunchContext) -> None:
        context.end_scope("launch_configurations")


class PushEnvironment(Action):
    """The action that begins a scope of environment variables, with a copy of those around it."""

    def execute(self, context: LaunchContext) -> None:
        context.begin_scope("environment")


class PopEnvironment(Action):
    """The action that ends a scope of environment variables, and restores those before it."""

    def execute(self, context: LaunchContext) -> None:
        context.end_scope("environment")


class ResetEnvironment(Action):
    """The action that restores, in its scope, the environment variables of the launch's start."""

    def execute(self, context: LaunchContext) -> None:
        context.environment = dict(os.environ)


@dataclass(eq=False)
class SetEnvironmentVariable(Action):
    """The action that sets an environment variable, until the scope ends."""

    name: Text
    value: Text

    def execute(self, context: LaunchContext) -> None:
        context.environment[perform(context, self.name)] = perform(context, self.value)


@dataclass(eq=False)
class UnsetEnvironmentVariable(Action):
    """The action that removes an environment variable, until the scope ends."""

    name: Text

    def execute(self, context: LaunchContext) -> None:
        context.environment.pop(perform(context, self.name), None)


@dataclass(eq=False)
class AppendEnvironmentVariable(Action):
    """The action that appends to an environment variable, or with `prepend` puts before it."""

    name: Text
    value: Text
    prepend: Flag = False
    separator: Text = os.pathsep

    def execute(self, context: LaunchContext) -> None:
        name, parts = perform(context, self.name), [perform(context, self.value)]
        if name in context.environment:
            at = len(parts) if flag(context, self.prepend) else 0
            parts.insert(at, context.environment[name])
        context.environment[name] = perform(context, self.separator).join(parts)


@dataclass(eq=False)
class GroupAction(Action):
    """The action that performs several actions, in a scope of their own unless `scoped` is false.

    If `forwarding` is false, the scope has only the given launch configurations, and the
    environment of the start.
    """

    actions: Iterable[Any]
    _: KW_ONLY
    scoped: Flag = True
    forwarding: Flag = True
    launch_configurations: Mapping[Any, Any] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.actions = list(self.actions)

    def execute(self, context: LaunchContext) -> list[Any]:
        given = self.launch_configurations or {}
        with at(self.place):
            sets: list[Action] = [SetLaunchConfiguration(*pair) for pair in given.items()]
            if not flag(context, self.scoped):
                return [*sets, *self.actions]
            if not flag(context, self.forwarding):
                sets = [ResetEnvironment(), ResetLaunchConfigurations(given)]
            begin, end = PushLaunchConfigurations(), PopLaunchConfigurations()
            return [begin, PushEnvironment(), *sets, *self.actions, PopEnvironment(), end]

    def sub_entities(self) -> Iterable[Any]:
        return self.actions


@dataclass(eq=False)
class IncludeLaunchDescription(Action):
    """The action that sets the given arguments, and performs everything in another launch file.

    The arguments and ThisLaunchFile keep the values of the included file afterwards, as in launch.
    """

    launch_description_source: Any
    _: KW_ONLY
    launch_arguments: Iterable[tuple[Any, Any]] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        source = self.launch_description_source
        self._source = source if hasattr(source, "load") else AnyLaunchDescriptionSource(source)
        if isinstance(self.launch_arguments, Mapping):
            raise TypeError("launch_arguments is a mapping: write {...}.items()")
        # Looked at when it is executed, as in launch: a condition may leave a wrong one out.
        self._arguments = list(self.launch_arguments or ())

    def execute(self, context: LaunchContext) -> list[Any]:
        path, description = self._source.load(context)
        # They stay when the included file is over: so it is in launch.
        context.locals.current_launch_file_path = path
        context.locals.current_launch_file_directory = os.path.dirname(path)
        with at(self.place):
            return [*(SetLaunchConfiguration(*pair) for pair in self._arguments), description]

    def sub_entities(self) -> Iterable[Any]:
        """Return the entities of the file, without the arguments that are given here."""
        path = ""
        with contextlib.suppress(Exception):  # Not known yet, or wrong: the evaluation will tell.
            nothing = LaunchContext()
            path, description = self._source.load(nothing)
            given = {perform(nothing, name) for name, _ in self._arguments}
        if not path or path in _entered:
            return
        _entered.append(path)
        for entity in description.entities:
            if not (isinstance(entity, DeclareLaunchArgument) and entity.name in given):
                yield entity
        _entered.remove(path)


@dataclass(eq=False)
class LogInfo(Action):
    """The action that adds a note of level INFO, for the person who launches."""

    _: KW_ONLY
    msg: Text

    def execute(self, context: LaunchContext) -> None:
        context.note(self.place, perform(context, self.msg), "INFO")


@dataclass(eq=False)
class OpaqueFunction(Action):
    """The action that calls a function with the context, and performs the actions it returns."""

    _: KW_ONLY
    function: Callable[..., Any]
    args: Iterable[Any] | None = None
    kwargs: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not callable(self.function):
            raise TypeError(f"function={self.function!r} cannot be called: give the function")

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        found = self.function(context, *(self.args or ()), **(self.kwargs or {}))
        if found is not None and not isinstance(found, Iterable):
            name = getattr(self.function, "__name__", "function")
            text = f"{name}() of OpaqueFunction returns {type(found).__name__}: return a list"
            raise SubstitutionFailure(text, self.place)
        return found


@dataclass(eq=False)
class TimerAction(Action):
    """The action that performs others later, with the launch configurations that there are then.

    Nothing waits: the evaluation performs them at its end, and gives programs a start delay.
    """

    _: KW_ONLY
    period: Number
    actions: Iterable[Any]
    cancel_on_shutdown: Flag = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self.actions = list(self.actions)

    def execute(self, context: LaunchContext) -> None:
        time, local_values = context.time + number(context, self.period), vars(context.locals)
        delayed = time, len(context.delayed), self.actions, dict(local_values)
        heapq.heappush(context.delayed, delayed)

    def is_conditional(self) -> bool:
        return True

    def sub_entities(self) -> Iterable[Any]:
        return self.actions
