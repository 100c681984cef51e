"""The checks of a robot file: of its values, and against the ROS graph. Pure functions."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence

from archo_tui.nearest import nearest_hint
from archo_tui.robot_file.model import (
    BatteryTopic,
    CommandService,
    GoalKind,
    Limit,
    MessageField,
    MotionTopic,
    ParameterRef,
    PoseTopic,
    RobotFile,
    StopServices,
    fields_of,
)
from archo_tui.robot_file.reserved import RESERVED
from archo_tui.ros_names import is_name, parse_type

_ID = re.compile(r"[a-z][a-z0-9_]*")
_READINGS = ("battery.charging", "motion.moving", "motion.stopped", "ask")

Faults = Iterator[tuple[str, str]]  # Pairs of `FILE:LINE` and a sentence.

_MOST_HERTZ = 1000.0
_PLACE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")
_NO_PLACES = {"nan", "inf", "infinity", "true", "false", "yes", "no", "on", "off", "null"}


def find_faults(robot: RobotFile) -> Faults:
    """Yield each fault of a robot file as the entry's place (`FILE:LINE`, or "") and a sentence."""
    yield from _name_faults(robot)
    yield from _type_faults(robot)
    yield from _empty_title_faults(robot)
    yield from _word_faults(robot)
    yield from _reading_faults(robot)
    yield from _gauge_faults(robot)
    yield from _rate_faults(robot)
    for rule in robot.frames:
        if not rule.age > 0:
            yield rule.where, "age is more than 0 s"
    yield from _place_faults(robot)
    for goal in robot.goals:
        yield from _goal_faults(goal)
    if robot.stop is not None:
        yield from _stop_faults(robot.stop)
    for command in robot.commands:
        yield from _toggle_faults(command)


def _rate_faults(robot: RobotFile) -> Faults:
    for rule in robot.topics:
        if rule.rate is not None and not 0 < rule.rate <= _MOST_HERTZ:
            yield rule.where, f"rate is more than 0, at most {_MOST_HERTZ:g} Hz"
        if not 0 < rule.tolerance < 1:
            yield rule.where, "tolerance is a share: more than 0, less than 1"


def is_place_name(text: str) -> bool:
    """Return True for a name that cannot be taken for a value: letters, digits, `_` and `-`."""
    return _PLACE_NAME.fullmatch(text) is not None and text.lower() not in _NO_PLACES


def _place_faults(robot: RobotFile) -> Faults:
    names = set()
    goals = {goal.id: goal for goal in robot.goals}
    for place in robot.places:
        goal = goals.get(place.goal) if place.goal else next(iter(robot.goals), None)
        if not is_place_name(place.name):
            yield place.where, f"{place.name!r} is no name: a letter, then letters and digits"
        if place.name in names:
            yield place.where, f"duplicate place {place.name}: choose another name"
        names.add(place.name)
        if goal is None:
            yield place.where, f"{place.goal or 'its goal'} is no goal of this file"
        elif place.values.keys() != goal.form.keys():
            wanted = ", ".join(goal.form) or "none"
            yield place.where, f"{place.name} needs a value for each field of the form: {wanted}"


def _subscribed(robot: RobotFile) -> list[BatteryTopic | MotionTopic | PoseTopic]:
    return [topic for topic in (robot.battery, robot.motion, robot.pose) if topic is not None]


def _name_faults(robot: RobotFile) -> Faults:
    names = [(topic.where, topic.topic) for topic in (*_subscribed(robot), *robot.gauges)]
    names += [("", name) for name in (robot.diagnostics, *robot.record) if name]
    names += [(rule.where, rule.topic) for rule in robot.topics]
    names += [(goal.where, goal.action) for goal in robot.goals]
    names += [(command.where, command.service) for command in robot.commands]
    if robot.stop is not None:
        names.append((robot.stop.where, robot.stop.service))
        if robot.stop.release:
            names.append((robot.stop.where, robot.stop.release))
    for where, name in names:
        if not is_name(name):
            yield where, f"{name!r} is not a name of a topic, service or action"


def _type_faults(robot: RobotFile) -> Faults:
    types = [(topic.where, kind, "msg") for topic in _subscribed(robot) for kind in topic.types]
    types += [(gauge.where, gauge.type, "msg") for gauge in robot.gauges]
    types += [(goal.where, goal.type, "action") for goal in robot.goals]
    for where, kind, of in types:
        parts = parse_type(kind)
        if parts is None or parts.kind != of:
            yield where, f"{kind!r} is not a type: expected package/{of}/Name"


def _empty_title_faults(robot: RobotFile) -> Faults:
    titles = [(goal.where, goal.title) for goal in robot.goals]
    titles += [(command.where, command.title) for command in robot.commands]
    titles += [(gauge.where, gauge.title) for gauge in robot.gauges]
    for where, title in titles:
        if not title.strip():
            yield where, "title is empty: say what it is in a word or two"


def _word_faults(robot: RobotFile) -> Faults:
    """Check the words that operators type: each is valid, unique, and not the console's own."""
    found = [("id", goal.id, goal.where) for goal in robot.goals]
    found += [("id", command.id, command.where) for command in robot.commands]
    found += [
        ("word", command.off_word, command.where) for command in robot.commands if command.off_word
    ]
    used: set[str] = set()
    for what, word, where in found:
        if not _ID.fullmatch(word):
            yield where, f"{word!r} is not a valid {what}: small letters, digits and _"
        if word in RESERVED:
            yield where, f"the {what} {word} is the console's own: choose another"
        if word in used:
            yield where, f"duplicate {what} {word}: choose another"
        used.add(word)


