"""The actions and conditions of launch, and the files that a launch file includes."""

from __future__ import annotations

import contextlib
import heapq
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from archo_tui.base import regular_files
from archo_tui.base.nearest import nearest_hint
from archo_tui.user_code.ros_launch.stand_ins import packages
from archo_tui.user_code.ros_launch.stand_ins.core import (
    Action,
    Condition,
    LaunchContext,
    LaunchDescription,
    Made,
    Place,
    SkipActionError,
    SubstitutionFailure,
    Text,
    at,
    flag,
    number,
    perform,
    performed,
    visit,
)

_GENERATE = "generate_launch_description"

# The files that this process has begun to load, by their paths; errors in them are told of them.
loaded: dict[str, LaunchDescription | None] = {}
# Of XML and YAML, by the ends of names: those of `markup`, which needs the actions here.
loaders: dict[str, Callable[[str], LaunchDescription]] = {}


@dataclass(eq=False)
class IfCondition(Condition):
    """The condition that an expression is `true` or `1`; it does not hold for `false` or `0`."""

    predicate_expression: Text

    def evaluate(self, context: LaunchContext) -> bool:
        text = perform(context, self.predicate_expression).strip().lower()
        if text not in ("true", "1", "false", "0"):
            wanted = "true, 1, false or 0 is wanted"
            raise SubstitutionFailure(f"a condition is {text!r}: {wanted}", self.place)
        return text in ("true", "1")


class UnlessCondition(IfCondition):
    """The opposite of IfCondition: it holds for `false` and `0`."""

    def evaluate(self, context: LaunchContext) -> bool:
        return not super().evaluate(context)


@dataclass(eq=False)
class LaunchConfigurationEquals(Condition):
    """The condition that a launch configuration has a value; for None, that it is not set."""

    launch_configuration_name: str
    expected_value: Text | None

    def evaluate(self, context: LaunchContext) -> bool:
        name, wanted = self.launch_configuration_name, self.expected_value
        context.read.add(name)
        expected = None if wanted is None else perform(context, wanted)
        return bool(context.launch_configurations.get(name) == expected)


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """The opposite of LaunchConfigurationEquals; for None, that a launch configuration is set."""

    def evaluate(self, context: LaunchContext) -> bool:
        return not super().evaluate(context)


@dataclass(eq=False)
class DeclareLaunchArgument(Action):
    """The action that declares an argument of the launch file, and sets its default if need be."""

    name: str
    _: KW_ONLY
    default_value: Text | None = None
    description: str | None = None
    choices: Iterable[str] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.choices = None if self.choices is None else [*map(str, self.choices)]

    def execute(self, context: LaunchContext) -> None:
        if self.name not in context.launch_configurations:
            if self.default_value is None:
                about = f" ({self.description})" if self.description else ""
                text = f"argument {self.name}{about} has no value: give {self.name}:=VALUE"
                raise SubstitutionFailure(text, self.place)
            value = perform(context, self.default_value)
            context.launch_configurations[self.name] = value
        value = context.launch_configurations[self.name]
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
    prepend: Any = False
    separator: Text = os.pathsep

    def execute(self, context: LaunchContext) -> None:
        name, added = perform(context, self.name), perform(context, self.value)
        parts = [context.environment[name], added] if name in context.environment else [added]
        order = -1 if flag(context, self.prepend) else 1
        context.environment[name] = perform(context, self.separator).join(parts[::order])


@dataclass(eq=False)
class GroupAction(Action):
    """The action that performs several actions, in a scope of their own unless `scoped` is false.

    If `forwarding` is false, the scope has only the given launch configurations, and the
    environment of the start.
    """

    actions: Iterable[Any]
    _: KW_ONLY
    scoped: Any = True
    forwarding: Any = True
    launch_configurations: Mapping[Any, Any] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.actions = list(self.actions)

    def execute(self, context: LaunchContext) -> Iterable[Any]:
        given = performed(context, self.launch_configurations)
        if not flag(context, self.scoped):
            context.launch_configurations.update(given)
            return self.actions
        with context.scope():
            if not flag(context, self.forwarding):
                context.launch_configurations, context.environment = {}, dict(os.environ)
            context.launch_configurations.update(given)
            for action in self.actions:
                visit(action, context, self.place)
        return ()

    def sub_entities(self) -> Iterable[Any]:
        return self.actions


