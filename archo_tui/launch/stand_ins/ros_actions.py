"""The actions of `launch_ros.actions`."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import yaml

from archo_tui.launch.stand_ins import packages
from archo_tui.launch.stand_ins.core import (
    Action,
    Condition,
    LaunchContext,
    SkipActionError,
    SomeSubstitutionsType,
    SubstitutionFailure,
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)
from archo_tui.launch.stand_ins.values import (
    Parameter,
    ParameterFile,
    check_typed,
    evaluate_parameters,
    perform_typed,
)
from archo_tui.nearest import nearest_hint

__all__ = [
    "LifecycleNode",
    "Node",
    "PushROSNamespace",
    "PushRosNamespace",
    "SetParameter",
    "SetParametersFromFile",
    "SetRemap",
]

# Names of nodes and of the parts of namespaces (https://design.ros2.org/articles/topic_and_service_names.html).
_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NAMES_OF_LISTS = {  # The launch configurations that hold what all nodes of a scope get.
    "parameters": "global_params",
    "remappings": "ros_remaps",
}
# Options of a process that say nothing about what runs, and those that are not followed here.
_SILENT = (
    *("cached_output", "emulate_tty", "exec_name", "log_cmd", "output_format"),
    *("sigkill_timeout", "sigterm_timeout"),
)
_NOT_FOLLOWED = ("cwd", "on_exit", "prefix", "respawn_max_retries", "shell")


class Node(Action):
    """The action that adds a program to those to start, with notes on options not followed."""

    def __init__(
        self,
        *,
        executable: SomeSubstitutionsType,
        package: SomeSubstitutionsType | None = None,
        name: SomeSubstitutionsType | None = None,
        namespace: SomeSubstitutionsType | None = None,
        parameters: Iterable[Any] | None = None,
        remappings: Iterable[tuple[Any, Any]] | None = None,
        ros_arguments: Iterable[SomeSubstitutionsType] | None = None,
        arguments: Iterable[SomeSubstitutionsType] | None = None,
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None,
        output: SomeSubstitutionsType = "log",
        respawn: bool | SomeSubstitutionsType = False,
        respawn_delay: float | SomeSubstitutionsType | None = 0.0,
        condition: Condition | None = None,
        **options: Any,
    ) -> None:
        super().__init__(condition=condition)
        known = (*_KNOWN_OPTIONS, *_SILENT, *_NOT_FOLLOWED)
        for option in options:
            if option not in known:
                near = nearest_hint(option.removeprefix("node_"), known)
                raise TypeError(f"Node takes no {option}{near}")
        self._ignored = [option for option in _NOT_FOLLOWED if options.get(option)]
        self._package, self._executable = package, executable
        self._name, self._namespace = name, namespace
        self._parameters = list(_checked_parameters(parameters))
        self._remappings = [_checked_remapping(rule) for rule in remappings or ()]
        self._ros_arguments = [normalize_to_list_of_substitutions(a) for a in ros_arguments or ()]
        self._arguments = [normalize_to_list_of_substitutions(a) for a in arguments or ()]
        self._environment = {**(env or {}), **(additional_env or {})}
        self._output = output
        check_typed(respawn, bool)
        self._respawn = respawn
        self._respawn_delay: Any = (
            float(respawn_delay or 0) if _is_number(respawn_delay) else (respawn_delay)
        )
        check_typed(self._respawn_delay, float)

    def execute(self, context: LaunchContext) -> None:
        if self._package is None:
            path = perform(context, self._executable)
            text = f"a Node without package runs {path}, which is not started here"
            raise SkipActionError(text, self.place)
        name = None if self._name is None else perform(context, self._name)
        namespace = _namespace(context, self._namespace)
        self._check_names(name, namespace)
        respawn = bool(perform_typed(context, self._respawn, bool))
        environment = context.changed_environment()
        for key, value in self._environment.items():
            environment[perform(context, key)] = perform(context, value)
        context.programs.append(
            {
                "package": perform(context, self._package),
                "executable": perform(context, self._executable),
                "name": name or "",
                "namespace": namespace or "",
                "ros_args": [*self._ros_args(context, name, namespace)],
                "arguments": [perform_substitutions(context, part) for part in self._arguments],
                "respawn": respawn,
                "respawn_delay": perform_typed(context, self._respawn_delay, float),
                "output": _output(context, self._output),
                "environment": environment,
                "start_delay": context.time,
                "file": self.place.file,
                "line": self.place.line,
            }
        )
        for option in self._ignored:
            context.note(self.place, f"{option} of a Node is not followed here")

    def _check_names(self, name: str | None, namespace: str | None) -> None:
        rule = "letters, digits and _, and no digit first"
        if name is not None and not _TOKEN.fullmatch(name):
            raise SubstitutionFailure(f"name={name!r} is no name of a node: {rule}", self.place)
        tokens = (namespace or "/").removeprefix("/")
        if tokens and not all(_TOKEN.fullmatch(token) for token in tokens.split("/")):
            text = f"namespace={namespace!r} is no namespace: {rule} between /"
            raise SubstitutionFailure(text, self.place)

    def _ros_args(
        self, context: LaunchContext, name: str | None, namespace: str | None
    ) -> Iterator[str]:
        """Yield the words after `--ros-args`, in the order in which launch_ros writes them.

        Some parameters are written to a file for it.
        """
        yield from [perform_substitutions(context, part) for part in self._ros_arguments]
        if name is not None:
            yield from ("-r", f"__node:={name}")
        if namespace is not None:
            yield from ("-r", f"__ns:={namespace}")
        for entry in context.launch_configurations.get(_NAMES_OF_LISTS["parameters"], ()):
            if isinstance(entry, tuple):
                yield from ("-p", f"{entry[0]}:={entry[1]}")
            else:
                yield from self._file_args(context, os.path.abspath(entry))
        both = name is not None and namespace is not None
        full_name = f"{(namespace or '').rstrip('/')}/{name}" if both else ""
        for number, given in enumerate(self._parameters):
            yield from self._parameter_args(context, given, full_name, number)
        shared = context.launch_configurations.get(_NAMES_OF_LISTS["remappings"], ())
        own = [(perform(context, old), perform(context, new)) for old, new in self._remappings]
        for old, new in [*shared, *own]:
            yield from ("-r", f"{old}:={new}")

    def _parameter_args(
        self, context: LaunchContext, given: Any, full_name: str, number: int
    ) -> Iterator[str]:
        """Yield the arguments for an entry of `parameters`; a full name makes a file of them."""
        if isinstance(given, ParameterFile):
            yield from self._file_args(context, given.evaluate(context), given)
            return
        if isinstance(given, Parameter):
            values = dict([given.evaluate(context)])
        else:
            values = evaluate_parameters(context, given)
            if full_name and values:  # launch_ros writes a file then, which has precedence.
                folder = packages.index.prefix / "parameters"
                folder.mkdir(parents=True, exist_ok=True)
                file = folder / f"{len(context.programs)}_{number}.yaml"
                text = yaml.safe_dump({full_name: {"ros__parameters": values}}, sort_keys=False)
                file.write_text(text, encoding="utf-8")
                yield from ("--params-file", str(file))
                return
        for name, value in values.items():
            yield from ("-p", f"{name}:={_in_one_line(value)}")

    def _file_args(
        self, context: LaunchContext, path: str, given: ParameterFile | None = None
    ) -> Iterator[str]:
        """Yield the arguments for a parameter file, or only add a note why it is left out."""
        missing = packages.index.missing_package(path)
        place = self.place if given is None else given.place
        if missing:
            file = os.path.basename(path)
            context.note(place, f"{missing} is not here, so {file} of it is left out")
        elif not os.path.isfile(path):
            why = packages.index.why_missing(path)
            context.note(place, f"parameter file {os.path.basename(path)} is left out: {why}")
        elif given is not None and given.is_substituted(context) and _has_substitutions(path):
            text = f"{os.path.basename(path)} is left out: $(...) in it is not replaced here"
            context.note(place, text)
        else:
            yield from ("--params-file", path)


# The options of Node that have a parameter of their own, for hints.
_KNOWN_OPTIONS = ("executable", *(Node.__init__.__kwdefaults__ or ()))


class LifecycleNode(Node):
    """A Node that must have a name and a namespace; nothing here configures or activates it."""

    def __init__(
        self, *, name: SomeSubstitutionsType, namespace: SomeSubstitutionsType, **options: Any
    ) -> None:
        super().__init__(name=name, namespace=namespace, **options)


class PushROSNamespace(Action):
    """The action that sets or extends the namespace of the nodes that follow in the scope."""

    def __init__(self, namespace: SomeSubstitutionsType, **options: Any) -> None:
        super().__init__(**options)
        self._namespace = normalize_to_list_of_substitutions(namespace)

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations["ros_namespace"] = _namespace(context, self._namespace)


PushRosNamespace = PushROSNamespace


class SetParameter(Action):
    """The action that sets a parameter of all nodes that follow in the scope.

    As in launch_ros, a list becomes the text of a tuple, and the setting outlives its scope if
    there were such settings before.
    """

    def __init__(self, name: SomeSubstitutionsType, value: Any, **options: Any) -> None:
        super().__init__(**options)
        self._name, self._value = normalize_to_list_of_substitutions(name), value

    def execute(self, context: LaunchContext) -> None:
        values = evaluate_parameters(context, {tuple(self._name): self._value})
        for name, value in values.items():
            # launch_ros writes a list as Python's `(1, 2)`, which nodes read as a text.
            written = tuple(value) if isinstance(value, list) else value
            _extend(context, _NAMES_OF_LISTS["parameters"], [(name, written)])


class SetParametersFromFile(Action):
    """The action that gives a parameter file to all nodes that follow; see SetParameter."""

    def __init__(self, filename: SomeSubstitutionsType, **options: Any) -> None:
        super().__init__(**options)
        self._file = normalize_to_list_of_substitutions(filename)

    def execute(self, context: LaunchContext) -> None:
        path = perform_substitutions(context, self._file)
        _extend(context, _NAMES_OF_LISTS["parameters"], [path])


class SetRemap(Action):
    """The action that remaps a name for all nodes that follow; see SetParameter."""

    def __init__(
        self, src: SomeSubstitutionsType, dst: SomeSubstitutionsType, **options: Any
    ) -> None:
        super().__init__(**options)
        self._src = normalize_to_list_of_substitutions(src)
        self._dst = normalize_to_list_of_substitutions(dst)

    def execute(self, context: LaunchContext) -> None:
        src = perform_substitutions(context, self._src)
        dst = perform_substitutions(context, self._dst)
        _extend(context, _NAMES_OF_LISTS["remappings"], [(src, dst)])


def _extend(context: LaunchContext, name: str, entries: Iterable[Any]) -> None:
    """Add entries to a list in the launch configurations.

    As in launch, a scope shares the lists that the scope around it has already: both get the
    entries.
    """
    context.launch_configurations.setdefault(name, []).extend(entries)


def _namespace(context: LaunchContext, given: SomeSubstitutionsType | None) -> str | None:
    """Return the full namespace of a node or scope, with a leading `/`; None if there is none."""
    around: str | None = context.launch_configurations.get("ros_namespace")
    own = None if given is None else perform(context, given)
    if own is None:
        return around
    if around and not own.startswith("/"):
        own = f"{around.rstrip('/')}/{own}"
    own = own if own == "/" else own.rstrip("/")
    return own if own.startswith("/") else f"/{own}"


def _checked_parameters(given: Iterable[Any] | None) -> Iterator[Any]:
    if given is not None and not isinstance(given, list):
        raise TypeError(f"parameters is a list: parameters=[...], not {type(given).__name__}")
    for entry in given or ():
        is_ready = isinstance(entry, (Mapping, Parameter, ParameterFile))
        yield entry if is_ready else ParameterFile(entry)


def _checked_remapping(rule: Any) -> tuple[Any, Any]:
    if not isinstance(rule, tuple) or len(rule) != 2:
        raise TypeError(f"a remapping is a pair in (): ('old', 'new'), not {rule!r}")
    old, new = rule
    return normalize_to_list_of_substitutions(old), normalize_to_list_of_substitutions(new)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, (int, float)) and not isinstance(value, bool))


def _in_one_line(value: Any) -> str:
    """Return a value as one line of YAML 1.1, as launch_ros writes it.

    So the text `1e3` is not quoted, and nodes read it as a number, as on ROS 2.
    """
    text: str = yaml.safe_dump([value], default_flow_style=True, width=10**9, allow_unicode=True)
    return text.strip()[1:-1]


def _output(context: LaunchContext, given: Any) -> str:
    """Return where the output of a program goes: `log`, `screen` or `both`."""
    if isinstance(given, Mapping):
        words = {perform(context, word) for word in given.values()}
        return "both" if {"both"} & words or len(words) > 1 else "".join(words)
    return perform(context, given)


def _has_substitutions(path: str) -> bool:
    with open(path, encoding="utf-8", errors="replace") as file:
        return "$(" in file.read()
