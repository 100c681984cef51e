"""Message definitions as bags hold them, written from the classes: the same on every engine."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from archo_tui.robot import message_classes
from archo_tui.robot.fields import element_of

_RULE = "=" * 80
_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(, (?P<most>\d+))?>")
_ARRAY = re.compile(r"(?P<of>.+)\[(?P<size>\d+)\]")
_BOUNDED = re.compile(r"(?P<text>w?string)<(?P<most>\d+)>")
_NAMES = {"boolean": "bool", "float": "float32", "double": "float64", "octet": "byte"}


def definition(kind: Any) -> str:
    """The fields of a message class, and below them those of every message in it (`ros2msg`)."""
    parts, wanted, seen = [_fields(kind)], list(_within(kind)), set[str]()
    while wanted:
        name, inner = wanted.pop(0)
        if name not in seen:
            seen.add(name)
            parts.append(f"{_RULE}\nMSG: {name}\n{_fields(inner)}")
            wanted += _within(inner)
    return "".join(parts)


def _fields(kind: Any) -> str:
    types = kind.get_fields_and_field_types()
    return "".join(f"{_written(types[name])} {name}\n" for name in types)


def _written(kind: str) -> str:
    """`sequence<double, 5>` is `float64[<=5]`."""
    if found := _SEQUENCE.fullmatch(kind):
        most = f"<={found['most']}" if found["most"] else ""
        return f"{_written(found['of'])}[{most}]"
    if found := _ARRAY.fullmatch(kind):
        return f"{_written(found['of'])}[{found['size']}]"
    if found := _BOUNDED.fullmatch(kind):
        return f"{found['text']}<={found['most']}"
    return _NAMES.get(kind, kind)


def _within(kind: Any) -> Iterator[tuple[str, Any]]:
    """The messages among the fields, by name, with their classes."""
    for each in kind.get_fields_and_field_types().values():
        bare = element_of(each) or each
        if "/" in bare:
            yield bare, _class(bare)


def _class(name: str) -> Any:
    """Of `package/Name`; an action's part is called `Action_Part`."""
    package, name = name.split("/")
    action, _, part = name.rpartition("_")
    found = message_classes.load(f"{package}/msg/{name}")
    return found or getattr(message_classes.load(f"{package}/action/{action}"), part)
