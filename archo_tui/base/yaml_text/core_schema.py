"""Scalars of YAML 1.2's core schema (https://yaml.org/spec/1.2.2/#103-core-schema).

PyYAML follows YAML 1.1: there `010` is 8, `1:30` is 90, `1_0` is 10, `on` is true, `1e3` a
text, and of two equal keys the last one wins. None of that is what a person means.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import yaml

_TAG = "tag:yaml.org,2002:"
_WORDS = {"null": None, "true": True, "false": False}
_FLOAT = r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
# Kind, pattern, and the characters that a scalar of the kind may begin with. PyYAML tries the
# kinds in this order, so int must come before float.
_SCALAR_KINDS = (
    ("null", r"null|Null|NULL|~|", ("", *"nN~")),
    ("bool", r"true|True|TRUE|false|False|FALSE", (*"tTfF",)),
    ("int", r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", (*"-+0123456789",)),
    ("float", rf"{_FLOAT}|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", (*"-+.0123456789",)),
)
_PATTERNS = {kind: re.compile(rf"(?:{form})\Z") for kind, form, _ in _SCALAR_KINDS}
# The longest integer that is parsed, and the most characters of a text that an error quotes.
# ROS integers have 64 bits, which is 20 digits; int() is slow for thousands of them.
_DIGITS = 40


class YamlFault(ValueError):
    """An error in a YAML text, with its line."""

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(f"line {line}: {reason}")
        self.line, self.reason = line, reason  # line: from 1


def _make_loader(base: Any) -> Any:
    made: Any = type("CoreLoader", (base,), {"yaml_implicit_resolvers": {}})
    for kind, _, first in _SCALAR_KINDS:
        made.add_implicit_resolver(_TAG + kind, _PATTERNS[kind], list(first))
    return made


LOADER = _make_loader(yaml.SafeLoader)
FAST_LOADER = _make_loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # In C if PyYAML has it.


def value(node: yaml.Node) -> Any:
    """Return the Python value of a node, with all keys as texts as written; raise YamlFault."""
    kind = node.tag.removeprefix(_TAG)
    if isinstance(node, yaml.MappingNode) and kind == "map":
        return {name: value(item) for name, item in pairs(node)}
    if isinstance(node, yaml.SequenceNode) and kind == "seq":
        return [value(item) for item in node.value]
    if isinstance(node, yaml.ScalarNode) and kind == "str":
        return node.value
    if isinstance(node, yaml.ScalarNode) and kind in _PATTERNS:
        return _scalar_value(kind, node)
    raise _fault(node, f"{_shorten(node.tag.replace(_TAG, '!!'))} is not read here")


def pairs(node: yaml.MappingNode) -> list[tuple[str, yaml.Node]]:
    """Return the keys of a mapping as written, each with its value's node; raise YamlFault."""
    found: dict[str, yaml.Node] = {}
    for key, item in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise _fault(key, "expected a name")
        if key.value in found:
            raise _fault(key, f"{_shorten(key.value)} is given twice")
        found[key.value] = item
    return list(found.items())


def _scalar_value(kind: str, node: yaml.ScalarNode) -> Any:
    text: str = node.value
    if not _PATTERNS[kind].match(text) and not (kind == "float" and _PATTERNS["int"].match(text)):
        raise _fault(node, f"not of the kind !!{kind}: {_shorten(text)}")
    if kind in ("null", "bool"):
        return _WORDS.get(text.lower())
    read: Callable[[str], Any] = _parse_int if kind == "int" else _parse_float
    try:
        return read(text)
    except ValueError as error:
        raise _fault(node, str(error)) from None


def _parse_int(text: str) -> int:
    if len(text) > _DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text, {"0x": 16, "0o": 8}.get(text[:2], 10))


def _parse_float(text: str) -> float:
    is_special = "n" in text.lower()  # Only inf and nan contain the letter.
    found = float(text.replace(".", "") if is_special else text)
    if math.isinf(found) and not is_special:
        raise ValueError(f"too large for a number: {_shorten(text)}")
    return found


def _shorten(text: str) -> str:
    """Return the first 40 characters of a text on one line, for an error message."""
    return text[:_DIGITS] if text.isprintable() else ascii(text[:_DIGITS])


def _fault(node: yaml.Node, reason: str) -> YamlFault:
    return YamlFault(node.start_mark.line + 1, reason)
