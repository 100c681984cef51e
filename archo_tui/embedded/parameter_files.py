"""Reads ROS parameter files: `node: ros__parameters: name: value`, with `/**` and `/*` wildcards.

Scalars are typed as ROS's own parser types them (`1e3` is a double, `yes` and `on` are booleans);
every error names file and line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from archo_tui.embedded import bounded_yaml
from archo_tui.embedded.bounded_yaml import YamlError

_BOOLS = {word: True for word in ("y", "yes", "true", "on")} | {
    word: False for word in ("n", "no", "false", "off")
}
_INTEGER = re.compile(r"[-+]?(0x[0-9a-fA-F]+|[0-9]+)")
_DOUBLE = re.compile(r"[-+]?((\d+\.\d*|\.\d+)([eE][-+]?\d+)?|\d+[eE][-+]?\d+|\.inf|\.Inf|\.INF)")
_NAN = (".nan", ".NaN", ".NAN")


_DIGITS = 40  # of an integer; ROS's have 64 bits


class ParameterFileError(YamlError):
    """A parameter file that ROS would refuse; the message starts with `file:line:`."""


class Override(NamedTuple):
    """One value for one parameter of the nodes that a pattern names, and where it was written.

    The pattern is as written: `node` and `/node` mean the same node, and are two to rcl.
    """

    pattern: str
    name: str
    value: Any
    where: str


def read(path: Path) -> list[Override]:
    """All overrides of a file, in order. Raises YamlError, and OSError as `open` does."""
    root = bounded_yaml.compose(bounded_yaml.read(path), path)
    if root is None:
        return []
    if not isinstance(root, yaml.MappingNode):
        raise ParameterFileError(f"{_where(path, root)}: {_FORM}")
    return list(_nodes(path, root, ""))


def scalar(text: str) -> Any:
    """The value of a scalar written without quotes, typed as ROS types it."""
    if text.lower() in _BOOLS:
        return _BOOLS[text.lower()]
    if _INTEGER.fullmatch(text):
        return int(text, 16 if "x" in text else 10)
    if _DOUBLE.fullmatch(text):
        return float(text.replace(".inf", "inf").replace(".Inf", "inf").replace(".INF", "inf"))
    if text in _NAN:
        return float("nan")
    return text


def value_of(text: str) -> Any:
    """The value of `-p name:=text`: a scalar or a flow sequence. Raises ValueError."""
    try:
        node = bounded_yaml.compose(text, Path("-p"))
    except YamlError as error:
        raise ValueError(f"not a value: {text!r}") from error
    quoted = isinstance(node, yaml.ScalarNode) and node.style in ("'", '"')
    if node is None or (node.value == "" and not quoted):
        raise ValueError(f"no value: {text!r}")
    return _value(Path("-p"), node)


def matches(pattern: str, node: str) -> bool:
    """True when a file's node name (`/**`, `/ns/*`, `node`) names the fully qualified `node`."""
    pattern = pattern if pattern.startswith("/") else f"/{pattern}"
    regex = ""
    for token in pattern.split("/")[1:]:
        regex += {"**": "(/[^/]+)*", "*": "/[^/]+"}.get(token, f"/{re.escape(token)}")
    return re.fullmatch(regex, node) is not None


_FORM = "not a ROS parameter file: expected 'node: ros__parameters: name: value'"


def _nodes(path: Path, mapping: yaml.MappingNode, prefix: str) -> Iterator[Override]:
    for key, value in mapping.value:
        name = str(key.value)
        if name == "ros__parameters":
            if not prefix:
                raise ParameterFileError(f"{_where(path, key)}: ros__parameters without a node")
            if not isinstance(value, yaml.MappingNode):
                if isinstance(value, yaml.ScalarNode) and value.value == "":
                    continue
                raise ParameterFileError(f"{_where(path, value)}: {_FORM}")
            yield from _parameters(path, value, prefix, "")
        elif isinstance(value, yaml.MappingNode):
            yield from _nodes(path, value, f"{prefix}/{name.strip('/')}" if prefix else name)
        else:
            raise ParameterFileError(f"{_where(path, key)}: {_FORM}, found {name!r}")


def _parameters(
    path: Path, mapping: yaml.MappingNode, pattern: str, prefix: str
) -> Iterator[Override]:
    for key, value in mapping.value:
        name = prefix + str(key.value)
        if isinstance(value, yaml.MappingNode):
            yield from _parameters(path, value, pattern, f"{name}.")
        else:
            yield Override(pattern, name, _value(path, value), _where(path, key))


def _value(path: Path, node: yaml.Node) -> Any:
    if isinstance(node, yaml.ScalarNode):
        if _INTEGER.fullmatch(node.value) and len(node.value) > _DIGITS:
            raise ParameterFileError(f"{_where(path, node)}: a number of {len(node.value)} digits")
        return node.value if node.style in ("'", '"', "|", ">") else scalar(node.value)
    if isinstance(node, yaml.SequenceNode):
        items = [_value(path, item) for item in node.value]
        if len({type(item) for item in items}) > 1 or any(isinstance(i, list) for i in items):
            raise ParameterFileError(f"{_where(path, node)}: a list needs values of one type")
        return items
    raise ParameterFileError(f"{_where(path, node)}: not a parameter value")


def _where(path: Path, node: yaml.Node) -> str:
    return f"{path}:{node.start_mark.line + 1}"
