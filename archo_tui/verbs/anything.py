"""What is typed for an action or a service that no robot file names."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from archo_tui.daemon_threads import in_daemon
from archo_tui.nearest import nearest_hint
from archo_tui.robot import forms
from archo_tui.robot.state import Leaf, Snapshot, in_namespace
from archo_tui.robot.typed_request import mapping
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import FormField
from archo_tui.station.station import Station
from archo_tui.verbs.base import THERE


def full_name(snapshot: Snapshot, name: str, found: Collection[str]) -> str:
    """Return what is meant by a name that may lack its first `/`, or the robot's namespace.

    A name that begins with `/` is what it says, as in ROS. One that does not is looked for in the
    robot's namespace first.
    """
    if name.startswith("/"):
        return name
    inside, outside = in_namespace(snapshot.namespace, name), f"/{name}"
    return outside if outside in found and inside not in found else inside


def nearest_node(name: str, nodes: Iterable[str]) -> str:
    """Return the hint of `nearest_hint`, with the node as it is typed: without its first `/`."""
    return nearest_hint(name.lstrip("/"), [node.lstrip("/") for node in nodes])


def is_elsewhere(snapshot: Snapshot, name: str) -> bool:
    """Return whether a full name lies outside of the robot's namespace."""
    return not name.startswith(in_namespace(snapshot.namespace, ""))


def is_known(station: Station, name: str, found: Collection[str]) -> bool:
    """Return whether it is known by now what serves a full name.

    Args:
        station: Of what lies outside of its namespace a snapshot says nothing: it has time to be
            found, and is then asked for by its name.
        name: The full name of a service or an action.
        found: The names of its kind in the robot's namespace.
    """
    is_out = is_elsewhere(station.robot.snapshot, name)
    return name in found or (is_out and station.age >= THERE)


def type_of(what: str, name: str, found: Mapping[str, tuple[str, ...]]) -> str:
    """The type that it has on the graph. Raises ValueError when there is none, or several."""
    if not found.get(name):
        near = nearest_hint(name, (other for other, kinds in found.items() if kinds))
        raise ValueError(f"no {what} {name} is on the graph{near}")
    kinds = found[name]
    if len(kinds) != 1:
        raise ValueError(f"{name} has several types: {', '.join(kinds)}")
    return kinds[0]


async def fields_of(
    station: Station, name: str, type_name: str, words: Sequence[str]
) -> dict[str, Any]:
    """The values of `field=value ...`, or of one YAML mapping, by dotted path.

    Fields that are left out keep what the message has by itself. Raises ValueError.
    """
    leaves = await in_daemon(station.robot.form, type_name)  # reads files
    if leaves is None:
        raise ValueError(mismatch.not_installed(name, type_name))
    if len(words) == 1 and words[0].startswith("{"):
        return mapping(words[0])
    by_path = {leaf.path: leaf for leaf in leaves}
    found: dict[str, Any] = {}
    for word in words:
        path, equals, text = word.partition("=")
        if not equals or path not in by_path or path in found:
            raise ValueError(f"expected {_expected(leaves)}, not {word[:_SHOWN]}")
        found[path] = forms.parse(by_path[path], FormField(), text)
    return found


_SHOWN = 40  # characters of a wrong word that are shown


def _expected(leaves: Sequence[Leaf]) -> str:
    return " ".join(f"{leaf.path}=..." for leaf in leaves) or "no values"
