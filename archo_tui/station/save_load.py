"""Saving the parameters of running nodes to a ROS parameter file, and planning to load one."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import yaml

from archo_tui.base.errors import ArchoError
from archo_tui.base.system import create_exclusively, keep_owner_and_mode
from archo_tui.robot.graph.parameter_values import fit
from archo_tui.robot.messages.values import same
from archo_tui.robot.state.graph import Parameter
from archo_tui.ros.embedded.parameter_files import matches
from archo_tui.station import parameter_files

# Types for which ROS's parameter files have no notation.
_UNWRITABLE_TYPES = ("byte[]", "not set")
_ALL_REPORTED: Mapping[str, str] = MappingProxyType({})


class LoadPlan(NamedTuple):
    """The changes that loading a file would make; nothing is changed yet."""

    changes: tuple[tuple[Parameter, Any], ...]  # Each with its new value.
    problems: tuple[str, ...]  # If there are any, nothing may be changed.
    left_out: tuple[str, ...]  # As `unknown_lines` returns them.


class _Dumper(yaml.SafeDumper):
    """A dumper that quotes every string, so that `yes` and `1` stay strings."""


_Dumper.add_representer(
    str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"')
)


def dump(parameters: Iterable[Parameter]) -> tuple[str, list[str]]:
    """Return the text of a ROS parameter file, and a line for each parameter it cannot hold."""
    text, left_out = "", []
    nodes: dict[str, dict[str, Any]] = {}
    for parameter in parameters:
        if parameter.type in _UNWRITABLE_TYPES:
            left_out.append(f"{parameter.node} {parameter.name}: {parameter.type}")
        elif parameter.value is None:
            left_out.append(f"{parameter.node} {parameter.name}: it has no value")
        elif parameter.value == []:
            reason = "an empty list, which ROS reads as not set"
            left_out.append(f"{parameter.node} {parameter.name}: {reason}")
        else:
            nodes.setdefault(parameter.node, {})[parameter.name] = parameter.value
    for node, values in nodes.items():
        text += f"{node}:\n  ros__parameters:\n"
        for name, value in values.items():
            line = yaml.dump(
                value, Dumper=_Dumper, default_flow_style=True, allow_unicode=True, width=10**9
            )
            text += f"    {_yaml_key(name)}: {line.partition(chr(10))[0]}\n"
    return text, left_out


def _yaml_key(name: str) -> str:
    plain = name.replace("_", "").replace(".", "").isalnum()
    return name if plain else yaml.dump(name, Dumper=_Dumper, width=10**9).strip()


def write_atomically(path: Path, text: str) -> None:
    """Write a file so that a reader finds the old text or the new one; wait for the disk.

    A file that exists keeps its mode and owner, and a link to it stays one. Raises ArchoError.
    """
    try:
        _replace_file(path, text)
    except OSError as error:
        raise ArchoError(f"{path}: cannot write the file: {error.strerror}") from None


def _replace_file(path: Path, text: str) -> None:
    try:
        before = os.stat(path)
    except FileNotFoundError:
        if path.is_symlink():
            raise ArchoError(f"{path}: a link to a file that does not exist") from None
        before = None
    if before is not None and not stat.S_ISREG(before.st_mode):
        raise ArchoError(f"{path}: not a regular file")
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{os.urandom(16).hex()}")  # An unguessable name.
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


def plan_load(
    path: Path, parameters: Sequence[Parameter], unreported: Mapping[str, str] = _ALL_REPORTED
) -> LoadPlan:
    """Return what loading a file now would change; of several entries that fit, the last counts."""
    overrides = parameter_files.load_files([path])
    changes, problems = [], []
    for parameter in parameters:
        found = [override for override in overrides if override.name == parameter.name]
        found = [o for o in found if matches(o.pattern, parameter.node)][-1:]  # The last wins.
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
    unknown: dict[str, str] = {}  # Where the file first names each node of `unreported`.
    others = []
    for override in overrides:
        node = f"/{override.pattern.lstrip('/')}"
        if node in unreported:
            unknown.setdefault(node, override.where)
        else:
            others.append(override)
    left_out = [f"{where}: {node} {unreported[node]}" for node, where in unknown.items()]
    left_out += parameter_files.unknown_lines(others, declared)
    return LoadPlan(tuple(changes), tuple(problems), tuple(left_out))
