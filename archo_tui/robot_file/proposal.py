"""The parts of a robot file that fit what is on a graph, each with its reason. Pure functions."""

from __future__ import annotations

import posixpath
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

from archo_tui.robot_file import known_types
from archo_tui.robot_file.model import (
    BatteryTopic,
    CommandService,
    MotionTopic,
    PoseTopic,
)
from archo_tui.robot_file.proposed_goals import propose_goal, title_of, word_of
from archo_tui.robot_file.proposed_stops import is_stop, proposed_stops
from archo_tui.robot_file.reserved import unused_word
from archo_tui.robot_file.sighting import Sighting, served_reason, topic_reason

Part = Literal["battery", "motion", "pose", "goals", "stop", "commands", "diagnostics"]


class Entry(NamedTuple):
    """A part of the file that is proposed."""

    part: Part  # For `goals` or `commands`, one item of the list.
    value: Any  # The dataclass of the part; of `diagnostics`, the topic.
    reason: str  # Why it is proposed, in a line.
    is_sure: bool = True  # False: a comment, for a person to decide.


class Proposal(NamedTuple):
    """A proposed robot file."""

    namespace: str  # In which the names are.
    entries: tuple[Entry, ...]  # In the order of the file.
    unknown: tuple[str, ...]  # What was seen besides, a line each.


class SeveralRobots(Exception):
    """The error that several robots are on the graph, whose parts cannot be told apart."""

    def __init__(self, namespaces: Collection[str]) -> None:
        self.namespaces = tuple(sorted(namespaces))
        super().__init__(f"several robots are here, in {', '.join(self.namespaces)}")


def propose(seen: Sequence[Sighting], namespace: str = "/") -> Proposal:
    """Propose a robot file for what was seen in a namespace; SeveralRobots if it holds several.

    Parts that a person must decide, such as the STOP or a second battery, are not sure. With "/"
    the proposal has the namespace that the parts have in common.
    """
    own = [s for s in seen if s.types[0].partition("/")[0] not in known_types.OF_ROS]
    ordered = sorted(own, key=lambda sighting: (sighting.name.count("/"), sighting.name))
    found = [(entry, sighting) for sighting in ordered for entry in _entries(sighting)]
    robots = _robots(found)
    if len(robots) > 1:
        raise SeveralRobots(robots)
    chosen = [pair for part in _TOPICS for pair in _topics(found, part)]
    chosen += _mark_other_robots(_goals(found))
    stops = [sighting for sighting in ordered if is_stop(sighting)]
    chosen += [
        (Entry("stop", made, reason, is_sure=False), sighting)
        for made, reason, sighting in proposed_stops(stops)
    ]
    chosen += _mark_other_robots(pair for pair in found if pair[0].part == "commands")
    where = _common_namespace(chosen, namespace)
    chosen += [pair for pair in found if pair[0].part == "diagnostics"][:1]
    used: set[str] = set()
    entries = tuple(_with_file_names(entry, where, used) for entry, _ in chosen)
    used = {sighting.name for _, sighting in chosen}
    used |= {entry.value.release for entry, _ in chosen if entry.part == "stop"}
    unknown = tuple(_unknown_line(sighting) for sighting in ordered if sighting.name not in used)
    return Proposal(where, entries, unknown)


def _robots(found: Iterable[Found]) -> set[str]:
    """Return the namespaces of the robots if there are several; else an empty set.

    There are if namespaces have a battery, motion or goal of the same name and type below them:
    `/a/odom` and `/b/odom` are of two robots; `/odom` and `/odometry/filtered` are not.
    """
    by_rest: dict[tuple[str, str], set[str]] = {}
    for entry, sighting in found:
        first, slash, rest = sighting.name[1:].partition("/")
        if slash and entry.part in ("battery", "motion", "goals"):
            by_rest.setdefault((sighting.kind, rest), set()).add(f"/{first}")
    return set().union(*(names for names in by_rest.values() if len(names) > 1))


def _entries(sighting: Sighting) -> Iterator[Entry]:
    """Yield the entries for one sighting; their names are full, not yet those of the file."""
    if sighting.kind == "topic":
        yield from _battery(sighting)
        yield from _known_topic(sighting, "motion")
        yield from _known_topic(sighting, "pose")
        if known_types.DIAGNOSTICS in sighting.types:
            reason = topic_reason(sighting, known_types.DIAGNOSTICS)
            yield Entry("diagnostics", sighting.name, reason)
    elif sighting.kind == "action":
        goal = propose_goal(
            sighting.name, sighting.types, sighting.goal, sighting.feedback, sighting.result
        )
        if goal is not None:
            yield Entry("goals", goal, served_reason(sighting))
    elif not is_stop(sighting):
        yield from _command(sighting)


def _battery(sighting: Sighting) -> Iterator[Entry]:
    for kind in sighting.types:
        named = known_types.NAMED_BATTERIES.get(kind)
        is_named = named and any(word in sighting.name.lower() for word in named.words)
        fields = named.fields if named and is_named else known_types.BATTERIES.get(kind)
        if fields is None:
            continue
        reason = topic_reason(sighting, kind)
        value = sighting.values.get(fields.percentage.field)
        if isinstance(value, float) and value != value:
            reason += "; its percentage is not a number"
        elif isinstance(value, float) and value > 1.0 and fields.percentage.scale != 1.0:
            percentage = replace(fields.percentage, scale=1.0)
            fields = replace(fields, percentage=percentage)
            reason += f"; its percentage was {value:g}, so it is not 0 to 1 as its type says"
        yield Entry(
            "battery", BatteryTopic(sighting.name, {kind: fields}, low=known_types.LOW), reason
        )
        return


