"""The actions of `launch_ros.actions`, and the parameters that they give."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from archo_tui.base.errors import ArchoError
from archo_tui.user_code.ros_launch.stand_ins import packages
from archo_tui.user_code.ros_launch.stand_ins.core import (
    Action,
    LaunchContext,
    Made,
    Place,
    SkipActionError,
    SubstitutionFailure,
    Text,
    Texts,
    flag,
    normalize_to_list_of_substitutions,
    number,
    perform,
    performed,
    value_of,
)

# The launch configurations that hold what all nodes of a scope get.
_NAMESPACE, _PARAMETERS, _REMAPPINGS = "ros_namespace", "global_params", "ros_remaps"
_NOT_FOLLOWED = ("cwd", "on_exit", "prefix", "respawn_max_retries", "shell")


@dataclass(eq=False)
class ParameterValue(Made):
    """The value of a parameter, and the type that its text is to become.

    Without a type, the text of a substitution is read as YAML 1.1; a plain text stays one.
    """

    value: Any
    _: KW_ONLY
    value_type: Any = None

    def evaluate(self, context: LaunchContext) -> Any:
        """Return the value with its substitutions performed; raise SubstitutionFailure."""
        try:
            return value_of(context, self.value, self.value_type)
        except ValueError as error:
            raise SubstitutionFailure(error, self.place) from None


class Parameter(ParameterValue):
    """A parameter by its name and value, and the type that its text is to become."""

    def __init__(self, name: Text, value: Any, *, value_type: Any = None) -> None:
        super().__init__(value, value_type=value_type)
        self.name = normalize_to_list_of_substitutions(name)


@dataclass(eq=False)
class ParameterFile(Made):
    """A parameter file; `allow_substs` tells that `$(var name)` in it is to be replaced."""

    param_file: Text
    _: KW_ONLY
    allow_substs: Any = False


@dataclass(eq=False)
class Node(Action):
    """The action that adds a program to those to start, with notes on options not followed."""

    _: KW_ONLY
    executable: Text
    package: Text | None = None
    name: Text | None = None
    namespace: Text | None = None
    parameters: list[Any] | None = None
    remappings: Any = None
    ros_arguments: Texts | None = None
    arguments: Texts | None = None
    env: Mapping[Any, Any] | None = None
    additional_env: Mapping[Any, Any] | None = None
    respawn: Any = False
    respawn_delay: Any = None
    # Not followed here.
    cwd: Any = None
    on_exit: Any = None
    prefix: Any = None
    respawn_max_retries: Any = None
    shell: Any = None
    # They say nothing about what runs.
    cached_output: Any = None
    emulate_tty: Any = None
    exec_name: Any = None
    log_cmd: Any = None
    output: Any = None
    output_format: Any = None
    sigkill_timeout: Any = None
    sigterm_timeout: Any = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.parameters, (list, type(None))):
            kind = type(self.parameters).__name__
            raise TypeError(f"parameters is a list: parameters=[...], not {kind}")
        self.remappings = list(self.remappings or ())
        for rule in self.remappings:
            if not isinstance(rule, tuple) or len(rule) != 2:
                raise TypeError(f"a remapping is a pair in (): ('old', 'new'), not {rule!r}")

    def execute(self, context: LaunchContext) -> None:
        executable = perform(context, self.executable)
        if self.package is None:
            text = f"a Node without package runs {executable}, which is not started here"
            raise SkipActionError(text)
        package = perform(context, self.package)
        name = None if self.name is None else perform(context, self.name)
        namespace = _namespace(context, self.namespace)
        environment = context.changed_environment()
        environment.update(performed(context, self.env) | performed(context, self.additional_env))
        program = {
            "package": package,
            "executable": executable,
            "name": name or "",
            "namespace": namespace or "",
            "ros_args": [*self._ros_args(context, name, namespace)],
            "arguments": [perform(context, part) for part in self.arguments or ()],
            "respawn": flag(context, self.respawn),
            "respawn_delay": number(context, self.respawn_delay or 0.0),
            "environment": environment,
            "start_delay": context.time,
            "file": os.path.realpath(self.place.file),  # Share folders have links.
            "line": self.place.line,
        }
        try:
            entry_point = packages.index.workspaces[0].entry_point(package, executable)
        except ArchoError as error:
            raise SkipActionError(str(error)) from None
        context.programs.append({**program, "entry_point": asdict(entry_point)})
        for option in _NOT_FOLLOWED:
            if getattr(self, option):
                context.note(self.place, f"{option} of a Node is not followed here")

    def _ros_args(
        self, context: LaunchContext, name: str | None, namespace: str | None
    ) -> Iterator[str]:
        """Yield the words after `--ros-args`, in the order in which launch_ros writes them."""
        yield from [perform(context, part) for part in self.ros_arguments or ()]
        if name is not None:
            yield from ("-r", f"__node:={name}")
        if namespace is not None:
            yield from ("-r", f"__ns:={namespace}")
        for entry in context.launch_configurations.get(_PARAMETERS, ()):
            if isinstance(entry, tuple):
                yield from ("-p", f"{entry[0]}:={entry[1]}")
            else:
                yield from _file_args(context, entry, self.place)
        full_name = "" if name is None or namespace is None else f"{namespace.rstrip('/')}/{name}"
        for place, given in enumerate(self.parameters or []):
            if isinstance(given, ParameterFile):
                has_substitutions = flag(context, given.allow_substs)
                path = perform(context, given.param_file)
                yield from _file_args(context, path, given.place, has_substitutions)
            elif isinstance(given, Parameter):
                yield from _value_args(evaluate_parameters(context, {tuple(given.name): given}))
            elif not isinstance(given, Mapping):
                yield from _file_args(context, perform(context, given), self.place)
            elif (values := evaluate_parameters(context, given)) and full_name:
                # launch_ros writes a file, which has precedence over `-p`.
                folder = packages.index.prefix / "parameters"
                folder.mkdir(parents=True, exist_ok=True)
                file = folder / f"{len(context.programs)}_{place}.yaml"
                text = yaml.safe_dump({full_name: {"ros__parameters": values}}, sort_keys=False)
                file.write_text(text, encoding="utf-8")
                yield from ("--params-file", str(file))
            else:
                yield from _value_args(values)
        shared = context.launch_configurations.get(_REMAPPINGS, ())
        own = [(perform(context, old), perform(context, new)) for old, new in self.remappings]
        for old, new in [*shared, *own]:
            yield from ("-r", f"{old}:={new}")


class LifecycleNode(Node):
    """A managed node, which nothing here configures or activates."""


def _value_args(values: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        # One line of YAML 1.1, as launch_ros writes it: so nodes read the text `1e3`, which it does
        # not quote, as a number, as on ROS 2.
        text = yaml.safe_dump([value], default_flow_style=True, width=10**9, allow_unicode=True)
        yield from ("-p", f"{name}:={text.strip()[1:-1]}")


def _file_args(
    context: LaunchContext, given: str, place: Place, has_substitutions: bool = False
) -> Iterator[str]:
    """Yield the arguments for a parameter file, or only add a note why it is left out."""
    path, name = os.path.abspath(given), os.path.basename(given)
    missing = packages.index.missing_package(path)
    if missing:
        context.note(place, f"{missing} is not here, so {name} of it is left out")
    elif not os.path.isfile(path):
        why = packages.index.why_missing(path)
        context.note(place, f"parameter file {name} is left out: {why}")
    elif has_substitutions and b"$(" in Path(path).read_bytes():
        context.note(place, f"{name} is left out: $(...) in it is not replaced here")
    else:
        yield from ("--params-file", path)


def evaluate_parameters(
    context: LaunchContext, given: Mapping[Any, Any], prefix: str = ""
) -> dict[str, Any]:
    """Return the parameters of a mapping by their full names: `{"pid": {"p": 1}}` is `pid.p`."""
    found: dict[str, Any] = {}
    for key, value in given.items():
        name = prefix + perform(context, key)
        if isinstance(value, Mapping):
            found |= evaluate_parameters(context, value, f"{name}.")
        elif isinstance(value, ParameterValue):
            found[name] = value.evaluate(context)
        else:
            try:
                found[name] = value_of(context, value)
            except ValueError as error:
                hint = "is a text meant? ParameterValue(..., value_type=str)"
                raise TypeError(f"parameter {name}: {error}: {hint}") from None
            if found[name] == []:
                raise TypeError(f"parameter {name}: the list [] is empty, so its type is not known")
    return found


@dataclass(eq=False)
class PushROSNamespace(Action):
    """The action that puts the nodes that follow in the scope into a namespace."""

    namespace: Text

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations[_NAMESPACE] = _namespace(context, self.namespace)


PushRosNamespace = PushROSNamespace


def _namespace(context: LaunchContext, given: Text | None) -> str | None:
    """Return the full namespace of a node or scope, with a leading `/`; None if there is none."""
    around: str | None = context.launch_configurations.get(_NAMESPACE)
    if given is None:
        return around
    own = perform(context, given)
    if around and not own.startswith("/"):
        own = f"{around.rstrip('/')}/{own}"
    return f"/{own.strip('/')}"


@dataclass(eq=False)
class SetParameter(Action):
    """The action that sets a parameter of all nodes that follow in the scope."""

    name: Text
    value: Any

    def execute(self, context: LaunchContext) -> None:
        for name, value in evaluate_parameters(context, {tuple(self.name): self.value}).items():
            # launch_ros writes a list as Python's `(1, 2)`, which nodes read as a text.
            written = tuple(value) if isinstance(value, list) else value
            _append(context, _PARAMETERS, (name, written))


@dataclass(eq=False)
class SetParametersFromFile(Action):
    """The action that gives a parameter file to all nodes that follow in the scope."""

    filename: Text

    def execute(self, context: LaunchContext) -> None:
        _append(context, _PARAMETERS, perform(context, self.filename))


@dataclass(eq=False)
class SetRemap(Action):
    """The action that remaps a name for all nodes that follow in the scope."""

    src: Text
    dst: Text

    def execute(self, context: LaunchContext) -> None:
        _append(context, _REMAPPINGS, (perform(context, self.src), perform(context, self.dst)))


def _append(context: LaunchContext, name: str, entry: Any) -> None:
    """Add an entry to a list, which a scope shares with the one around it, as in launch."""
    context.launch_configurations.setdefault(name, []).append(entry)
