"""A reader of ROS parameter files: `node: ros__parameters: name: value`, with `/**` and `/*`.

Scalars are typed as rcl types them (`1e3` is a double, `yes` and `on` are booleans, `017` is 15);
every error names file and line. What rcl silently reads as something else, such as a list within a
list, is an error here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.base.yaml_text.bounded_yaml import YamlError

_BOOLS = {
    form: value
    for words, value in (("y yes true on", True), ("n no false off", False))
    for word in words.split()
    for form in (word, word.capitalize(), word.upper())
}
# Numbers as C's strtoll and strtod take them, which rcl calls: 0 begins an octal, 0x a hexadecimal.
_INTEGER = re.compile(r"([-+]?)(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)")
_DECIMAL = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"[-+]?(\.(inf|Inf|INF)|(?i:inf|infinity))")
_NAN = re.compile(r"\.(nan|NaN|NAN)|[-+]?(?i:nan)")
_STRING_TAG = re.compile(r"(&\S+\s+)?!(!str|<tag:yaml.org,2002:str>)(\s|$)")
_NODE_PART = re.compile(r"[A-Za-z_][A-Za-z0-9_]*|\*\*?")

_DIGITS = 400  # No double has more digits before its point.


class ParameterFileError(YamlError):
    """The error for a parameter file that ROS refuses or misreads; it starts with `file:line:`."""


class Override(NamedTuple):
    """A value for one parameter, from a parameter file or from `-p`."""

    pattern: str
    name: str
    value: Any
    where: str


def read(path: Path) -> list[Override]:
    """Return all overrides of a parameter file, in the file's order."""
    text = bounded_yaml.read(path)
    overrides: list[Override] = []
    for root in bounded_yaml.documents(text, path):
        if not isinstance(root, yaml.MappingNode):
            raise ParameterFileError(f"{_where(path, root)}: {_FORM}")
        overrides += _nodes(_Text(path, text.split("\n")), root, "")
    _check_types(overrides)
    return overrides


class _Text(NamedTuple):
    """The path and the lines of a file; only in the lines can a `!!str` tag be seen."""

    path: Path
    lines: list[str]


def _check_types(overrides: list[Override]) -> None:
    """Raise ParameterFileError for a parameter that one pattern sets twice with different types.

    All lists count as one type. Of two such values rcl takes one or the other, depending on their
    types.
    """
    types: dict[tuple[str, str], type] = {}
    for override in overrides:
        kind = type(override.value)
        if types.setdefault((override.pattern, override.name), kind) is not kind:
            said = f"{override.name} is set twice, with values of different types"
            raise ParameterFileError(f"{override.where}: {said}")


def scalar(text: str) -> Any:
    """Return the bool, int, float or str as which rcl reads a scalar without quotes.

    An integer that does not fit in 64 bits is a float, and a number that is too large for a double
    is a str.
    """
    if text in _BOOLS:
        return _BOOLS[text]
    integer = _INTEGER.fullmatch(text)
    if integer is not None:
        digits = integer[2]
        value = int(digits, 0 if digits[:2] in ("0x", "0X") else 8 if digits[0] == "0" else 10)
        value = -value if integer[1] == "-" else value
        if -(2**63) <= value < 2**63:
            return value
    if _INFINITE.fullmatch(text):
        return float("-inf" if text.startswith("-") else "inf")
    if _NAN.fullmatch(text):
        return float("nan")
    number = float(text) if _DECIMAL.fullmatch(text) else math.inf
    return text if math.isinf(number) else number


def value_of(text: str) -> Any:
    """Return the value of the text behind `-p name:=`: a scalar, or a list such as `[1, 2]`."""
    try:
        node = bounded_yaml.compose(text, Path("-p"))
    except YamlError as error:
        raise ValueError(f"not a value: {text!r}") from error
    quoted = isinstance(node, yaml.ScalarNode) and node.style in ("'", '"')
    if node is None or (node.value == "" and not quoted):
        raise ValueError(f"no value: {text!r}")
    return _value(_Text(Path("-p"), text.split("\n")), node)


