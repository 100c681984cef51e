"""Reader and writer of robot files; an error names file, line and the nearest valid word.

The dataclasses of the model guide both: one whose only required field is a string may be written as
that string alone, and a field named `where` receives `FILE:LINE`. They hold the checks, too.
"""

from __future__ import annotations

import functools
import math
import sys
import types
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import yaml

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.base.safe_text import harmless
from archo_tui.base.yaml_text import bounded_yaml, core_schema
from archo_tui.base.yaml_text import dump as yaml_dump
from archo_tui.robot_file.model import Check, RobotFile

_PACKAGE = Path(__file__).parent.parent


def default_path() -> Path:
    """Return the path of ARCHO's robot file, which may not exist."""
    paths = [folder / "config" / "robots" / "archo.yaml" for folder in (_PACKAGE.parent, _PACKAGE)]
    return next((path for path in paths if path.is_file()), paths[0])


def load(path: Path) -> RobotFile:
    """Read and validate a robot file; ArchoError names the first fault in one line."""
    try:
        text = bounded_yaml.read(path)
    except OSError as error:
        text = f"{path}: cannot read the robot file: {error.strerror}"
        raise ArchoError(harmless(text)) from None
    except bounded_yaml.YamlError as error:
        raise ArchoError(harmless(str(error))) from None
    return parse(text, path)


def parse(text: str, path: Path) -> RobotFile:
    """Validate the text of a robot file, as `load` does; `path` is only named in errors."""
    try:
        node = bounded_yaml.compose(text, path)
        if node is None:
            raise ArchoError(f"{path}:1: the file is empty: it describes no robot")
        robot: RobotFile = read_node(RobotFile, node, path)
    except (bounded_yaml.YamlError, ArchoError) as error:  # It may quote control characters.
        raise ArchoError(harmless(str(error))) from None
    return robot


NONE_WORDS = ("", "~", "null", "none")
_MAP = "tag:yaml.org,2002:map"  # A `!!set` is a MappingNode as well, but without values.
_SHOWN = 40  # Characters of a wrong value that an error quotes.
_EXPECTED = {str: "a text", float: "a number", int: "a whole number", bool: "true or false"}


def read_node(kind: Any, node: yaml.Node, path: Path) -> Any:
    """Convert a YAML node to the type of a hint; ArchoError is `FILE:LINE: reason`.

    The hint is a dataclass, a scalar type, or made of `Union`, `Literal`, `tuple[...]`,
    `Mapping[str, ...]` and `Any`. Of a single value that is not below a key, the error has only the
    reason.
    """
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return _read_union(arguments, node, path)
    if kind is Any:
        return _read_any(node, path)
    if origin is Literal:
        return _read_literal(arguments, node, path)
    if origin is tuple:
        if not isinstance(node, yaml.SequenceNode):
            raise _error(node, path, "expected a list")
        return tuple(read_node(arguments[0], item, path) for item in node.value)
    if origin is not None and issubclass(origin, Mapping):
        return {
            name: _read_named(name, arguments[1], value, path)
            for name, _, value in _checked_pairs(node, path)
        }
    if is_dataclass(kind):
        return _read_dataclass(kind, node, path)
    return _read_scalar(kind, node)


def _error(node: yaml.Node, path: Path, reason: str) -> ArchoError:
    return ArchoError(f"{path}:{node.start_mark.line + 1}: {reason}")


def _read_named(name: str, kind: Any, node: yaml.Node, path: Path) -> Any:
    """Convert the value of a key; an error for a wrong scalar names the key and the line."""
    try:
        return read_node(kind, node, path)
    except _TypeMismatch as error:
        raise _error(node, path, f"{name}: {error}") from None


def _checked_pairs(node: yaml.Node, path: Path) -> list[tuple[str, yaml.Node, yaml.Node]]:
    if not isinstance(node, yaml.MappingNode) or node.tag != _MAP:
        raise _error(node, path, "expected lines like 'name: value'")
    found: dict[str, tuple[str, yaml.Node, yaml.Node]] = {}
    for key, value in node.value:
        name = key.value if isinstance(key, yaml.ScalarNode) else ""
        if not name:
            raise _error(key, path, "expected a name")
        if name in found:
            raise _error(key, path, f"{name} is given twice")
        found[name] = name, key, value
    return list(found.values())


