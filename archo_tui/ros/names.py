"""The parts of ROS names, `/namespace/name`, and of interface types, `package/kind/Name`."""

from __future__ import annotations

import re
from typing import NamedTuple

KINDS = ("msg", "srv", "action")
# As rosidl names packages and interfaces, of a bounded length: files and peers name any.
_TYPE = re.compile(r"([a-z][a-z0-9_]{0,99})/(msg|srv|action)/([A-Za-z][A-Za-z0-9_]{0,99})")


# As rcl and rmw want topics, services and actions, in a namespace or absolute.
_NAME = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)
_MAX_NAME = 247  # Characters: RMW_TOPIC_MAX_NAME_LENGTH.


def is_name(text: str) -> bool:
    """Return True if a topic, service or action can be called so."""
    return len(text) <= _MAX_NAME and _NAME.fullmatch(text) is not None


class InterfaceType(NamedTuple):
    """The parts of a type such as `std_msgs/msg/String`; its text is the type again."""

    package: str
    kind: str  # One of KINDS.
    name: str

    def __str__(self) -> str:
        return "/".join(self)


def parse_type(text: str) -> InterfaceType | None:
    """Return the parts of a type, each of at most 100 characters; None for any other text."""
    found = _TYPE.fullmatch(text)
    return None if found is None else InterfaceType(*found.groups())


def package_of(type_name: str) -> str:
    """Return the part before the first `/`: the package `std_msgs` of `std_msgs/msg/String`."""
    return type_name.partition("/")[0]


def base_name(name: str) -> str:
    """Return the part behind the last `/`: `String` of `std_msgs/msg/String`, `b` of `/a/b`."""
    return name.rpartition("/")[2]