def _reading_faults(robot: RobotFile) -> Faults:
    for topic in _subscribed(robot):
        if not topic.types:
            yield topic.where, f"types is empty: name the type of {topic.topic}"
        if topic.period is not None and topic.period <= 0:
            yield topic.where, f"period is {topic.period:g}: a time in s, above 0"
        for fields in topic.types.values():
            for name, given in vars(fields).items():
                for field in fields_of(given):
                    yield from _field_faults(field)
                if given == ():
                    yield topic.where, f"{name} is empty: name a reading, or leave it out"
    if robot.battery is not None:
        low = _known_number(robot.battery.low)
        if low is not None and not 0 <= low <= 100:
            where, name = _limit_place(robot.battery.where, "low", robot.battery.low)
            yield where, f"{name} is {low:g}: a charge is within 0 .. 100"


def _field_faults(field: MessageField) -> Faults:
    if field.scale == 0:
        yield field.where, "scale is 0: every reading would be the same"
    if field.equals is not None and field.beyond is not None:
        yield field.where, "equals and beyond exclude each other: give one of them"
    if field.beyond is not None and field.beyond < 0:
        yield field.where, f"beyond is {field.beyond:g}: it must not be negative"


def _gauge_faults(robot: RobotFile) -> Faults:
    titles = set()
    for gauge in robot.gauges:
        if gauge.title in titles:  # The title identifies the gauge's alarm.
            yield gauge.where, f"duplicate title {gauge.title}: choose another"
        titles.add(gauge.title)
        yield from _field_faults(gauge.field)
        yield from _order_faults(gauge.where, "low", gauge.low, "high", gauge.high)
        below, above = gauge.warn_below, gauge.warn_above
        yield from _order_faults(gauge.where, "warn_below", below, "warn_above", above)


def _order_faults(
    where: str, name: str, low: float | None, other: str, high: float | None
) -> Faults:
    if low is not None and high is not None and low > high:
        yield where, f"{name} {low:g} is above {other} {high:g}: swap them"


def _known_number(limit: Limit) -> float | None:
    """Return the number of a limit without the robot's parameters; None if there is none."""
    return limit.otherwise if isinstance(limit, ParameterRef) else limit


def _limit_place(where: str, name: str, limit: Limit) -> tuple[str, str]:
    """Return where a limit's number is written (`FILE:LINE`), and the key that holds it."""
    return (limit.where, "otherwise") if isinstance(limit, ParameterRef) else (where, name)


def _goal_faults(goal: GoalKind) -> Faults:
    labels = set()
    for path, given in goal.form.items():
        yield from _order_faults(
            given.where, "low", _known_number(given.low), "high", _known_number(given.high)
        )
        label = given.label or path
        if label.lower() in labels:  # `--plain` takes `label=value` in any case.
            yield given.where, f"duplicate label {label}: choose another"
        labels.add(label.lower())
        for other in (*goal.form, *goal.fixed):
            if other != path and other.startswith(f"{path}."):
                yield given.where, f"{other} is a part of {path}: give one of them"
        if path in goal.fixed:
            yield given.where, f"{path} is both in the form and fixed: give one of them"
    if goal.remaining is not None:
        length = _known_number(goal.remaining.length)
        if length is not None and length <= 0:
            where, name = _limit_place(goal.remaining.where, "length", goal.remaining.length)
            yield where, f"{name} is {length:g}: a length is above 0"


def _stop_faults(stop: StopServices) -> Faults:
    is_same = stop.release.lstrip("/") == stop.service.lstrip("/")
    if is_same and stop.release_request == stop.request:
        same = f"release is the service that stops, {stop.service}"
        yield stop.where, f"{same}: give it a release_request of its own, name another or none"
    if stop.release_request and not stop.release:
        yield stop.where, "release_request is for a release: name its service"


def _toggle_faults(command: CommandService) -> Faults:
    if command.off and not command.toggle:
        yield command.where, f"off is for a toggle: {command.id} has none"
    if len(command.toggle) > 1:
        yield command.where, "toggle takes one field of the request"
    for reading in command.toggle.values():
        if reading not in _READINGS:
            yield command.where, f"toggle inverts one of {', '.join(_READINGS)}, not {reading}"


# Against the ROS graph.


def unexpected_type(name: str, found: Sequence[str], expected: Collection[str]) -> str:
    """Return why the types of a topic or action do not fit; "" if they do, or there is none."""
    for kind in found:
        if kind not in expected:
            return f"{name} is {kind}: expected {' or '.join(expected)}"
    return f"{name} has several types: {', '.join(found)}" if len(found) > 1 else ""


def duplicate_servers(action: str, nodes: Sequence[str]) -> str:
    """Return the text by which a goal is refused whose action several nodes serve.

    ROS 2 delivers one goal request to all of them, so each would start to drive.
    """
    return f"{action} is served by {' and '.join(nodes)}: each would drive; stop all but one"


def not_installed(name: str, kind: str) -> str:
    """Return the error text for a type whose package cannot be imported here."""
    return f"{name} is {kind}, which is not installed here"


def not_subscribed(name: str, kind: str, reason: str) -> str:
    """Return the error text for a topic to which rclpy makes no subscription, and its reason."""
    return f"{name} is {kind}, and cannot be subscribed to here: {reason}"


def unknown_field(kind: str, wanted: Iterable[tuple[str, str]], known: Collection[str]) -> str:
    """Return an error for the first of `wanted` (place, path) that a type lacks, or ""."""
    for where, path in wanted:
        if path not in known:
            return f"{where}: {kind} has no field {path}{nearest_hint(path, known)}"
    return ""
