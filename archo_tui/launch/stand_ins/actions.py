"""The actions of `launch.actions`."""

from __future__ import annotations

import contextlib
import heapq
import os
from collections.abc import Callable, Iterable, Mapping, MutableMapping
from operator import attrgetter
from typing import Any

from archo_tui.launch.stand_ins.core import (
    Action,
    Condition,
    Delayed,
    LaunchContext,
    LaunchDescription,
    SomeSubstitutionsType,
    SubstitutionFailure,
    declared_arguments,
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)
from archo_tui.launch.stand_ins.sources import (
    AnyLaunchDescriptionSource,
    PythonLaunchDescriptionSource,
)
from archo_tui.launch.stand_ins.values import check_typed, perform_typed
from archo_tui.nearest import nearest_hint

__all__ = [
    "AppendEnvironmentVariable",
    "DeclareLaunchArgument",
    "GroupAction",
    "IncludeLaunchDescription",
    "LogInfo",
    "OpaqueFunction",
    "PopEnvironment",
    "PopLaunchConfigurations",
    "PushEnvironment",
    "PushLaunchConfigurations",
    "ResetEnvironment",
    "ResetLaunchConfigurations",
    "SetEnvironmentVariable",
    "SetLaunchConfiguration",
    "TimerAction",
    "UnsetEnvironmentVariable",
    "UnsetLaunchConfiguration",
]


_MAX_DEPTH = 10  # Files that include one file again, which only a condition ends.
_walked: list[str] = []  # The included files in which arguments are looked for.


class DeclareLaunchArgument(Action):
    """The action that declares an argument of the launch file, and sets its default if need be.

    SubstitutionFailure is raised without a value or a default, and for one that is not among the
    choices.
    """

    declares_argument = True

    def __init__(
        self,
        name: str,
        *,
        default_value: SomeSubstitutionsType | None = None,
        description: str | None = None,
        choices: Iterable[str] | None = None,
        condition: Condition | None = None,
    ) -> None:
        super().__init__(condition=condition)
        self.name, self.description = name, description or ""
        self.choices = None if choices is None else list(choices)
        self.default_value = (
            None if default_value is None else normalize_to_list_of_substitutions(default_value)
        )
        if self.choices is not None and isinstance(default_value, str):
            self._check(default_value)

    def execute(self, context: LaunchContext) -> None:
        if self.name not in context.launch_configurations:
            if self.default_value is None:
                raise SubstitutionFailure(self.missing_text(), self.place)
            value = perform_substitutions(context, self.default_value)
            context.launch_configurations[self.name] = value
        self._check(context.launch_configurations[self.name])

    def missing_text(self) -> str:
        about = f" ({self.description})" if self.description else ""
        return f"argument {self.name}{about} has no value: give {self.name}:=VALUE"

    def _check(self, value: str) -> None:
        if self.choices is not None and value not in self.choices:
            wanted = f"one of {', '.join(map(str, self.choices))}"
            near = nearest_hint(value, map(str, self.choices))
            text = f"argument {self.name} is {value!r}: {wanted} is wanted{near}"
            raise SubstitutionFailure(text, self.place)


class _SetVariable(Action):
    """The base of the actions that set a launch configuration or an environment variable."""

    _variables: Callable[[LaunchContext], MutableMapping[str, str]]  # Of a context.

    def __init__(
        self, name: SomeSubstitutionsType, value: SomeSubstitutionsType, **options: Any
    ) -> None:
        super().__init__(**options)
        self._name = normalize_to_list_of_substitutions(name)
        self._value = normalize_to_list_of_substitutions(value)

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self._name)
        self._variables(context)[name] = perform_substitutions(context, self._value)


class _UnsetVariable(Action):
    """The base of the actions that remove a launch configuration or an environment variable."""

    _variables: Callable[[LaunchContext], MutableMapping[str, str]]  # Of a context.

    def __init__(self, name: SomeSubstitutionsType, **options: Any) -> None:
        super().__init__(**options)
        self._name = normalize_to_list_of_substitutions(name)

    def execute(self, context: LaunchContext) -> None:
        self._variables(context).pop(perform_substitutions(context, self._name), None)


class SetLaunchConfiguration(_SetVariable):
    """The action that sets a launch configuration, until the scope ends."""

    _variables = attrgetter("launch_configurations")


