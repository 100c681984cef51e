"""What a scalar means in YAML 1.2's core schema, which is what a person means by it.

PyYAML's own reading is YAML 1.1: there `010` is 8, `1:30` is 90, `1_0` is 10, `on` is true, `1e3` a
text, and of two equal keys the last one wins.
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
# by kind: what it looks like, and the characters that it may begin with; an integer before a float
_KINDS = (
    ("null", r"null|Null|NULL|~|", ("", *"nN~")),
    ("bool", r"true|True|TRUE|false|False|FALSE", (*"tTfF",)),
    ("int", r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", (*"-+0123456789",)),
    ("float", rf"{_FLOAT}|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", (*"-+.0123456789",)),
)
_FORMS = {kind: re.compile(rf"(?:{form})\Z") for kind, form, _ in _KINDS}
_DIGITS = 40  # of a whole number; ROS's have 64 bits. And characters of a text that are shown


class YamlFault(ValueError):
    """What is wrong with a text, and in which line."""

    def __init__(self, line: int, said: str) -> None:
        super().__init__(f"line {line}: {said}")
        self.line, self.said = line, said


def _loader(base: Any) -> Any:
    made: Any = type("CoreLoader", (base,), {"yaml_implicit_resolvers": {}})
    for kind, _, first in _KINDS:
        made.add_implicit_resolver(_TAG + kind, _FORMS[kind], list(first))
    return made


LOADER = _loader(yaml.SafeLoader)
FAST_LOADER = _loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # in C where PyYAML has it


def value(node: yaml.Node) -> Any:
    """The value of a node that one of these loaders composed. Raises YamlFault."""
    kind = node.tag.removeprefix(_TAG)
    if isinstance(node, yaml.MappingNode) and kind == "map":
        return {name: value(item) for name, item in pairs(node)}
    if isinstance(node, yaml.SequenceNode) and kind == "seq":
        return [value(item) for item in node.value]
    if isinstance(node, yaml.ScalarNode) and kind == "str":
        return node.value
    if isinstance(node, yaml.ScalarNode) and kind in _FORMS:
        return _scalar(kind, node)
    raise _fault(node, f"{_shown(node.tag.replace(_TAG, '!!'))} is not read here")


def pairs(node: yaml.MappingNode) -> list[tuple[str, yaml.Node]]:
    """Names, as they are written, and their values; no name twice. Raises YamlFault."""
    found: dict[str, yaml.Node] = {}
    for key, item in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise _fault(key, "expected a name")
        if key.value in found:
            raise _fault(key, f"{_shown(key.value)} is given twice")
        found[key.value] = item
    return list(found.items())


def _scalar(kind: str, node: yaml.ScalarNode) -> Any:
    text: str = node.value
    if not _FORMS[kind].match(text) and not (kind == "float" and _FORMS["int"].match(text)):
        raise _fault(node, f"not of the kind !!{kind}: {_shown(text)}")
    if kind in ("null", "bool"):
        return _WORDS.get(text.lower())
    read: Callable[[str], Any] = _whole if kind == "int" else _number
    try:
        return read(text)
    except ValueError as error:
        raise _fault(node, str(error)) from None


def _whole(text: str) -> int:
    if len(text) > _DIGITS:
        raise ValueError(f"a number of {len(text)} digits")
    return int(text, {"0x": 16, "0o": 8}.get(text[:2], 10))


def _number(text: str) -> float:
    infinite = "n" in text.lower()  # of inf and nan
    found = float(text.replace(".", "") if infinite else text)
    if math.isinf(found) and not infinite:
        raise ValueError(f"too large for a number: {_shown(text)}")
    return found


def _shown(text: str) -> str:
    """In one line, and no longer than one."""
    return text[:_DIGITS] if text.isprintable() else ascii(text[:_DIGITS])


def _fault(node: yaml.Node, said: str) -> YamlFault:
    return YamlFault(node.start_mark.line + 1, said)
