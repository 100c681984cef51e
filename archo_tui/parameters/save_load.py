"""Parameters of the running nodes to a ROS parameter file, and back with a plan of what changes."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from archo_tui.embedded.parameter_files import matches
from archo_tui.errors import ArchoError
from archo_tui.parameters import files
from archo_tui.robot.parameter_values import fit
from archo_tui.robot.state import Parameter
from archo_tui.robot.values import same
from archo_tui.system import create_exclusively, keep_owner_and_mode

# ROS's files have no way to write these
_NOT_WRITTEN = ("byte[]", "not set")


class Plan(NamedTuple):
    """What a file would change. With problems nothing may be changed."""

    changes: tuple[tuple[Parameter, Any], ...]  # the parameter as it is, and its new value
    problems: tuple[str, ...]  # one line each, with file and line
    left_out: tuple[str, ...]  # what the file says of nodes and parameters that are not there


class _Dumper(yaml.SafeDumper):
    """Quotes every string, so that `yes` and `1` stay strings."""


_Dumper.add_representer(
    str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"')
)


def dump(parameters: Iterable[Parameter]) -> tuple[str, list[str]]:
    """The text of a ROS parameter file, and what cannot be written in one."""
    text, left_out = "", []
    nodes: dict[str, dict[str, Any]] = {}
    for parameter in parameters:
        if parameter.type in _NOT_WRITTEN:
            left_out.append(f"{parameter.node} {parameter.name}: {parameter.type}")
        elif parameter.value is None:
            left_out.append(f"{parameter.node} {parameter.name}: it has no value")
        elif parameter.value == []:
            said = "an empty list, which ROS reads as not set"
            left_out.append(f"{parameter.node} {parameter.name}: {said}")
        else:
            nodes.setdefault(parameter.node, {})[parameter.name] = parameter.value
    for node, values in nodes.items():
        text += f"{node}:\n  ros__parameters:\n"
        for name, value in values.items():
            line = yaml.dump(
                value, Dumper=_Dumper, default_flow_style=True, allow_unicode=True, width=10**9
            )
            text += f"    {_key(name)}: {line.partition(chr(10))[0]}\n"
    return text, left_out


def _key(name: str) -> str:
    """A name as a key of YAML: plain where that is safe."""
    plain = name.replace("_", "").replace(".", "").isalnum()
    return name if plain else yaml.dump(name, Dumper=_Dumper, width=10**9).strip()


def write(path: Path, text: str) -> None:
    """Write a file whole or not at all, one that a link leads to in its own place.

    It keeps its mode and owner. Raises ArchoError with one line that says why not.
    """
    try:
        _write(path, text)
    except OSError as error:
        raise ArchoError(f"{path}: cannot write the file: {error.strerror}") from None


def _write(path: Path, text: str) -> None:
    try:
        before = os.stat(path)
    except FileNotFoundError:
        if path.is_symlink():
            raise ArchoError(f"{path}: a link to a file that does not exist") from None
        before = None
    if before is not None and not stat.S_ISREG(before.st_mode):
        raise ArchoError(f"{path}: not a regular file")
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{os.urandom(16).hex()}")  # nobody can have put it there
    try:
        with open(create_exclusively(temporary), "w", encoding="utf-8") as file:
            if before is not None:
                keep_owner_and_mode(file.fileno(), before)
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def plan(path: Path, parameters: Sequence[Parameter]) -> Plan:
    """What loading a file now would change. Raises ArchoError when it is not a parameter file."""
    overrides = files.load([path])
    changes, problems = [], []
    for parameter in parameters:
        found = [o for o in overrides if o.name == parameter.name]
        found = [o for o in found if matches(o.pattern, parameter.node)][-1:]
        for override in found:
            try:
                value = fit(parameter, override.value)
            except ValueError as error:
                name = f"{parameter.node.lstrip('/')} {parameter.name}"
                problems.append(f"{override.where}: {name}: {error}")
                continue
            if not same(value, parameter.value):
                changes.append((parameter, value))
    declared: dict[str, set[str]] = {}
    for parameter in parameters:
        declared.setdefault(parameter.node, set()).add(parameter.name)
    left_out = files.unknown(overrides, declared)
    return Plan(tuple(changes), tuple(problems), tuple(left_out))
