"""The proposal of a robot file for what is on a graph: its parts, the reason of each, and the text.

No STOP is ever proposed as sure: a person uncomments it. And none is proposed as a plain command,
which could be called without the care that a STOP takes.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path
from textwrap import indent
from typing import Any, Literal, NamedTuple

from archo_tui.robot_file import known_types
from archo_tui.robot_file.load import parse, plain
from archo_tui.robot_file.model import (
    BatteryTopic,
    CommandService,
    FormField,
    GoalKind,
    MotionTopic,
    PoseTopic,
    RemainingField,
    RobotFile,
    StopServices,
    TopicRule,
)
from archo_tui.robot_file.reserved import unused_word
from archo_tui.yaml_text import dump as yaml_dump


@dataclass(frozen=True)
class Sighting:
    """A topic, service or action that was seen on the graph."""

    kind: Literal["topic", "service", "action"]
    name: str
    types: tuple[str, ...]  # Usually one.
    nodes: tuple[str, ...] = ()  # Full names of those that publish or serve it.
    lifecycles: Mapping[str, str] = field(default_factory=dict)  # Of managed nodes, by node.
    was_listened_to: bool = True  # False for a topic whose type is not installed or not used.
    rate: float | None = None  # Messages in a second; None before the second one.
    # The primitive fields of the last message by dotted path.
    values: Mapping[str, Any] = field(default_factory=dict)
    # The types of all fields of the goal or request by dotted path; None if not installed, and for
    # a topic.
    goal: Mapping[str, str] | None = None
    feedback: Mapping[str, str] = field(default_factory=dict)
    result: Mapping[str, str] = field(default_factory=dict)


def topic_reason(sighting: Sighting, kind: str) -> str:
    """Return why a topic is proposed, in a line: its type, rate and publishers."""
    rate = f", {sighting.rate:.1f} Hz" if sighting.rate else ""
    rate = rate or (", too few messages to tell a rate" if sighting.values else ", no message came")
    by = f", published by {nodes_text(sighting)}" if sighting.nodes else ", which nobody publishes"
    others = [other for other in sighting.types if other != kind]
    more = f" (and of {' and '.join(others)})" if others else ""
    came = rate if sighting.nodes and sighting.was_listened_to else ""
    return f"{sighting.name} is a {kind}{more}{came}{by}"


def served_reason(sighting: Sighting) -> str:
    """Return why a service or action is proposed, in a line: its types, and who serves it."""
    twice = ": several serve it, so it is refused" if len(sighting.nodes) > 1 else ""
    by = f" served by {nodes_text(sighting)}" if sighting.nodes else ""
    return f"{sighting.name} is a {', '.join(sighting.types)}{by}{twice}"


def nodes_text(sighting: Sighting) -> str:
    """Return the nodes that publish or serve a sighting; of a managed node also its state."""
    states = sighting.lifecycles
    return ", ".join(f"{n} ({states[n]})" if n in states else n for n in sighting.nodes)


# Goals, from the fields of their types.

_FRAME = "map"  # REP 105's fixed frame, in which goals of navigation are given.
# In the name of a feedback field: not in that of `left_wheel_speed`.
_REMAINING = re.compile(r"remaining|to_go|(^|_)left$")
_MESSAGES = ("message", "final_message", "error_msg")  # Names of a result field with words.
_NUMBERS = re.compile(r"u?int(8|16|32|64)|octet|float|double")
_SIMPLE = re.compile(rf"{_NUMBERS.pattern}|boolean|w?string(<\d+>)?")
_STAMP = ("builtin_interfaces/Time", "builtin_interfaces/Duration")  # Their zero is a default.


def propose_goal(
    action: str,
    types: Sequence[str],
    goal: Mapping[str, str] | None,
    feedback: Mapping[str, str],
    result: Mapping[str, str],
) -> GoalKind | None:
    """Propose the entry of a robot file for an action; None if its goal is unknown or fits no form.

    Goal (None if its type is not installed), feedback and result are types by dotted path.
    """
    known = next((known_types.GOALS[kind] for kind in types if kind in known_types.GOALS), None)
    if known is not None:
        return replace(known, action=action)
    form = None if goal is None else _form(goal)
    if form is None:
        return None
    fields, fixed = form
    return GoalKind(
        word_of(action),
        title_of(action),
        action,
        types[0],
        form=fields,
        fixed=fixed,
        remaining=_remaining(feedback),
        message=next((name for name in _MESSAGES if result.get(name) == "string"), ""),
    )


def _form(goal: Mapping[str, str]) -> tuple[dict[str, FormField], dict[str, str]] | None:
    """Return the fields to type and the fixed values of a goal; None if it has a list to fill.

    A pose is typed as x, y and yaw, in the frame that navigation uses. Stamps keep their zero.
    """
    fields: dict[str, FormField] = {}
    fixed: dict[str, str] = {}
    done: list[str] = []  # The paths of messages whose fields are dealt with.
    for path, kind in goal.items():
        if any(path.startswith(f"{message}.") for message in done):
            continue
        if kind in known_types.GOAL_POSES:
            pose, frame = known_types.GOAL_POSES[kind]
            before = f"{path}.{pose}"
            fields[f"{before}position.x"] = FormField(_label("x", path, goal), unit="m")
            fields[f"{before}position.y"] = FormField(_label("y", path, goal), unit="m")
            yaw = FormField(_label("yaw", path, goal), -360, 360, "deg", "yaw")
            fields[f"{before}orientation"] = yaw
            if frame:
                fixed[f"{path}.{frame}"] = _FRAME
            done.append(path)
        elif kind in _STAMP:
            done.append(path)
        elif _SIMPLE.fullmatch(kind):
            fields[path] = FormField()
        elif "/" not in kind or kind.endswith("]") or kind.startswith("sequence"):
            return None
    return fields, fixed


def _label(word: str, path: str, goal: Mapping[str, str]) -> str:
    """Return the label of a pose's field: the word, behind the pose's path if there are several."""
    poses = [other for other, kind in goal.items() if kind in known_types.GOAL_POSES]
    outer = [other for other in poses if not any(other.startswith(f"{p}.") for p in poses)]
    return word if len(outer) == 1 else f"{path} {word}"


def _remaining(feedback: Mapping[str, str]) -> RemainingField | None:
    """Return the first number of a feedback whose name says that it is what is left, or None."""
    for path, kind in feedback.items():
        name = path.rpartition(".")[2]
        if _NUMBERS.fullmatch(kind) and _REMAINING.search(name):
            return RemainingField(path, unit="m" if "distance" in name else "")
    return None


def word_of(name: str) -> str:
    """Return the word that is typed for an action or service: `/tb1/Go_Home` is go_home."""
    return name.rpartition("/")[2].lower().strip("_")


def title_of(name: str) -> str:
    """Return the title for an action or service: `/tb1/go_home` is Go home."""
    words = name.rpartition("/")[2].replace("_", " ").split()
    return " ".join(words).capitalize() or name


# The STOP, and what releases it.


def proposed_stops(
    seen: Sequence[Sighting],
) -> Iterator[tuple[StopServices, str, Sighting]]:
    """Yield an entry for each service that may be the STOP, the reason, and its sighting.

    The entry names the service that may release it, if one is found; a service of a type in the
    table of known STOPs releases itself.
    """
    releases = [s for s in seen if _is_release(s)]
    for sighting in seen:
        if sighting in releases:
            continue
        kind = next((t for t in sighting.types if t in known_types.STOPS), "")
        stop = known_types.STOPS.get(kind, StopServices(""))
        if kind:
            made = replace(stop, service=sighting.name, release=sighting.name)
        else:
            release = _release(sighting, len(seen) - len(releases), releases)
            made = replace(release, service=sighting.name)
        reason = f"{served_reason(sighting)}: is this the STOP? Then uncomment it"
        if not kind and sighting.goal:
            fields = ", ".join(f"{path} ({type_})" for path, type_ in sighting.goal.items())
            reason += f", and say as `request` what is sent: {fields}"
        yield made, reason, sighting


def is_stop(sighting: Sighting) -> bool:
    """Return True for a service that may stop the robot, or release a stop, by type or name."""
    if sighting.kind != "service":
        return False
    return (
        not known_types.STOP_TYPES.isdisjoint(sighting.types)
        or any(word in sighting.name.lower() for word in known_types.STOP_WORDS)
        or not _words(sighting.name).isdisjoint(known_types.STOP_WHOLE_WORDS)
    )


def _is_release(sighting: Sighting) -> bool:
    """Return True if a service may release a stop; only its own name counts, not its namespace."""
    own_name = sighting.name.rpartition("/")[2].lower()
    return any(word in own_name for word in known_types.RELEASE_WORDS)


def _release(stop: Sighting, stops: int, releases: Sequence[Sighting]) -> StopServices:
    """Return an entry with the service that may release a stop, if any; `service` is still empty.

    The service is beside or below the stop, and shares the most words with the stop's name. One
    with further words releases something else: `clear_brake_stop` no emergency stop. If there is
    only one stop and one release there, they belong together.
    """
    beside = stop.name.rpartition("/")[0]
    words = _words(stop.name.removeprefix(beside))
    near = [
        (_words(release.name.removeprefix(beside)) - {*known_types.RELEASE_WORDS}, release)
        for release in releases
        if release.name.rpartition("/")[0] in (beside, stop.name)
    ]
    fitting = [pair for pair in near if pair[0] <= words]
    if not fitting and stops == len(near) == 1:
        fitting = near
    if not fitting:
        return StopServices("")
    _, best = max(fitting, key=lambda pair: len(pair[0]))
    toggle = next((known_types.TOGGLES[t] for t in best.types if t in known_types.TOGGLES), "")
    return StopServices("", release=best.name, release_request={toggle: True} if toggle else {})


def _words(name: str) -> set[str]:
    """Return the words of a name in lower case: of `/softStop/kill_switch` soft, stop, kill ..."""
    parted = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    return set(re.findall(r"[a-z]+", parted.lower()))


# The file.

Part = Literal["battery", "motion", "pose", "goals", "stop", "commands", "diagnostics", "topics"]


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
    chosen += [pair for pair in found if pair[0].part == "topics"]
    used: set[str] = set()
    entries = tuple(_with_file_names(entry, where, used) for entry, _ in chosen)
    used = {sighting.name for entry, sighting in chosen if entry.part != "topics"}
    used |= {entry.value.release for entry, _ in chosen if entry.part == "stop"}
    unknown = tuple(_unknown_line(sighting) for sighting in ordered if sighting.name not in used)
    return Proposal(where, entries, unknown)


def _robots(found: Iterable[Match]) -> set[str]:
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
        if not _is_initial_pose(sighting):
            yield from _known_topic(sighting, "pose")
        if known_types.DIAGNOSTICS in sighting.types:
            reason = topic_reason(sighting, known_types.DIAGNOSTICS)
            yield Entry("diagnostics", sighting.name, reason)
        yield from _topic_rules(sighting)
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


def _is_initial_pose(sighting: Sighting) -> bool:
    return known_types.INITIAL_POSE in sighting.types and "initial" in sighting.name.lower()


def _topic_rules(sighting: Sighting) -> Iterator[Entry]:
    """Yield a rule by which `pub` asks nothing; for a topic of texts a person has to confirm it."""
    rule = TopicRule(sighting.name, moves=False)
    listens = f"{sighting.name} is a {sighting.types[0]}, and `pub` asks nothing before it:"
    if _is_initial_pose(sighting):
        yield Entry("topics", rule, f"{listens} it only tells where the robot is")
    elif known_types.TEXT in sighting.types:
        reason = f"{listens} does no text move the robot? Then uncomment it"
        yield Entry("topics", rule, reason, is_sure=False)


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
Match = tuple[Entry, Sighting]


def _topics(found: Iterable[Match], part: Literal["battery", "motion", "pose"]) -> list[Match]:
    """Return the topics that were found for a part, the best first; the others as comments.

    The best is one that a node publishes, of the type which the table names first.
    """
    known = list(_KNOWN[part])

    def rank(pair: Match) -> tuple[bool, int]:
        entry, sighting = pair
        return not sighting.nodes, known.index(next(iter(entry.value.types)))

    pairs = sorted((pair for pair in found if pair[0].part == part), key=rank)
    return [(entry._replace(is_sure=not place), s) for place, (entry, s) in enumerate(pairs)]


def _goals(found: Iterable[Match]) -> list[Match]:
    """Return the goals: those of the table in its order, those with a form, then the others."""
    known = list(known_types.GOALS)

    def rank(pair: Match) -> tuple[int, bool]:
        goal = pair[0].value
        return known.index(goal.type) if goal.type in known else len(known), not goal.form

    return sorted((pair for pair in found if pair[0].part == "goals"), key=rank)


def _mark_other_robots(chosen: Iterable[Match]) -> Iterator[Match]:
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


def _common_namespace(chosen: Sequence[Match], namespace: str) -> str:
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


# Its text.

_LISTS = ("goals", "commands", "topics")
_NO_STOP = (
    "No service that looks like a STOP was seen: without one, ctrl+x cancels every goal instead."
)
_MOST = 200  # Unknown topics, services and actions that are listed; the rest is counted.


def text_of(proposal: Proposal, head: str) -> str:
    """Return the text of a proposed robot file, with a comment above each part.

    Parts that are not sure, `head` and the first 200 unknown lines become comments. ArchoError if
    the text would not load.
    """
    name = proposal.namespace.rpartition("/")[2] or RobotFile.name
    parts = [
        _comment(head),
        yaml_dump.block({"version": RobotFile.version, "name": name}),
        *_parts(proposal.entries),
        "" if any(entry.part == "stop" for entry in proposal.entries) else _comment(_NO_STOP),
        *_unknown(proposal.unknown),
    ]
    text = "".join(parts)
    parse(text, Path("the proposed file"))
    return text


def _parts(entries: tuple[Entry, ...]) -> Iterator[str]:
    for part, group in groupby(entries, key=lambda entry: entry.part):
        if part in _LISTS:
            items = list(group)
            is_any_sure = any(entry.is_sure for entry in items)
            yield f"{part}:\n" if is_any_sure else _comment(f"{part}:")
            for entry in items:
                item = yaml_dump.mixed([plain(entry.value)])
                item = item if entry.is_sure else _comment(item)
                yield indent(_comment(entry.reason) + item, "  ")
            continue
        for entry in group:
            value = plain(entry.value)
            # `mixed` writes a mapping of one name in braces, which nothing can follow in a file.
            write = yaml_dump.block if isinstance(value, str) else yaml_dump.mixed
            text = write({part: value})
            yield _comment(entry.reason) + (text if entry.is_sure else _comment(text))


def _unknown(lines: tuple[str, ...]) -> Iterator[str]:
    if not lines:
        return
    yield _comment("Seen besides, and not described:")
    yield "".join(_comment(f"  {line}") for line in lines[:_MOST])
    if len(lines) > _MOST:
        yield _comment(f"  and {len(lines) - _MOST} more")


def _comment(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())
