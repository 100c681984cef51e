"""The verb for the definition of a message, service or action type."""

from __future__ import annotations

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.nearest import nearest_hint
from archo_tui.robot.messages.definitions import definition_text, names_in
from archo_tui.robot.outcome import Outcome, Report
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.ros_names import KINDS, base_name, package_of, parse_type
from archo_tui.station.station import Station
from archo_tui.verbs.base import DISCOVERY_TIME, Argument, Values, Verb


class ShowInterface(Verb):
    """The verb `interface`: show the definition of a type, as `ros2 interface show` does.

    A type without its package is looked for on the graph, any other among those installed.
    """

    id, title, tells = "interface", "Interface", True
    help = "Show the definition of a message, service or action type, with its comments"
    arguments = (Argument("type"),)

    def is_ready(self, station: Station, values: Values) -> bool:
        """Return True once the graph tells enough to find the type, or to name a similar one."""
        known, typed = _types_on_graph(station.robot.snapshot), values["type"]
        is_found = bool(known) if "/" in typed else typed in map(base_name, known)
        return is_found or station.age >= DISCOVERY_TIME

    async def run(self, station: Station, values: Values) -> Outcome:
        known = _types_on_graph(station.robot.snapshot)
        name, text = await in_daemon(_find, values["type"], known)
        return Report.of(text, {"type": name, "definition": text})


def _types_on_graph(snapshot: Snapshot) -> list[str]:
    return sorted({kind for resource in snapshot.resources for kind in resource.types})


def _find(typed: str, known: list[str]) -> tuple[str, str]:
    """Return the full name and the definition of a typed type; ArchoError unless one fits."""
    meant = _candidates(typed, known)
    found = {name: text for name in meant if (text := definition_text(name)) is not None}
    if len(found) == 1:
        return next(iter(found.items()))
    if len(found) > 1:
        raise ArchoError(f"{typed} has several meanings: {', '.join(found)}")
    absent = next((name for name in meant if name in known), "")
    if absent:
        raise ArchoError(f"{absent} is on the graph, and not installed here")
    package = package_of(typed) if "/" in typed else ""
    others = names_in(package) if parse_type(f"{package}/msg/A") else []
    if package and not others and not any(package_of(name) == package for name in known):
        near = nearest_hint(package, map(package_of, known))
        raise ArchoError(f"no package of interfaces {package} is installed here{near}")
    near = _nearest(typed, [*known, *others])
    raise ArchoError(f"no type {typed} is {'installed here' if package else 'on the graph'}{near}")


def _candidates(typed: str, known: list[str]) -> list[str]:
    """Return the full names `package/kind/Name` that a type may stand for, existing or not."""
    if "/" not in typed:
        return [name for name in known if base_name(name) == typed]
    if typed.count("/") == 1:
        package, name = typed.split("/")
        return [f"{package}/{kind}/{name}" for kind in KINDS]
    return [typed]


def _nearest(typed: str, known: list[str]) -> str:
    """Return ` (nearest: TYPE)`, with as many parts as were typed, for a misspelt type, or ""."""
    if "/" in typed:
        parts = [name.split("/") for name in known]
        short = [f"{package}/{name}" for package, _, name in filter(lambda p: len(p) == 3, parts)]
        return nearest_hint(typed, known if typed.count("/") > 1 else short)
    return nearest_hint(typed, map(base_name, known))
