"""YAML nodes into frozen dataclasses, by their type hints; what does not fit is said with its line.

A dataclass whose first required field is a string is read from that string alone as well; a field
named `where` gets file and line.
"""

from __future__ import annotations

import difflib
import math
import types
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import yaml

from archo_tui.embedded import core_schema
from archo_tui.errors import ArchoError

_NONE = ("", "~", "null", "none")
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
        pairs = _pairs(node, path)
        return {name: read(arguments[1], value, path) for name, _, value in pairs}
    if is_dataclass(kind):
        return _record(kind, node, path)
    return _scalar(kind, node)


def _error(node: yaml.Node, path: Path, said: str) -> ArchoError:
    return ArchoError(f"{path}:{node.start_mark.line + 1}: {said}")


def _pairs(node: yaml.Node, path: Path) -> list[tuple[str, yaml.Node, yaml.Node]]:
    """Names, the nodes that they stand in, and their values; no name twice."""
    if not isinstance(node, yaml.MappingNode):
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
    hints = get_type_hints(kind)
    where = f"{path}:{node.start_mark.line + 1}"
    given = {"where": where} if known.pop("where", None) else {}
    needed = [n for n, f in known.items() if f.default is MISSING and f.default_factory is MISSING]
    if isinstance(node, yaml.ScalarNode) and needed and hints[needed[0]] is str:
        return kind(**given, **{needed[0]: _scalar(str, node)})
    for name, key, value in _pairs(node, path):
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f" (nearest: {near[0]})" if near else f": one of {', '.join(known)}"
            raise _error(key, path, f"unknown key {name}{hint}")
        try:
            given[name] = read(hints[name], value, path)
        except _Unfit as error:
            raise _error(value, path, f"{name}: {error}") from None
    for name in needed:
        if name not in given:
            raise _error(node, path, f"{name} is missing")
    return kind(**given)


def _any(node: yaml.Node, path: Path) -> Any:
    try:
        return core_schema.value(node)
    except core_schema.YamlFault as fault:
        raise ArchoError(f"{path}:{fault.line}: {fault.said}") from None


class _Unfit(ArchoError):
    """Not a value of the type; the record that it stands in knows its name."""


def _one_of(kinds: tuple[Any, ...], node: yaml.Node, path: Path) -> Any:
    if type(None) in kinds and isinstance(node, yaml.ScalarNode) and node.value.lower() in _NONE:
        return None
    kinds = tuple(kind for kind in kinds if kind is not type(None))
    if len(kinds) == 1:
        return read(kinds[0], node, path)
    for kind in kinds:  # the narrowest first: bool, int, float, str
        try:
            return _scalar(kind, node)
        except _Unfit:
            continue
    raise _Unfit("expected a single value")


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
    if kind is str:
        return node.value
    try:
        value = core_schema.value(node)
    except core_schema.YamlFault as fault:
        raise _Unfit(f"expected {_WORDS[kind]}: {fault.said}") from None
    if kind is float and type(value) is int:
        value = float(value)
    if type(value) is not kind or (kind is float and not math.isfinite(value)):
        raise _Unfit(f"expected {_WORDS[kind]}, not {node.value}")
    return value
