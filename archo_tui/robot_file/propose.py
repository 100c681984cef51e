"""The proposal of a robot file for what is on a graph: what types mean, the parts, and the text.

No STOP is ever proposed as sure: a person uncomments it. And none is proposed as a plain command,
which could be called without the care that a STOP takes.

What a type means is in the tables here. Their sources are the comments in the interface files of
sensor_msgs, nav_msgs, std_srvs, nav2_msgs and irobot_create_msgs.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from textwrap import indent
from typing import Any, Literal, NamedTuple

from archo_tui.base.yaml_text import dump as yaml_dump
from archo_tui.robot_file.load import parse, plain
from archo_tui.robot_file.model import (
    DIAGNOSTICS,
    BatteryFields,
    BatteryTopic,
    CommandService,
    FormField,
    GoalKind,
    MessageField,
    MotionFields,
    MotionTopic,
    PoseFields,
    PoseTopic,
    RemainingField,
    RobotFile,
    StopServices,
    TopicRule,
)
from archo_tui.robot_file.reserved import unused_word
from archo_tui.ros.names import base_name, package_of

_LOW = 20.0  # Percent: below it the charge of a battery is called low; our choice.
# Of sensor_msgs/msg/BatteryState: constants POWER_SUPPLY_STATUS_CHARGING and _DISCHARGING.
_CHARGING, _DISCHARGING = 1, 2
# These are a battery only if the name of their topic says so, by one of the words.
_NUMBER_MESSAGES = ("std_msgs/msg/Float32", "std_msgs/msg/Float64")
_BATTERY_WORDS = ("battery", "charge", "soc")
_BATTERIES: Mapping[str, BatteryFields] = {
    # `percentage` is 0 to 1 by its comment; a robot that sends 0 to 100 is seen by its values.
    "sensor_msgs/msg/BatteryState": BatteryFields(
        percentage=MessageField("percentage", scale=100.0),
        voltage=MessageField("voltage"),
        charging=MessageField("power_supply_status", equals=_CHARGING),
        discharging=MessageField("power_supply_status", equals=_DISCHARGING),
    ),
    "archo_interfaces/msg/BatteryStatus": BatteryFields(
        percentage=MessageField("percentage"),
        voltage=MessageField("voltage"),
        charging=MessageField("is_charging"),
    ),
    **dict.fromkeys(_NUMBER_MESSAGES, BatteryFields(MessageField("data"))),
}
_MOTIONS: Mapping[str, MotionFields] = {
    "archo_interfaces/msg/MotorStatus": MotionFields(
        count=MessageField("encoder_ticks", unit="ticks"),
        speed=MessageField("speed", unit="m/s"),
        moving=MessageField("moving"),
        stopped=MessageField("emergency_stopped"),
    ),
    "nav_msgs/msg/Odometry": MotionFields(
        speed=MessageField("twist.twist.linear.x", unit="m/s"),
        moving=(
            MessageField("twist.twist.linear.x", beyond=0.01),
            MessageField("twist.twist.angular.z", beyond=0.02),
        ),
    ),
}
_POSE = PoseFields(
    x=MessageField("pose.pose.position.x"),
    y=MessageField("pose.pose.position.y"),
    orientation=MessageField("pose.pose.orientation"),
    frame=MessageField("header.frame_id"),
)
_INITIAL_POSE, _TEXT = "geometry_msgs/msg/PoseWithCovarianceStamped", "std_msgs/msg/String"
# The pose of localization is in the frame of the map; odometry drifts.
_POSES: Mapping[str, PoseFields] = dict.fromkeys((_INITIAL_POSE, "nav_msgs/msg/Odometry"), _POSE)

Part = Literal["battery", "motion", "pose", "goals", "stop", "commands", "diagnostics", "topics"]
# What makes a part of a topic, and the fields of the types that it may have, the best type first.
_TOPICS: Mapping[Part, tuple[Callable[..., Any], Mapping[str, Any]]] = {
    "battery": (partial(BatteryTopic, low=_LOW), _BATTERIES),
    "motion": (MotionTopic, _MOTIONS),
    "pose": (PoseTopic, _POSES),
}
READ = frozenset({*_BATTERIES, *_MOTIONS, *_POSES})  # Message types whose values are looked at.

# The first one that is found has its form on the screen.
_GOALS: Mapping[str, GoalKind] = {
    kind.type: kind
    for kind in (
        GoalKind(
            id="navigate",
            title="Go to pose",
            noun="pose",
            action="navigate_to_pose",
            type="nav2_msgs/action/NavigateToPose",
            form={
                "pose.pose.position.x": FormField("x", unit="m"),
                "pose.pose.position.y": FormField("y", unit="m"),
                "pose.pose.orientation": FormField("yaw", -360, 360, "deg", "yaw"),
            },
            fixed={"pose.header.frame_id": "map"},
            remaining=RemainingField("distance_remaining", unit="m"),
        ),
        GoalKind(
            id="shelf",
            title="Go to shelf",
            noun="shelf",
            action="move_to_shelf",
            type="archo_interfaces/action/MoveToShelf",
            form={"shelf_number": FormField("Shelf", low=1)},
            remaining=RemainingField("distance_remaining", unit="m"),
            message="final_message",
        ),
        GoalKind("dock", "Dock", "dock", "irobot_create_msgs/action/Dock", noun="dock"),
        GoalKind("undock", "Undock", "undock", "irobot_create_msgs/action/Undock"),
    )
}
# Messages within a goal that are typed as x, y and yaw: within each, the beginning of the paths of
# position and orientation, and the path of the frame; "" for none.
_GOAL_POSES: Mapping[str, tuple[str, str]] = {
    "geometry_msgs/PoseStamped": ("pose.", "header.frame_id"),
    "geometry_msgs/Pose": ("", ""),
}
_FRAME = "map"  # REP 105's fixed frame, in which goals of navigation are given.
# In the name of a feedback field: not in that of `left_wheel_speed`.
_REMAINING = re.compile(r"remaining|to_go|(^|_)left$")
_MESSAGES = ("message", "final_message", "error_msg")  # Names of a result field with words.
_NUMBERS = re.compile(r"u?int(8|16|32|64)|octet|float|double")
_SIMPLE = re.compile(rf"{_NUMBERS.pattern}|boolean|w?string(<\d+>)?")
_STAMP = ("builtin_interfaces/Time", "builtin_interfaces/Duration")  # Their zero is a default.

# Packages of services and topics that nodes have for ROS itself; a robot file names none of them.
_OF_ROS = frozenset({"lifecycle_msgs", "rcl_interfaces", "type_description_interfaces"})
_COMMANDS = {"std_srvs/srv/Trigger", "std_srvs/srv/Empty"}  # Their requests have no field.
_TOGGLE, _TOGGLE_FIELD = "std_srvs/srv/SetBool", "data"
_E_STOP = "irobot_create_msgs/srv/EStop"  # A STOP, whatever its name.
# What a service of the type sends to stop and to release, if it is a STOP.
_STOPS: Mapping[str, StopServices] = {
    _E_STOP: StopServices("e_stop", {"e_stop_on": True}, "e_stop", {"e_stop_on": False}),
    _TOGGLE: StopServices("", {_TOGGLE_FIELD: True}, "", {_TOGGLE_FIELD: False}),
}
# In the name of a service: a STOP, however the words are joined (`softStop`, `stopmotors`).
_STOP_WORDS = ("stop", "halt", "emergency")
# As a word of its own only: "skill" is no kill switch.
_STOP_WHOLE_WORDS = {"kill", "killswitch", "panic", "freeze", "abort"}
_RELEASE_WORDS = {"release", "reset", "clear", "unlock", "resume", "unhalt"}


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

    @property
    def is_stop(self) -> bool:
        """True for a service that may stop the robot, or release a stop, by type or name."""
        is_named = any(word in self.name.lower() for word in _STOP_WORDS)
        is_named = is_named or not _words(self.name).isdisjoint(_STOP_WHOLE_WORDS)
        return self.kind == "service" and (_E_STOP in self.types or is_named)

    @property
    def is_initial_pose(self) -> bool:
        """True for a topic on which people tell where the robot is."""
        return _INITIAL_POSE in self.types and "initial" in self.name.lower()

    @property
    def word(self) -> str:
        """The word that is typed for an action or service: `/tb1/Go_Home` is go_home."""
        return base_name(self.name).lower().strip("_")

    @property
    def title(self) -> str:
        """The title for an action or service: `/tb1/go_home` is Go home."""
        words = base_name(self.name).replace("_", " ").split()
        return " ".join(words).capitalize() or self.name

    def reason(self, kind: str = "") -> str:
        """Return why it is proposed, in a line; of a topic, as one of that type."""
        states = self.lifecycles
        nodes = ", ".join(f"{n} ({states[n]})" if n in states else n for n in self.nodes)
        if self.kind != "topic":
            twice = ": several serve it, so it is refused" if len(self.nodes) > 1 else ""
            by = f" served by {nodes}" if nodes else ""
            return f"{self.name} is a {', '.join(self.types)}{by}{twice}"
        others = " and ".join(other for other in self.types if other != kind)
        more = f" (and of {others})" if others else ""
        if not nodes:
            return f"{self.name} is a {kind}{more}, which nobody publishes"
        came = f", {self.rate:.1f} Hz" if self.rate else ", no message came"
        if self.values and not self.rate:
            came = ", too few messages to tell a rate"
        came = came if self.was_listened_to else ""
        return f"{self.name} is a {kind}{more}{came}, published by {nodes}"


class Entry(NamedTuple):
    """A part of the file that is proposed."""

    part: Part  # For `goals`, `commands` or `topics`, one item of the list.
    value: Any  # The dataclass of the part; of `diagnostics`, the topic.
    sighting: Sighting
    reason: str  # Why it is proposed, in a line.
    is_sure: bool = True  # False: a comment, for a person to decide.
    rank: tuple[int, bool] = (0, False)  # Of those of a part, the lowest is the best.


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


_PARTS: tuple[Part, ...] = (
    *("battery", "motion", "pose", "goals", "stop", "commands", "diagnostics", "topics"),
)
_LISTS = ("goals", "commands", "topics")


def propose(seen: Sequence[Sighting], namespace: str = "/") -> Proposal:
    """Propose a robot file for what was seen in a namespace; SeveralRobots if it holds several.

    Parts that a person must decide, such as the STOP or a second battery, are not sure. With "/"
    the proposal has the namespace that the parts have in common.
    """
    own = [sighting for sighting in seen if package_of(sighting.types[0]) not in _OF_ROS]
    ordered = sorted(own, key=lambda sighting: (sighting.name.count("/"), sighting.name))
    found = [*(entry for sighting in ordered for entry in _entries(sighting)), *_stops(ordered)]
    _refuse_several_robots(found)
    found.sort(key=lambda entry: (_PARTS.index(entry.part), entry.rank))
    where = _common_namespace(found) if namespace == "/" else namespace
    used: set[str] = set()
    entries = tuple(_with_file_names(entry, where, used) for entry in _doubted(found))
    told = {entry.sighting.name for entry in found if entry.part != "topics"}
    told |= {entry.value.release for entry in found if entry.part == "stop"}
    unknown = tuple(_unknown_line(sighting) for sighting in ordered if sighting.name not in told)
    return Proposal(where, entries, unknown)


def _entries(sighting: Sighting) -> Iterator[Entry]:
    """Yield the entries for one sighting; their names are full, not yet those of the file."""
    if sighting.kind == "topic":
        yield from _topic_entries(sighting)
    elif sighting.kind == "action":
        goal = _propose_goal(sighting)
        if goal is not None:
            known = [*_GOALS].index(goal.type) if goal.type in _GOALS else len(_GOALS)
            rank = known, not goal.form
            yield Entry("goals", goal, sighting, sighting.reason(), rank=rank)
    elif not sighting.is_stop:
        # Whether a command moves the robot is not known, so it asks first.
        made = CommandService(sighting.word, sighting.title, sighting.name, ask="always")
        if _TOGGLE in sighting.types:
            made = replace(made, toggle={_TOGGLE_FIELD: "ask"})
        elif sighting.goal != {} and _COMMANDS.isdisjoint(sighting.types):
            return
        yield Entry("commands", made, sighting, sighting.reason())


def _topic_entries(sighting: Sighting) -> Iterator[Entry]:
    is_battery = any(word in sighting.name.lower() for word in _BATTERY_WORDS)
    for part, (make, known) in _TOPICS.items():
        for kind in sighting.types:
            is_other = (kind in _NUMBER_MESSAGES and not is_battery) or sighting.is_initial_pose
            if kind not in known or is_other:
                continue
            fields, reason = known[kind], sighting.reason(kind)
            if part == "battery":
                fields, more = _with_its_scale(fields, sighting.values)
                reason += more
            rank = [*known].index(kind) + (0 if sighting.nodes else len(known)), False
            yield Entry(part, make(sighting.name, {kind: fields}), sighting, reason, rank=rank)
            break
    if DIAGNOSTICS in sighting.types:
        yield Entry("diagnostics", sighting.name, sighting, sighting.reason(DIAGNOSTICS))
    # `pub` asks nothing before such a topic; of a topic of texts a person has to confirm it.
    rule = TopicRule(sighting.name, moves=False)
    listens = f"{sighting.name} is a {sighting.types[0]}, and `pub` asks nothing before it:"
    if sighting.is_initial_pose:
        yield Entry("topics", rule, sighting, f"{listens} it only tells where the robot is")
    elif _TEXT in sighting.types:
        reason = f"{listens} does no text move the robot? Then uncomment it"
        yield Entry("topics", rule, sighting, reason, is_sure=False)


def _with_its_scale(fields: BatteryFields, values: Mapping[str, Any]) -> tuple[BatteryFields, str]:
    percentage, value = fields.percentage, values.get(fields.percentage.field)
    if not isinstance(value, float):
        return fields, ""
    if value != value:
        return fields, "; its percentage is not a number"
    if value <= 1.0 or percentage.scale == 1.0:
        return fields, ""
    fields = replace(fields, percentage=replace(percentage, scale=1.0))
    return fields, f"; its percentage was {value:g}, so it is not 0 to 1 as its type says"


def _propose_goal(sighting: Sighting) -> GoalKind | None:
    known = next((_GOALS[kind] for kind in sighting.types if kind in _GOALS), None)
    if known is not None:
        return replace(known, action=sighting.name)
    form = None if sighting.goal is None else _form(sighting.goal)
    if form is None:
        return None
    fields, fixed = form
    return GoalKind(
        sighting.word,
        sighting.title,
        sighting.name,
        sighting.types[0],
        form=fields,
        fixed=fixed,
        remaining=_remaining(sighting.feedback),
        message=next((name for name in _MESSAGES if sighting.result.get(name) == "string"), ""),
    )


def _form(goal: Mapping[str, str]) -> tuple[dict[str, FormField], dict[str, str]] | None:
    """Return the fields to type and the fixed values of a goal; None if it has a list to fill.

    A pose is typed as x, y and yaw, in the frame that navigation uses. Stamps keep their zero.
    """
    fields: dict[str, FormField] = {}
    fixed: dict[str, str] = {}
    done: list[str] = []  # The paths of messages whose fields are dealt with.
    poses = [path for path, kind in goal.items() if kind in _GOAL_POSES]
    is_only_pose = all(f"{path}.".startswith(f"{poses[0]}.") for path in poses)
    for path, kind in goal.items():
        if any(path.startswith(f"{message}.") for message in done):
            continue
        if kind in _GOAL_POSES:
            pose, frame = _GOAL_POSES[kind]
            before, label = f"{path}.{pose}", "" if is_only_pose else f"{path} "
            fields[f"{before}position.x"] = FormField(f"{label}x", unit="m")
            fields[f"{before}position.y"] = FormField(f"{label}y", unit="m")
            fields[f"{before}orientation"] = FormField(f"{label}yaw", -360, 360, "deg", "yaw")
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


def _remaining(feedback: Mapping[str, str]) -> RemainingField | None:
    for path, kind in feedback.items():
        name = path.rpartition(".")[2]
        if _NUMBERS.fullmatch(kind) and _REMAINING.search(name):
            return RemainingField(path, unit="m" if "distance" in name else "")
    return None


def _stops(seen: Sequence[Sighting]) -> Iterator[Entry]:
    """Yield an entry for each service that may be the STOP, with what may release it."""
    stops = [sighting for sighting in seen if sighting.is_stop]
    releases = [
        stop for stop in stops if any(word in stop.word for word in _RELEASE_WORDS)
    ]  # By their own names, not those of their namespaces.
    for stop in stops:
        if stop in releases:
            continue
        reason = f"{stop.reason()}: is this the STOP? Then uncomment it"
        known = next((_STOPS[kind] for kind in stop.types if kind in _STOPS), None)
        if known is not None:
            made = replace(known, service=stop.name, release=stop.name)
        else:
            made = replace(_release_of(stop, releases), service=stop.name)
            fields = ", ".join(f"{path} ({kind})" for path, kind in (stop.goal or {}).items())
            reason += f", and say as `request` what is sent: {fields}" if fields else ""
        yield Entry("stop", made, stop, reason, is_sure=False)


def _release_of(stop: Sighting, releases: Sequence[Sighting]) -> StopServices:
    """Return an entry with the service that may release a stop, if any; `service` is still empty.

    It is beside or below the stop, and shares the most words with the stop's name. One with
    further words releases something else: `clear_brake_stop` no emergency stop.
    """
    beside = posixpath.dirname(stop.name)
    words = _words(stop.name.removeprefix(beside))
    fitting = [
        (len(own), release)
        for release in releases
        if posixpath.dirname(release.name) in (beside, stop.name)
        and (own := _words(release.name.removeprefix(beside)) - _RELEASE_WORDS) <= words
    ]
    if not fitting:
        return StopServices("")
    _, best = max(fitting, key=lambda pair: pair[0])
    request = {_TOGGLE_FIELD: True} if _TOGGLE in best.types else {}
    return StopServices("", release=best.name, release_request=request)


def _words(name: str) -> set[str]:
    """Return the words of a name in lower case: of `/softStop/kill_switch` soft, stop, kill ..."""
    parted = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    return set(re.findall(r"[a-z]+", parted.lower()))


def _refuse_several_robots(found: Iterable[Entry]) -> None:
    """Raise SeveralRobots if namespaces have a part of the same name and type below them.

    `/a/odom` and `/b/odom` are of two robots; `/odom` and `/odometry/filtered` are not.
    """
    by_rest: dict[tuple[str, str], set[str]] = {}
    for entry in found:
        first, slash, rest = entry.sighting.name[1:].partition("/")
        if slash and entry.part in ("battery", "motion", "goals"):
            by_rest.setdefault((entry.sighting.kind, rest), set()).add(f"/{first}")
    robots = set().union(*(names for names in by_rest.values() if len(names) > 1))
    if robots:
        raise SeveralRobots(robots)


def _doubted(found: Iterable[Entry]) -> Iterator[Entry]:
    """Yield the entries; of several for one part only the first is sure.

    Nor is a goal or command that may be another robot's, as `/tb2/dock` beside a `/dock` of its
    type: the goals of two robots must not stand together.
    """
    known: set[object] = set()
    for entry in found:
        name, types = entry.sighting.name, entry.sighting.types
        same = name[name.find("/", 1) :]
        if entry.part not in _LISTS and entry.part in known:
            entry = entry._replace(is_sure=False)
        elif entry.part in ("goals", "commands") and name != same and (same, types) in known:
            reason = f"{entry.reason}: is it of another robot than {same}? Then leave it out"
            entry = entry._replace(reason=reason, is_sure=False)
        known |= {entry.part, (name, types)}
        yield entry


def _common_namespace(found: Iterable[Entry]) -> str:
    own = [entry.sighting for entry in found if entry.part not in ("diagnostics", "topics")]
    names = [name for sighting in own for name in (sighting.name, *sighting.nodes)]
    return posixpath.commonpath([posixpath.dirname(name) for name in names]) if names else "/"


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
    return name.removeprefix(f"{namespace.rstrip('/')}/")


def _unknown_line(sighting: Sighting) -> str:
    lacking = sighting.kind != "topic" and sighting.goal is None
    why = ", which is not installed here" if lacking else ""
    return f"{sighting.kind} {sighting.name}: {', '.join(sighting.types)}{why}"


# Its text.

_NO_STOP = (
    "No service that looks like a STOP was seen: without one, ctrl+x cancels every goal instead."
)
_MOST = 200  # Unknown topics, services and actions that are listed; the rest is counted.


def text_of(proposal: Proposal, head: str) -> str:
    """Return the text of a proposed robot file; what is not sure becomes a comment."""
    name = base_name(proposal.namespace) or RobotFile.name
    parts = [_comment(head), yaml_dump.block({"version": RobotFile.version, "name": name})]
    for part, group in groupby(proposal.entries, key=lambda entry: entry.part):
        entries = [*group]
        parts += _list_lines(part, entries) if part in _LISTS else map(_part_lines, entries)
    if not any(entry.part == "stop" for entry in proposal.entries):
        parts.append(_comment(_NO_STOP))
    unknown = [f"  {line}" for line in proposal.unknown[:_MOST]]
    if len(proposal.unknown) > _MOST:
        unknown.append(f"  and {len(proposal.unknown) - _MOST} more")
    if unknown:
        parts.append(_comment("\n".join(["Seen besides, and not described:", *unknown])))
    text = "".join(parts)
    parse(text, Path("the proposed file"))
    return text


def _list_lines(part: Part, entries: Sequence[Entry]) -> Iterator[str]:
    head = f"{part}:\n"
    yield head if any(entry.is_sure for entry in entries) else _comment(head)
    for entry in entries:
        item = yaml_dump.mixed([plain(entry.value)])
        item = item if entry.is_sure else _comment(item)
        yield indent(_comment(entry.reason) + item, "  ")


def _part_lines(entry: Entry) -> str:
    value = plain(entry.value)
    # `mixed` writes a mapping of one name in braces, which nothing can follow in a file.
    write = yaml_dump.block if isinstance(value, str) else yaml_dump.mixed
    text = write({entry.part: value})
    return _comment(entry.reason) + (text if entry.is_sure else _comment(text))


def _comment(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())