class UnsetLaunchConfiguration(_UnsetVariable):
    """The action that removes a launch configuration, until the scope ends."""

    _variables = attrgetter("launch_configurations")


class ResetLaunchConfigurations(Action):
    """The action that replaces all launch configurations by those given, by default by none."""

    resets_arguments = True

    def __init__(
        self, launch_configurations: Mapping[Any, Any] | None = None, **options: Any
    ) -> None:
        super().__init__(**options)
        self._kept = dict(launch_configurations or {})

    def execute(self, context: LaunchContext) -> None:
        kept = {perform(context, k): perform(context, v) for k, v in self._kept.items()}
        context.launch_configurations.clear()
        context.launch_configurations.update(kept)


class PushLaunchConfigurations(Action):
    """The action that begins a scope of launch configurations, with a copy of those around it."""

    def execute(self, context: LaunchContext) -> None:
        context.push_configurations()


class PopLaunchConfigurations(Action):
    """The action that ends a scope of launch configurations, and restores those before it."""

    def execute(self, context: LaunchContext) -> None:
        context.pop_configurations()


class PushEnvironment(Action):
    """The action that begins a scope of environment variables, with a copy of those around it."""

    def execute(self, context: LaunchContext) -> None:
        context.push_environment()


class PopEnvironment(Action):
    """The action that ends a scope of environment variables, and restores those before it."""

    def execute(self, context: LaunchContext) -> None:
        context.pop_environment()


class ResetEnvironment(Action):
    """The action that restores, in its scope, the environment variables of the launch's start."""

    def execute(self, context: LaunchContext) -> None:
        context.reset_environment()


class SetEnvironmentVariable(_SetVariable):
    """The action that sets an environment variable, until the scope ends."""

    _variables = attrgetter("environment")


class UnsetEnvironmentVariable(_UnsetVariable):
    """The action that removes an environment variable, until the scope ends."""

    _variables = attrgetter("environment")


class AppendEnvironmentVariable(Action):
    """The action that appends to an environment variable, or with `prepend` puts before it."""

    def __init__(
        self,
        name: SomeSubstitutionsType,
        value: SomeSubstitutionsType,
        prepend: bool | SomeSubstitutionsType = False,
        separator: SomeSubstitutionsType = os.pathsep,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self._name = normalize_to_list_of_substitutions(name)
        self._value = normalize_to_list_of_substitutions(value)
        self._separator = normalize_to_list_of_substitutions(separator)
        check_typed(prepend, bool)
        self._prepend = prepend

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self._name)
        parts = [perform_substitutions(context, self._value)]
        if name in context.environment:
            is_first = perform_typed(context, self._prepend, bool)
            parts.insert(len(parts) if is_first else 0, context.environment[name])
        context.environment[name] = perform_substitutions(context, self._separator).join(parts)


class GroupAction(Action):
    """The action that performs several actions, in a scope of their own unless `scoped` is false.

    If `forwarding` is false, the scope has only the given launch configurations, and the
    environment of the start.
    """

    def __init__(
        self,
        actions: Iterable[Any],
        *,
        scoped: bool = True,
        forwarding: bool = True,
        launch_configurations: Mapping[Any, Any] | None = None,
        condition: Condition | None = None,
    ) -> None:
        super().__init__(condition=condition)
        self._actions = list(actions)
        self._scoped, self._forwarding = scoped, forwarding
        self._configurations = dict(launch_configurations or {})

    def execute(self, context: LaunchContext) -> list[Any]:
        sets = [SetLaunchConfiguration(k, v) for k, v in self._configurations.items()]
        if not self._scoped:
            return [*sets, *self._actions]
        cleared = [ResetEnvironment(), ResetLaunchConfigurations(self._configurations)]
        begin = [PushLaunchConfigurations(), PushEnvironment()]
        inside = [*(sets if self._forwarding else cleared), *self._actions]
        return [*begin, *inside, PopEnvironment(), PopLaunchConfigurations()]

    def sub_entities(self) -> Iterable[Any]:
        return self._actions