@dataclass(eq=False)
class TimerAction(Action):
    """The action that performs others later, with the launch configurations that there are then.

    Nothing waits: the evaluation performs them at its end, and gives programs a start delay.
    """

    _: KW_ONLY
    period: Any
    actions: Iterable[Any]
    cancel_on_shutdown: Any = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self.actions = list(self.actions)

    def execute(self, context: LaunchContext) -> None:
        time, turn = context.time + number(context, self.period), len(context.delayed)
        heapq.heappush(context.delayed, (time, turn, self.actions, context.launch_file))

    def sub_entities(self) -> Iterable[Any]:
        return self.actions


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

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        found: Iterable[Any] | None
        found = self.function(context, *(self.args or ()), **(self.kwargs or {}))
        return found


@dataclass(eq=False)
class AnyLaunchDescriptionSource(Made):
    """A launch file in Python, XML or YAML that another launch file includes."""

    launch_file_path: Text

    _is_python = False  # Known by the end of the name.

    def load(self, context: LaunchContext) -> tuple[str, LaunchDescription]:
        """Return the path of the file, and what it describes."""
        path = os.path.abspath(perform(context, self.launch_file_path))
        missing, name = packages.index.missing_package(path), os.path.basename(path)
        if missing:
            raise SkipActionError(f"{missing} is not here: start its {name} with ROS 2")
        if not os.path.isfile(path):
            raise SubstitutionFailure(packages.index.why_missing(path), self.place)
        return path, load_launch_file(path, self._is_python)


class PythonLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in Python that another launch file includes."""

    _is_python = True


class FrontendLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in XML or YAML that another launch file includes."""


class XMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A launch file in XML that another launch file includes."""


class YAMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A launch file in YAML that another launch file includes."""


def load_launch_file(path: str, is_python: bool = False) -> LaunchDescription:
    """Run or read a launch file, unless that is done, and return what it describes."""
    load = _run if is_python else loaders.get(os.path.splitext(path)[1], _run)
    found = loaded.setdefault(path, None) or load(path)
    loaded[path] = found
    return found


def _run(path: str) -> LaunchDescription:
    module = ModuleType("python_launch_file")
    module.__file__ = path
    exec(compile(regular_files.read(Path(path)), path, "exec", dont_inherit=True), vars(module))
    generate: Any = vars(module).get(_GENERATE)
    if not callable(generate):
        raise SubstitutionFailure(f"it has no function {_GENERATE}()", Place(path, 1))
    description = generate()
    if not isinstance(description, LaunchDescription):
        line = getattr(getattr(generate, "__code__", None), "co_firstlineno", 1)
        text = f"{_GENERATE}() returns no LaunchDescription: end it with return LaunchDescription(["
        raise SubstitutionFailure(f"{text}...])", Place(path, line))
    return description


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
        context.launch_file, description = self._source.load(context)
        with at(self.place):  # Each by itself: one that cannot be performed is left out alone.
            return [*(SetLaunchConfiguration(*pair) for pair in self._arguments), description]

    def sub_entities(self) -> Iterable[Any]:
        """Return the entities of the file, without the arguments that are given here."""
        path = ""
        with contextlib.suppress(Exception):  # Not known yet, or wrong: the evaluation will tell.
            nothing = LaunchContext()
            path, description = self._source.load(nothing)
            given = {perform(nothing, name) for name, _ in self._arguments}
        if not path or path in _listed:
            return
        _listed.append(path)
        for entity in description.entities:
            if not (isinstance(entity, DeclareLaunchArgument) and entity.name in given):
                yield entity
        _listed.remove(path)


_listed: list[str] = []  # The included files in which arguments are looked for.