def matches(pattern: str, node: str) -> bool:
    """Return True if the pattern of a parameter file means a node."""
    pattern = pattern if pattern.startswith("/") else f"/{pattern}"
    regex = ""
    for token in pattern.split("/")[1:]:
        regex += {"**": "(/[^/]+)*", "*": "/[^/]+"}.get(token, f"/{re.escape(token)}")
    return re.fullmatch(regex, node) is not None


_FORM = "not a ROS parameter file: expected 'node: ros__parameters: name: value'"


def _nodes(text: _Text, mapping: yaml.MappingNode, prefix: str) -> Iterator[Override]:
    path, is_over = text.path, False
    for key, value in mapping.value:
        name = _key(text, key)
        if is_over:
            raise ParameterFileError(f"{_where(path, key)}: {name} stands behind ros__parameters")
        if name == "ros__parameters":
            is_over = True
            if not prefix:
                raise ParameterFileError(f"{_where(path, key)}: ros__parameters without a node")
            _check_node(text, key, prefix)
            if not isinstance(value, yaml.MappingNode):
                said = "ros__parameters without parameters: {} stands for none"
                raise ParameterFileError(f"{_where(path, key)}: {said}")
            yield from _parameters(text, value, prefix, "")
        elif isinstance(value, yaml.MappingNode):
            between = "" if not prefix or prefix.endswith("/") else "/"
            yield from _nodes(text, value, f"{prefix}{between}{name}")
        else:
            raise ParameterFileError(f"{_where(path, key)}: {_FORM}, found {name!r}")


def _check_node(text: _Text, key: yaml.Node, name: str) -> None:
    """Raise ParameterFileError unless a text can be a node's name or a pattern.

    Wrong are, for example, `n/`, `//n` and `/motor*`.
    """
    for part in name.removeprefix("/").split("/"):
        if not _NODE_PART.fullmatch(part):
            said = f"{name!r} is no name of a node: letters, digits and _ between slashes, * or **"
            raise ParameterFileError(f"{_where(text.path, key)}: {said}")


def _key(text: _Text, key: yaml.Node) -> str:
    if not isinstance(key, yaml.ScalarNode) or key.value == "":
        raise ParameterFileError(f"{_where(text.path, key)}: a name is missing before the colon")
    return str(key.value)


def _parameters(
    text: _Text, mapping: yaml.MappingNode, pattern: str, prefix: str
) -> Iterator[Override]:
    for key, value in mapping.value:
        name = prefix + _key(text, key)
        if isinstance(value, yaml.MappingNode) and value.value:
            yield from _parameters(text, value, pattern, f"{name}.")
        else:
            yield Override(pattern, name, _value(text, value, name), _where(text.path, key))


def _value(text: _Text, node: yaml.Node, name: str = "it") -> Any:
    """Return the value of a parameter: a scalar, or a list of scalars of one type."""
    where = _where(text.path, node)
    if isinstance(node, yaml.ScalarNode):
        if node.style in ("'", '"', "|"):
            return node.value
        if node.value == "":
            raise ParameterFileError(f"{where}: {name} has no value")
        line, column = node.start_mark.line, node.start_mark.column
        if line < len(text.lines) and _STRING_TAG.match(text.lines[line][column:]):
            return node.value
        if len(node.value) > _DIGITS and node.value.strip("+-").isdigit():
            raise ParameterFileError(f"{where}: a number of {len(node.value)} digits")
        return scalar(node.value)
    if isinstance(node, yaml.SequenceNode):
        items = [_value(text, item, name) for item in node.value]
        if len({type(item) for item in items}) > 1 or any(isinstance(i, list) for i in items):
            raise ParameterFileError(f"{where}: a list needs values of one type")
        return items
    raise ParameterFileError(f"{where}: not a parameter value")


def _where(path: Path, node: yaml.Node) -> str:
    return f"{path}:{node.start_mark.line + 1}"
