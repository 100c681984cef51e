"""YAML nodes into frozen dataclasses, by their type hints; what does not fit is said with its line.

A dataclass whose only required field is a string is read from that string alone as well; a field
named `where` gets file and line.
"""

from __future__ import annotations

import difflib
import functools
import math
import sys
import types
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import yaml

from archo_tui.embedded import core_schema
from archo_tui.errors import ArchoError

NONE = ("", "~", "null", "none")
_MAP = "tag:yaml.org,2002:map"  # and not a set, whose names have no values
_SHOWN = 40  # characters of a wrong value that are shown
_WORDS = {str: "a text", float: "a number", int: "a whole number", bool: "true or false"}


def read(kind: Any, node: yaml.Node, path: Path) -> Any:
    """The value of a node for a type hint. Raises ArchoError `FILE:LINE: what is wrong`."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return _one_of(arguments, node, path)
    if kind is Any:
        return _any(node, path)
    if origin is Literal:
        return _word(arguments, node, path)
    if origin is tuple:
        if not isinstance(node, yaml.SequenceNode):
            raise _error(node, path, "expected a list")
        return tuple(read(arguments[0], item, path) for item in node.value)
    if origin is not None and issubclass(origin, Mapping):
        return {
            name: _named(name, arguments[1], value, path) for name, _, value in _pairs(node, path)
        }
    if is_dataclass(kind):
        return _record(kind, node, path)
    return _scalar(kind, node)


def _error(node: yaml.Node, path: Path, said: str) -> ArchoError:
    return ArchoError(f"{path}:{node.start_mark.line + 1}: {said}")


def _named(name: str, kind: Any, node: yaml.Node, path: Path) -> Any:
    """As `read`, where what is wrong is said of that name."""
    try:
        return read(kind, node, path)
    except _Unfit as error:
        raise _error(node, path, f"{name}: {error}") from None


def _pairs(node: yaml.Node, path: Path) -> list[tuple[str, yaml.Node, yaml.Node]]:
    """Names, the nodes that they stand in, and their values; no name twice."""
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


def _record(kind: Any, node: yaml.Node, path: Path) -> Any:
    known: dict[str, Field[Any]] = {item.name: item for item in fields(kind)}
    hints = _hints(kind)
    where = f"{path}:{node.start_mark.line + 1}"
    given = {"where": where} if known.pop("where", None) else {}
    needed = [n for n, f in known.items() if f.default is MISSING and f.default_factory is MISSING]
    if isinstance(node, yaml.ScalarNode) and [hints[name] for name in needed] == [str]:
        return kind(**given, **{needed[0]: _scalar(str, node)})
    for name, key, value in _pairs(node, path):
        if name in known and hints[name] is str and name not in needed and _is_none(value):
            continue
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f" (nearest: {near[0]})" if near else f": one of {', '.join(known)}"
            raise _error(key, path, f"unknown key {name}{hint}")
        given[name] = _named(name, hints[name], value, path)
        if known[name].metadata.get("filled") and not given[name]:
            raise _error(value, path, f"{name} is empty: expected lines like 'name: value'")
    for name in needed:
        if name not in given:
            raise _error(node, path, f"{name} is missing")
    return kind(**given)


@functools.cache
def _hints(kind: type) -> dict[str, Any]:
    """Of a dataclass; each is evaluated from its text, which takes long."""
    return get_type_hints(kind)


def _any(node: yaml.Node, path: Path) -> Any:
    try:
        return core_schema.value(node)
    except core_schema.YamlFault as fault:
        raise ArchoError(f"{path}:{fault.line}: {fault.said}") from None


class _Unfit(ArchoError):
    """Not a value of the type; the record that it stands in knows its name."""


def _one_of(kinds: tuple[Any, ...], node: yaml.Node, path: Path) -> Any:
    if type(None) in kinds and _is_none(node):
        return None
    kinds = tuple(kind for kind in kinds if kind is not type(None))
    lists = tuple(kind for kind in kinds if get_origin(kind) is tuple)
    if lists:
        is_list = isinstance(node, yaml.SequenceNode)
        kinds = lists if is_list else tuple(kind for kind in kinds if kind not in lists)
    if len(kinds) > 1:  # a record stands in lines, all else in a word
        in_lines = isinstance(node, yaml.MappingNode)
        kinds = tuple(kind for kind in kinds if is_dataclass(kind) == in_lines)
    if len(kinds) == 1:
        return read(kinds[0], node, path)
    for kind in kinds:  # the narrowest first: bool, int, float, str
        try:
            return _scalar(kind, node)
        except _Unfit:
            continue
    raise _Unfit("expected a single value")


def _is_none(node: yaml.Node) -> bool:
    """True for a value that is left out; one in quotes is a text."""
    return isinstance(node, yaml.ScalarNode) and not node.style and node.value.lower() in NONE


def _word(words: tuple[Any, ...], node: yaml.Node, path: Path) -> Any:
    text = node.value if isinstance(node, yaml.ScalarNode) else ""
    for word in words:
        if text == str(word):
            return word
    near = difflib.get_close_matches(text, map(str, words), n=1)
    hint = f" (nearest: {near[0]})" if near else ""
    raise _error(node, path, f"{text or '?'} is not one of {', '.join(map(str, words))}{hint}")


def _scalar(kind: Any, node: yaml.Node) -> Any:
    if not isinstance(node, yaml.ScalarNode):
        raise _Unfit(f"expected {_WORDS[kind]}")
    try:
        value = core_schema.value(node)
    except core_schema.YamlFault as fault:
        raise _Unfit(f"expected {_WORDS[kind]}: {fault.said}") from None
    if kind is str and (value is not None or not node.value):
        return node.value  # as it is written, also where it would be a number
    if kind is float and type(value) is int:
        value = float(value) if abs(value) < sys.float_info.max else math.inf
    if type(value) is not kind or (kind is float and not math.isfinite(value)):
        raise _Unfit(f"expected {_WORDS[kind]}, not {node.value[:_SHOWN]}")
    return value
