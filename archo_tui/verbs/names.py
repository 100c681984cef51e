"""The names on the graph that a person types, and those that a shell offers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.nearest import nearest_hint
from archo_tui.robot.messages.typed import mapping, parse_all, texts_by_path
from archo_tui.robot.state.graph import TOPIC, Resource, in_namespace
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file import check
from archo_tui.station.station import Station
from archo_tui.verbs.verb import NotOnGraphError


def full_name(snapshot: Snapshot, name: str, found: Collection[str]) -> str:
    """Return the full name for a typed name that may lack its first `/` or the robot's namespace.

    A name that begins with `/` is complete. Any other is completed with the namespace, unless only
    `/` before it gives one of the names found.
    """
    if name.startswith("/"):
        return name
    inside, outside = in_namespace(snapshot.namespace, name), f"/{name}"
    return outside if outside in found and inside not in found else inside


def nearest_node_hint(name: str, nodes: Iterable[str]) -> str:
    """Return ` (nearest: NODE)`, without its first `/`, for a misspelt name of a node, or ""."""
    return nearest_hint(name.lstrip("/"), [node.lstrip("/") for node in nodes])


def is_elsewhere(snapshot: Snapshot, name: str) -> bool:
    """Return True if a full name lies outside of the robot's namespace."""
    return not name.startswith(in_namespace(snapshot.namespace, ""))


def type_of(what: str, name: str, found: Mapping[str, tuple[str, ...]]) -> str:
    """Return the one type of a name on the graph; raise ValueError."""
    if not found.get(name):
        near = nearest_hint(name, (other for other, kinds in found.items() if kinds))
        raise NotOnGraphError(f"no {what} {name} is on the graph{near}")
    kinds = found[name]
    if len(kinds) != 1:
        raise ValueError(f"{name} has several types: {', '.join(kinds)}")
    return kinds[0]


async def fields_of(
    station: Station, name: str, type_name: str, words: Sequence[str]
) -> dict[str, Any]:
    """Return the values that typed words give to the fields of a request or a goal.

    `FIELD=VALUE ...` gives parsed values by dotted path; a YAML mapping is returned unchecked.
    Fields that are left out keep their defaults. Raises ValueError.
    """
    fields = await in_daemon(station.robot.form, type_name)  # Reads files.
    if fields is None:
        raise ValueError(check.not_installed(name, type_name))
    if len(words) == 1 and words[0].startswith("{"):
        return mapping(words[0])
    return parse_all(fields, {}, texts_by_path(fields, {}, words, partial=True))


def find_node(snapshot: Snapshot, name: str, known: Collection[str] = ()) -> str:
    """Return the full name of a typed node; NotOnGraphError unless it is on the graph or known."""
    nodes = {*known, *(node.name for node in snapshot.nodes)}
    full = full_name(snapshot, name, nodes)
    if full not in nodes:
        raise NotOnGraphError(f"no node {full} is on the graph{nearest_node_hint(full, nodes)}")
    return full


def node_names(station: Station, _: Sequence[str]) -> Iterable[str]:
    """Return the nodes on the graph; a `Completer`, as the next one."""
    return [node.name for node in station.robot.snapshot.nodes]


def topic_names(station: Station, _: Sequence[str]) -> Iterable[str]:
    """Return the topics on the graph."""
    return [found.name for found in topics_of(station.robot.snapshot)]


def topics_of(snapshot: Snapshot) -> list[Resource]:
    """Return the topics on the graph, with their types and publishers."""
    return [found for found in snapshot.resources if found.kind == TOPIC]