def _read_dataclass(kind: Any, node: yaml.Node, path: Path) -> Any:
    known: dict[str, Field[Any]] = {item.name: item for item in fields(kind)}
    hints, checks = _hints_and_checks(kind)
    where = f"{path}:{node.start_mark.line + 1}"
    given = {"where": where} if known.pop("where", None) else {}
    needed = [n for n, f in known.items() if f.default is MISSING and f.default_factory is MISSING]
    written: dict[str, yaml.Node] = {}
    is_short = isinstance(node, yaml.ScalarNode) and [hints[name] for name in needed] == [str]
    if is_short:
        given[needed[0]], written[needed[0]] = _read_scalar(str, node), node
    for name, key, value in () if is_short else _checked_pairs(node, path):
        if name in known and hints[name] is str and name not in needed and _is_left_out(value):
            continue
        if name not in known:
            hint = nearest_hint(name, known) or f": one of {', '.join(known)}"
            raise _error(key, path, f"unknown key {name}{hint}")
        given[name] = _read_named(name, hints[name], value, path)
        written[name] = value
    for name in needed:
        if name not in given:
            raise _error(node, path, f"{name} is missing")
    for name, value in written.items():
        for check in checks[name]:
            if fault := check(given[name]):
                raise _error(value, path, f"{name} {fault}")
    made = kind(**given)
    for place, fault in made.faults() if hasattr(made, "faults") else ():
        raise ArchoError(f"{place or where}: {fault}")
    return made


@functools.cache
def _hints_and_checks(kind: type) -> tuple[dict[str, Any], dict[str, tuple[Check, ...]]]:
    told = get_type_hints(kind, include_extras=True)
    checks = {name: getattr(hint, "__metadata__", ())[1:] for name, hint in told.items()}
    return get_type_hints(kind), checks


def _read_any(node: yaml.Node, path: Path) -> Any:
    try:
        return core_schema.value(node)
    except core_schema.YamlFault as fault:
        raise ArchoError(f"{path}:{fault.line}: {fault.reason}") from None


class _TypeMismatch(ArchoError):
    """The error for a node that is not the wanted scalar; `_read_named` adds key and line."""


def _read_union(kinds: tuple[Any, ...], node: yaml.Node, path: Path) -> Any:
    if type(None) in kinds and _is_left_out(node):
        return None
    kinds = tuple(kind for kind in kinds if kind is not type(None))
    lists = tuple(kind for kind in kinds if get_origin(kind) is tuple)
    if lists:
        is_list = isinstance(node, yaml.SequenceNode)
        kinds = lists if is_list else tuple(kind for kind in kinds if kind not in lists)
    if len(kinds) > 1:  # A dataclass is written as a mapping, everything else as a scalar.
        is_mapping = isinstance(node, yaml.MappingNode)
        kinds = tuple(kind for kind in kinds if is_dataclass(kind) == is_mapping)
    if len(kinds) == 1:
        return read_node(kinds[0], node, path)
    for kind in kinds:  # The hints list the narrowest first: bool, int, float, str.
        try:
            return _read_scalar(kind, node)
        except _TypeMismatch:
            continue
    raise _TypeMismatch("expected a single value")


def _is_left_out(node: yaml.Node) -> bool:
    return isinstance(node, yaml.ScalarNode) and not node.style and node.value.lower() in NONE_WORDS


def _read_literal(words: tuple[Any, ...], node: yaml.Node, path: Path) -> Any:
    text = node.value if isinstance(node, yaml.ScalarNode) else ""
    for word in words:
        if text == str(word):
            return word
    hint = nearest_hint(text, map(str, words))
    raise _error(node, path, f"{text or '?'} is not one of {', '.join(map(str, words))}{hint}")


def _read_scalar(kind: Any, node: yaml.Node) -> Any:
    if not isinstance(node, yaml.ScalarNode):
        raise _TypeMismatch(f"expected {_EXPECTED[kind]}")
    try:
        value = core_schema.value(node)
    except core_schema.YamlFault as fault:
        raise _TypeMismatch(f"expected {_EXPECTED[kind]}: {fault.reason}") from None
    if kind is str and (value is not None or not node.value):
        return node.value  # A text stays as written, even if it looks like a number.
    if kind is float and type(value) is int:
        value = float(value) if abs(value) < sys.float_info.max else math.inf
    if type(value) is not kind or (kind is float and not math.isfinite(value)):
        raise _TypeMismatch(f"expected {_EXPECTED[kind]}, not {node.value[:_SHOWN]}")
    return value


# Writing.

_HEAD = "# Written by archo-tui. What the words mean: docs/own_robot.md.\n"


def dump(robot: RobotFile) -> str:
    """Return YAML text from which `load` makes an equal robot; defaults are left out of it."""
    return _HEAD + yaml_dump.block({"version": robot.version, **plain(robot)})


def plain(value: Any) -> Any:
    """Return a dataclass of a robot file as mappings and lists, without defaults and `where`.

    A dataclass of which only `field` is set becomes the value of `field`.
    """
    if is_dataclass(value):
        found = {}
        for item in fields(value):
            given = getattr(value, item.name)
            default = item.default
            if item.default_factory is not MISSING:
                default = item.default_factory()
            if item.name != "where" and given != default:
                found[item.name] = plain(given)
        return next(iter(found.values())) if list(found) == ["field"] else found
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, tuple) else value
