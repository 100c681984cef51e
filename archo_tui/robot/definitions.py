"""Message definitions for recordings, derived from message classes: the same on both engines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from archo_tui.robot import message_classes
from archo_tui.robot.fields import element_of
from archo_tui.ros_names import base_name, package_of

_SEPARATOR = "=" * 80
_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(, (?P<most>\d+))?>")
_ARRAY = re.compile(r"(?P<of>.+)\[(?P<size>\d+)\]")
_BOUNDED = re.compile(r"(?P<text>w?string)<(?P<most>\d+)>")
_PRIMITIVES = {"boolean": "bool", "float": "float32", "double": "float64", "octet": "byte"}


def definition(kind: Any) -> str:
    """Return the definition of a message class in the format `ros2msg`, without comments.

    The definitions of all nested messages follow, each once. The format is that of
    https://mcap.dev/spec/registry#ros2msg.
    """
    parts, wanted, seen = [field_lines(kind)], list(_nested_types(kind)), set[str]()
    while wanted:
        name, inner = wanted.pop(0)
        if name not in seen:
            seen.add(name)
            parts.append(f"{_SEPARATOR}\nMSG: {name}\n{field_lines(inner)}")
            wanted += _nested_types(inner)
    return "".join(parts)


def field_lines(kind: Any) -> str:
    """Return one text with a line for each field of a message class: its type, its name.

    The types are written as in .msg files; an empty message has one line, for the field that rosidl
    adds to it.
    """
    types = kind.get_fields_and_field_types()
    return "".join(f"{ros2msg_type(types[name])} {name}\n" for name in types)


def ros2msg_type(kind: str) -> str:
    """Return a rosidl type as .msg files write it: `float64[<=5]` for `sequence<double, 5>`."""
    if found := _SEQUENCE.fullmatch(kind):
        most = f"<={found['most']}" if found["most"] else ""
        return f"{ros2msg_type(found['of'])}[{most}]"
    if found := _ARRAY.fullmatch(kind):
        return f"{ros2msg_type(found['of'])}[{found['size']}]"
    if found := _BOUNDED.fullmatch(kind):
        return f"{found['text']}<={found['most']}"
    return _PRIMITIVES.get(kind, kind)


def _nested_types(kind: Any) -> Iterator[tuple[str, Any]]:
    """Yield name and class of each field, or element of a field, that is a message."""
    for each in kind.get_fields_and_field_types().values():
        bare = element_of(each) or each
        if "/" in bare:
            yield bare, _load_class(bare)


def _load_class(name: str) -> Any:
    """Return the class of a message, or of a part of an action: `package/Action_Goal`."""
    found = message_classes.load_nested(name)
    action, _, part = base_name(name).rpartition("_")
    return found or getattr(message_classes.load(f"{package_of(name)}/action/{action}"), part)