def _known_topic(sighting: Sighting, part: Literal["motion", "pose"]) -> Iterator[Entry]:
    """Yield the entry for a topic with its first type that the table has for the part, if any."""
    tables: Mapping[str, tuple[Any, Mapping[str, Any]]] = {
        "motion": (MotionTopic, known_types.MOTIONS),
        "pose": (PoseTopic, known_types.POSES),
    }
    make, known = tables[part]
    kind = next((kind for kind in sighting.types if kind in known), None)
    if kind is not None:
        yield Entry(part, make(sighting.name, {kind: known[kind]}), topic_reason(sighting, kind))


def _command(sighting: Sighting) -> Iterator[Entry]:
    """Yield a command for a service whose request has no field, or one bool; none for another.

    Whether it moves the robot is not known, so it asks first.
    """
    name = sighting.name
    made = CommandService(word_of(name), title_of(name), name, ask="always")
    toggle = next((known_types.TOGGLES[t] for t in sighting.types if t in known_types.TOGGLES), "")
    if toggle:
        made = replace(made, toggle={toggle: "ask"})
        yield Entry("commands", made, served_reason(sighting))
    elif sighting.goal == {} or any(kind in known_types.COMMANDS for kind in sighting.types):
        yield Entry("commands", made, served_reason(sighting))


_TOPICS: tuple[Literal["battery", "motion", "pose"], ...] = ("battery", "motion", "pose")
_KNOWN: Mapping[str, Iterable[str]] = {
    "battery": (*known_types.BATTERIES, *known_types.NAMED_BATTERIES),
    "motion": known_types.MOTIONS,
    "pose": known_types.POSES,
}
Found = tuple[Entry, Sighting]


def _topics(found: Iterable[Found], part: Literal["battery", "motion", "pose"]) -> list[Found]:
    """Return the topics that were found for a part, the best first; the others as comments.

    The best is one that a node publishes, of the type which the table names first.
    """
    known = list(_KNOWN[part])

    def rank(pair: Found) -> tuple[bool, int]:
        entry, sighting = pair
        return not sighting.nodes, known.index(next(iter(entry.value.types)))

    pairs = sorted((pair for pair in found if pair[0].part == part), key=rank)
    return [(entry._replace(is_sure=not place), s) for place, (entry, s) in enumerate(pairs)]


def _goals(found: Iterable[Found]) -> list[Found]:
    """Return the goals: those of the table in its order, those with a form, then the others."""
    known = list(known_types.GOALS)

    def rank(pair: Found) -> tuple[int, bool]:
        goal = pair[0].value
        return known.index(goal.type) if goal.type in known else len(known), not goal.form

    return sorted((pair for pair in found if pair[0].part == "goals"), key=rank)


def _mark_other_robots(chosen: Iterable[Found]) -> Iterator[Found]:
    """Yield goals and commands; those that may be another robot's are marked as not sure.

    `/tb2/dock` may be of another robot beside a `/dock` of its type, and the goals of two robots
    must not stand together.
    """
    known: set[tuple[str, tuple[str, ...]]] = set()
    for entry, sighting in chosen:
        known.add((sighting.name, sighting.types))
        same = sighting.name[sighting.name.find("/", 1) :]
        if sighting.name != same and (same, sighting.types) in known:
            reason = f"{entry.reason}: is it of another robot than {same}? Then leave it out"
            yield entry._replace(reason=reason, is_sure=False), sighting
        else:
            yield entry, sighting


def _common_namespace(chosen: Sequence[Found], namespace: str) -> str:
    """Return the namespace that the parts and their nodes have in common, unless one is given."""
    names = [name for _, sighting in chosen for name in (sighting.name, *sighting.nodes)]
    if not names:
        return namespace
    found = posixpath.commonpath([posixpath.dirname(name) for name in names])
    return found if namespace == "/" else namespace


def _with_file_names(entry: Entry, namespace: str, used: set[str]) -> Entry:
    """Return an entry with the robot file's names, and an unused id, added to `used`."""
    value = entry.value
    if entry.part == "diagnostics":
        return entry._replace(value=_relative(value, namespace))
    for attribute in ("topic", "action", "service", "release"):
        if name := getattr(value, attribute, ""):
            value = replace(value, **{attribute: _relative(name, namespace)})
    if entry.part in ("goals", "commands"):
        value = replace(value, id=unused_word(value.id, used))
        used |= {value.id, getattr(value, "off_word", value.id)}
    return entry._replace(value=value)


def _relative(name: str, namespace: str) -> str:
    """Return a full name without the namespace if it is below it; else the full name."""
    below = f"{namespace.rstrip('/')}/"
    return name.removeprefix(below) if name.startswith(below) else name


def _unknown_line(sighting: Sighting) -> str:
    lacking = sighting.kind != "topic" and sighting.goal is None
    why = ", which is not installed here" if lacking else ""
    return f"{sighting.kind} {sighting.name}: {', '.join(sighting.types)}{why}"