class IncludeLaunchDescription(Action):
    """The action that sets the given arguments, and performs everything in another launch file.

    The arguments and ThisLaunchFile keep the values of the included file afterwards, as in launch.
    """

    def __init__(
        self,
        launch_description_source: PythonLaunchDescriptionSource | SomeSubstitutionsType,
        *,
        launch_arguments: Iterable[tuple[Any, Any]] | None = None,
        condition: Condition | None = None,
    ) -> None:
        super().__init__(condition=condition)
        source = launch_description_source
        is_source = hasattr(source, "load")
        self._source: Any = source if is_source else AnyLaunchDescriptionSource(source)
        if isinstance(launch_arguments, Mapping):
            raise TypeError("launch_arguments is a mapping: write {...}.items()")
        # Looked at when it is executed, as in launch: a condition may leave a wrong one out.
        self._arguments = list(launch_arguments or ())

    def execute(self, context: LaunchContext) -> list[Any]:
        path, description = self._source.load(context)
        if context.including.count(path) >= _MAX_DEPTH:
            first = context.including.index(path)
            second = context.including.index(path, first + 1)
            circle = map(os.path.basename, context.including[first : second + 1])
            text = "these launch files include each other without end"
            raise SubstitutionFailure(f"{text}: {' > '.join(circle)}", self.place)
        context.including.append(path)
        # They stay when the included file is over: so it is in launch.
        context.locals.current_launch_file_path = path
        context.locals.current_launch_file_directory = os.path.dirname(path)
        given = self._names(context)
        for declared in declared_arguments(description.entities):
            names = {*given, *declared.given}
            if declared.is_required and declared.argument.name not in names:
                text = f"{os.path.basename(path)}: argument {declared.argument.name} has no value"
                hint = f"give it in launch_arguments, {{'{declared.argument.name}': ...}}.items()"
                raise SubstitutionFailure(f"{text}: {hint}", self.place)
        return [*(SetLaunchConfiguration(k, v) for k, v in self._arguments), description]

    def _names(self, context: LaunchContext) -> set[str]:
        return {perform(context, name) for name, _ in self._arguments}

    def sub_entities(self) -> Iterable[Any]:
        found: tuple[str, LaunchDescription] | None = None
        with contextlib.suppress(Exception):  # Not known yet, or wrong: the evaluation will tell.
            found = self._source.load(LaunchContext())
        if found is not None and found[0] not in _walked:
            _walked.append(found[0])
            try:
                yield from found[1].entities
            finally:
                _walked.remove(found[0])

    def given_names(self) -> set[str]:
        with contextlib.suppress(Exception):
            return self._names(LaunchContext())
        return set()


class LogInfo(Action):
    """The action that adds a note of level INFO, for the person who launches."""

    def __init__(self, *, msg: SomeSubstitutionsType, condition: Condition | None = None) -> None:
        super().__init__(condition=condition)
        self._msg = normalize_to_list_of_substitutions(msg)

    def execute(self, context: LaunchContext) -> None:
        context.note(self.place, perform_substitutions(context, self._msg), "INFO")


class OpaqueFunction(Action):
    """The action that calls a function with the context, and performs the actions it returns."""

    def __init__(
        self,
        *,
        function: Callable[..., Any],
        args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None,
        condition: Condition | None = None,
    ) -> None:
        super().__init__(condition=condition)
        if not callable(function):
            raise TypeError(f"function={function!r} cannot be called: give the function itself")
        self._function, self._args, self._kwargs = function, args or (), kwargs or {}

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        found = self._function(context, *self._args, **self._kwargs)
        if found is not None and not isinstance(found, Iterable):
            name = getattr(self._function, "__name__", "function")
            text = f"{name}() of OpaqueFunction returns {type(found).__name__}: return a list"
            raise SubstitutionFailure(text, self.place)
        return found


class TimerAction(Action):
    """The action that performs others later, with the launch configurations that there are then.

    Nothing waits: the evaluation performs them at its end, and gives programs a start delay.
    """

    def __init__(
        self,
        *,
        period: float | SomeSubstitutionsType,
        actions: Iterable[Any],
        cancel_on_shutdown: bool | SomeSubstitutionsType = True,
        condition: Condition | None = None,
    ) -> None:
        super().__init__(condition=condition)
        self._period = float(period) if isinstance(period, (str, int)) else period
        check_typed(self._period, float)
        self._actions = list(actions)
        self.is_conditional = True

    def execute(self, context: LaunchContext) -> None:
        time = context.time + perform_typed(context, self._period, float)
        number = len(context.delayed)
        delayed = Delayed(time, number, self._actions, dict(vars(context.locals)))
        heapq.heappush(context.delayed, delayed)

    def sub_entities(self) -> Iterable[Any]:
        return self._actions
