"""The classes of interfaces by their names, and the types of their fields as rosidl writes them.

The graph and files name the packages, so nothing but a package of interfaces is imported: any other
could do anything, as `import antigravity` opens a browser.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from archo_tui.robot_file.model import DIAGNOSTICS, RobotFile
from archo_tui.ros.names import KINDS, InterfaceType, base_name, package_of, parse_type

EMPTY = "structure_needs_at_least_one_member"  # The field that rosidl adds to an empty message.
TIME, DURATION = "builtin_interfaces/Time", "builtin_interfaces/Duration"

# The lowest and the highest value of each integer type.
INTEGERS = {
    f"{sign}int{bits}": (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
} | {"octet": (0, 255)}

NESTED = re.compile(r"\w+/\w+")
# sequence<string<8>, 3> holds at most three texts of at most eight characters each.
ARRAY = re.compile(r"sequence<(?P<of>.+?)(?:, *(?P<most>\d+))?>|(?P<each>.+)\[(?P<size>\d+)\]")
STRING = re.compile(r"(?P<text>w?string)(?:<(?P<most>\d+)>)?")
_MSG_NAMES = {"boolean": "bool", "float": "float32", "double": "float64", "octet": "byte"}


class TypedField(NamedTuple):
    """A primitive field of a message, or an array of anything, with its value or its default."""

    path: str  # Dotted.
    type: str  # As rosidl writes it.
    default: Any


def load_class(type_name: str) -> Any:
    """Import the class of a type such as `std_msgs/msg/String`; None if it is not installed."""
    parts = parse_type(type_name)
    if parts is None:
        return None
    module = f"{parts.package}.{parts.kind}"
    try:
        if module not in sys.modules and not _is_interfaces(parts.package):
            return None
        return getattr(importlib.import_module(module), parts.name)
    except (ImportError, AttributeError, ValueError):
        return None


def load_all(file: RobotFile) -> None:
    """Import the classes that a robot file names, and those that a STOP or a command usually has.

    On the ROS thread a STOP would wait for an import from a slow disk. The types of services are
    known on the graph only: most are of `std_srvs`, or of a package with an action of the robot.
    """
    topics = [file.battery, file.motion, file.pose]
    types = {kind for topic in topics if topic is not None for kind in topic.types}
    types |= {gauge.type for gauge in file.gauges} | {goal.type for goal in file.goals}
    if file.diagnostics:
        types.add(DIAGNOSTICS)
    for name in types:
        load_class(name)
    for package in {"std_srvs", *(package_of(goal.type) for goal in file.goals)}:
        load_class(f"{package}/srv/Trigger")  # And with it all of the services.


def _is_interfaces(package: str) -> bool:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.submodule_search_locations is None:
        return False
    places = [*spec.submodule_search_locations, spec.origin or ""]
    # Any kind will do: a package of the user may add one kind to a built-in package.
    return any((Path(place) / kind).is_dir() for place in places for kind in KINDS)


def name_of(made: Any) -> str:
    """Return the type of an interface's class: `std_msgs/msg/String`."""
    package, kind, *_ = made.__module__.split(".")
    return str(InterfaceType(package, kind, made.__name__))


def load_nested(type_name: str) -> Any:
    """Import the class of a field's type, `std_msgs/Header` or `pkg/Action_Goal`, or None."""
    package, name = package_of(type_name), base_name(type_name)
    found = load_class(f"{package}/msg/{name}")
    action, _, part = name.rpartition("_")
    if found is None and action:
        return getattr(load_class(f"{package}/action/{action}"), part, None)
    return found


def kinds(message: Any) -> dict[str, str]:
    """Return the types of a message's own fields, or of its class's, by name."""
    found = message.get_fields_and_field_types()
    return {name: kind for name, kind in found.items() if name != EMPTY}


@cache
def element_of(kind: str) -> str | None:
    """Return the type of the elements of an array type; None for any other type."""
    found = ARRAY.fullmatch(kind)
    return None if found is None else found["of"] or found["each"]


def ros2msg_type(kind: str) -> str:
    """Return a type as .msg files write it: `float64[<=5]` for `sequence<double, 5>`."""
    if found := ARRAY.fullmatch(kind):
        size = found["size"] or (f"<={found['most']}" if found["most"] else "")
        return f"{ros2msg_type(found['of'] or found['each'])}[{size}]"
    if (found := STRING.fullmatch(kind)) and found["most"]:
        return f"{found['text']}<={found['most']}"
    return _MSG_NAMES.get(kind, kind)


def walk(message: Any, before: str = "") -> Iterator[TypedField]:
    """Yield every field with its value: nested messages first, then their fields."""
    for name, kind in kinds(message).items():
        value = getattr(message, name)
        yield TypedField(before + name, kind, value)
        if NESTED.fullmatch(kind):
            yield from walk(value, f"{before}{name}.")


def leaves(message: Any) -> Iterator[TypedField]:
    """Yield each field that is no message, with its value as rclpy has it."""
    return (field for field in walk(message) if not NESTED.fullmatch(field.type))


def field_types(message: Any) -> dict[str, str]:
    """Return the type of every field by its dotted path, nested messages included."""
    return {field.path: field.type for field in walk(message)}


@cache
def field_paths(message_class: Any) -> frozenset[str]:
    """Return the dotted paths of all fields of a message class."""
    return frozenset(field_types(message_class()))
