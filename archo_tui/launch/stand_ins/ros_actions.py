"""The actions of `launch_ros.actions`."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, asdict, dataclass
from typing import Any

import yaml

from archo_tui.errors import ArchoError
from archo_tui.launch.stand_ins import packages
from archo_tui.launch.stand_ins.core import (
    Action,
    Flag,
    LaunchContext,
    Number,
    SkipActionError,
    SubstitutionFailure,
    Text,
    Texts,
    at,
    perform,
)
from archo_tui.launch.stand_ins.values import (
    Parameter,
    ParameterFile,
    evaluate_parameters,
    flag,
    number,
)

# Names of nodes and of the parts of namespaces (https://design.ros2.org/articles/topic_and_service_names.html).
_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# The launch configurations that hold what all nodes of a scope get.
_NAMESPACE, _PARAMETERS, _REMAPPINGS = "ros_namespace", "global_params", "ros_remaps"
_NOT_FOLLOWED = ("cwd", "on_exit", "prefix", "respawn_max_retries", "shell")


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
    output: Any = "log"
    respawn: Flag = False
    respawn_delay: Number | None = None
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
    output_format: Any = None
    sigkill_timeout: Any = None
    sigterm_timeout: Any = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.parameters, (list, type(None))):
            kind = type(self.parameters).__name__
            raise TypeError(f"parameters is a list: parameters=[...], not {kind}")
        ready = (Mapping, Parameter, ParameterFile)
        self.parameters = [
            entry if isinstance(entry, ready) else ParameterFile(entry)
            for entry in self.parameters or ()
        ]
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
        self._check_names(name, namespace)
        environment = context.changed_environment()
        for key, value in {**(self.env or {}), **(self.additional_env or {})}.items():
            environment[perform(context, key)] = perform(context, value)
        program = {
            "package": package,
            "executable": executable,
            "name": name or "",
            "namespace": namespace or "",
            "ros_args": [*self._ros_args(context, name, namespace)],
            "arguments": [perform(context, part) for part in self.arguments or ()],
            "respawn": flag(context, self.respawn),
            "respawn_delay": number(context, self.respawn_delay or 0.0),
            "output": _output(context, self.output),
            "environment": environment,
            "start_delay": context.time,
            "file": os.path.realpath(self.place.file),  # Share folders have links.
            "line": self.place.line,
        }
        try:
            entry_point = packages.index.workspace.entry_point(package, executable)
        except ArchoError as error:
            raise SkipActionError(str(error)) from None
        context.programs.append({**program, "entry_point": asdict(entry_point)})
        for option in _NOT_FOLLOWED:
            if getattr(self, option):
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
        yield from [perform(context, part) for part in self.ros_arguments or ()]
        if name is not None:
            yield from ("-r", f"__node:={name}")
        if namespace is not None:
            yield from ("-r", f"__ns:={namespace}")
        for entry in context.launch_configurations.get(_PARAMETERS, ()):
            if isinstance(entry, tuple):
                yield from ("-p", f"{entry[0]}:={entry[1]}")
            else:
                with at(self.place):
                    file = ParameterFile(entry)
                yield from self._file_args(context, file)
        both = name is not None and namespace is not None
        full_name = f"{(namespace or '').rstrip('/')}/{name}" if both else ""
        for place, given in enumerate(self.parameters or []):
            yield from self._parameter_args(context, given, full_name, place)
        shared = context.launch_configurations.get(_REMAPPINGS, ())
        own = [(perform(context, old), perform(context, new)) for old, new in self.remappings]
        for old, new in [*shared, *own]:
            yield from ("-r", f"{old}:={new}")

    def _parameter_args(
        self, context: LaunchContext, given: Any, full_name: str, place: int
    ) -> Iterator[str]:
        """Yield the arguments for an entry of `parameters`; a full name makes a file of them."""
        if isinstance(given, ParameterFile):
            yield from self._file_args(context, given)
            return
        is_one = isinstance(given, Parameter)
        values = evaluate_parameters(context, {tuple(given.name): given} if is_one else given)
        if full_name and values and not is_one:  # launch_ros writes a file, which has precedence.
            folder = packages.index.prefix / "parameters"
            folder.mkdir(parents=True, exist_ok=True)
            file = folder / f"{len(context.programs)}_{place}.yaml"
            text = yaml.safe_dump({full_name: {"ros__parameters": values}}, sort_keys=False)
            file.write_text(text, encoding="utf-8")
            yield from ("--params-file", str(file))
            return
        for name, value in values.items():
            yield from ("-p", f"{name}:={_in_one_line(value)}")

    def _file_args(self, context: LaunchContext, given: ParameterFile) -> Iterator[str]:
        """Yield the arguments for a parameter file, or only add a note why it is left out."""
        path = given.evaluate(context)
        missing, name = packages.index.missing_package(path), os.path.basename(path)
        if missing:
            context.note(given.place, f"{missing} is not here, so {name} of it is left out")
        elif not os.path.isfile(path):
            why = packages.index.why_missing(path)
            context.note(given.place, f"parameter file {name} is left out: {why}")
        elif flag(context, given.allow_substs) and _has_substitutions(path):
            context.note(given.place, f"{name} is left out: $(...) in it is not replaced here")
        else:
            yield from ("--params-file", path)


class LifecycleNode(Node):
    """A managed node, which nothing here configures or activates."""


@dataclass(eq=False)
class PushROSNamespace(Action):
    """The action that sets or extends the namespace of the nodes that follow in the scope."""

    namespace: Text

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations[_NAMESPACE] = _namespace(context, self.namespace)


PushRosNamespace = PushROSNamespace


@dataclass(eq=False)
class SetParameter(Action):
    """The action that sets a parameter of all nodes that follow in the scope.

    As in launch_ros, a list becomes the text of a tuple, and the setting outlives its scope if
    there were such settings before.
    """

    name: Text
    value: Any

    def execute(self, context: LaunchContext) -> None:
        for name, value in evaluate_parameters(context, {tuple(self.name): self.value}).items():
            # launch_ros writes a list as Python's `(1, 2)`, which nodes read as a text.
            written = tuple(value) if isinstance(value, list) else value
            _append(context, _PARAMETERS, (name, written))


@dataclass(eq=False)
class SetParametersFromFile(Action):
    """The action that gives a parameter file to all nodes that follow; see SetParameter."""

    filename: Text

    def execute(self, context: LaunchContext) -> None:
        _append(context, _PARAMETERS, perform(context, self.filename))


@dataclass(eq=False)
class SetRemap(Action):
    """The action that remaps a name for all nodes that follow; see SetParameter."""

    src: Text
    dst: Text

    def execute(self, context: LaunchContext) -> None:
        _append(context, _REMAPPINGS, (perform(context, self.src), perform(context, self.dst)))


def _append(context: LaunchContext, name: str, entry: Any) -> None:
    """Add an entry to a list in the launch configurations.

    As in launch, a scope shares the lists that the scope around it has already: both get it.
    """
    context.launch_configurations.setdefault(name, []).append(entry)


def _namespace(context: LaunchContext, given: Text | None) -> str | None:
    """Return the full namespace of a node or scope, with a leading `/`; None if there is none."""
    around: str | None = context.launch_configurations.get(_NAMESPACE)
    if given is None:
        return around
    own = perform(context, given)
    if around and not own.startswith("/"):
        own = f"{around.rstrip('/')}/{own}"
    own = own if own == "/" else own.rstrip("/")
    return own if own.startswith("/") else f"/{own}"


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
