"""The alarms, one entry each: what is fixed about it, when it holds, and with which words.

A condition is a pure function over a Situation. It yields a text: what is the case, and behind a
colon what to do; before it stands what it is about (a node, a topic, a part) if not the robot. None
in place of the text says that nothing is known of it now: an alarm that stands is then the last
that was known.

A further alarm is a function here, and a row of docs/alarms.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple

from archo_tui.base.clock import time_of_day
from archo_tui.robot.messages.period import LEAST_SILENCE, MessageRate
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.graph import not_offered
from archo_tui.robot.state.readings import WORST_FIRST, Diagnostic, DiagnosticLevel
from archo_tui.robot.state.snapshot import Hosted, Latch, Life, OpenStop, Snapshot, StopAnswer
from archo_tui.robot_file.model import TopicRule

Found = Iterator[str | tuple[str, str | None] | None]

_ANSWER_TIME = 1.0  # Seconds that a STOP may take before it is an alarm.
_MOST_OFFSETS = 3  # Clocks that are named.
_MOST_DIAGNOSTICS = 20  # Parts with an alarm of their own; more would hide all other alarms.
_OTHERS = "others"  # Of the alarm for the parts that have none of their own.


@dataclass(frozen=True)
class Situation:
    """All that alarms go by."""

    snapshot: Snapshot
    now: float  # monotonic, s
    hosted: tuple[Hosted, ...] = ()  # Of this process.
    journal_failure: str = ""  # Why it cannot be written.
    recorder_trouble: str = ""  # That the operator has to know.
    unseen: str = ""  # Where nodes were looked for; "": no alarm about that.
    earlier_stop: float | None = None  # Unix time of one from before the start that may still hold.

    @property
    def has_reports(self) -> bool:
        """True if a message about battery or motion was received since the start."""
        snapshot = self.snapshot
        return snapshot.battery.received is not None or snapshot.motion.received is not None

    @cached_property
    def contact_is_lost(self) -> bool:
        """True if battery and motion are silent, as far as the robot has reported them before."""
        battery, motion = self.snapshot.battery, self.snapshot.motion
        is_battery_silent = battery.received is None or battery.is_old(self.now)
        is_motion_silent = motion.received is None or motion.is_old(self.now)
        return self.has_reports and is_battery_silent and is_motion_silent

    @cached_property
    def bad_parts(self) -> list[Diagnostic]:
        """The parts that are not OK, the worst first; without contact, those still received."""
        every = diagnostics_worst_first(self.snapshot, self.now)
        if self.contact_is_lost:  # What is still received may tell why the rest is silent.
            every = [status for status in every if not status.is_silent_at(self.now)]
        return [status for status in every if status.level is not DiagnosticLevel.OK]


class Priority(Enum):
    """The urgency of an alarm, by which the operator acts; the value is glyph and word."""

    HIGH = "✗ HIGH"
    MED = "▲ MED"
    LOW = "● LOW"

    @property
    def glyph(self) -> str:
        """The one character that stands for the priority."""
        return self.value[0]


class Holds(Enum):
    """Until when an alarm holds the queue of goals."""

    UNTIL_OVER = "over"
    UNTIL_ACKNOWLEDGED = "acknowledged"


class Remedy(NamedTuple):
    """A command that helps against an alarm, and the words around the way to give it."""

    command: str
    words: str


# The names that other modules ask for.
CONTACT_LOST = "contact lost"
BATTERY_EMPTY = "battery empty"
STOPPED = "stopped"
LOW_BATTERY = "low battery"
DIAGNOSTIC_ERROR = "diagnostics error"
DIAGNOSTIC_WARNING = "diagnostics"
CHARGE = "charge"  # The robot file's command that charges, whatever its id is.


Condition = Callable[[Situation], Found]


class Kind(NamedTuple):
    """All that is fixed about an alarm."""

    name: str  # Behind it may stand a node, topic or part.
    priority: Priority
    # Yields what it is about, and its text, for each that holds.
    condition: Condition
    delay: float = 0.0  # Seconds until it is raised (ISA-18.2's on-delay).
    off_delay: float = 0.0  # Seconds for which it counts on after it was last found.
    graver: str = ""  # The alarm that replaces it, and whose condition excludes its own.
    is_reported: bool = False  # By the robot: without contact it stays as it is.
    has_own_topic: bool = False  # It is evaluated without contact, too.
    is_silence: bool = False  # About silence: after a suspension it is our own.
    has_text: bool = False  # Behind its name stands any text, not a node or topic.
    holds: Holds | None = None
    remedy: Remedy | None = None


_HIGH, _MED, _LOW = Priority
_AFTER_GRAPH = 30.0  # A killed node stays on the graph of ROS 2 for about 20 s.
_kinds: list[Kind] = []


def _alarm(name: str, priority: Priority, **fixed: Any) -> Callable[[Condition], Condition]:
    """Make a condition that of an alarm; of one priority, the first in this file is shown first."""

    def add(condition: Condition) -> Condition:
        _kinds.append(Kind(name, priority, condition, **fixed))
        return condition

    return add


# STOP.


@_alarm("moves after stop", _HIGH)
def moves_after_stop(seen: Situation) -> Found:
    runs = seen.snapshot.still_running_after_stop
    if runs:
        word = "RUNS" if len(runs) == 1 else "RUN"
        yield f"STOP WAS ANSWERED, BUT {', '.join(runs)} STILL {word}: use the hardware stop"
    elif _moves_after_stop(seen.snapshot, seen.now):
        yield "THE ROBOT MOVES ALTHOUGH STOP WAS SENT: use the hardware stop"


def _moves_after_stop(snapshot: Snapshot, now: float) -> bool:
    """Return True if the robot moves in spite of a STOP, 1 s or more after an open one."""
    stop, motion = snapshot.open_stop, snapshot.motion
    if motion.received is None or motion.is_old(now):
        return False
    if stop is None or stop.answer == StopAnswer.NOT_SENT:
        return snapshot.stop_not_obeyed
    return bool(motion.moving) and motion.received - stop.asked >= _ANSWER_TIME


@_alarm("stop not confirmed", _HIGH)
def stop_unconfirmed(seen: Situation) -> Found:
    stop, now = seen.snapshot.open_stop, seen.now
    if stop is not None and (stop.answer != StopAnswer.AWAITED or now - stop.asked >= _ANSWER_TIME):
        yield f"{open_stop_texts(seen.snapshot, stop, now)[0]}: use the hardware stop"


@_alarm("stop not certain", _HIGH, delay=1.0)
def stop_uncertain(seen: Situation) -> Found:
    snapshot = seen.snapshot
    if snapshot.latch is Latch.UNCERTAIN:
        remedy = f"{snapshot.latch_doubt}: stop again, or release it"
        if snapshot.stop_held_by_nobody:
            remedy = "every node that held it has ended here: release it"
        at = time_of_day(snapshot.latch_time)[:-3]
        yield f"STOP OF {at} IS NO LONGER CERTAIN: {remedy}"


@_alarm("several stops", _HIGH, delay=2.0)
def several_stop_servers(seen: Situation) -> Found:
    served = seen.snapshot.file.stop
    nodes = () if served is None else seen.snapshot.duplicate_servers.get(served.service, ())
    if served is not None and nodes:
        yield (
            f"{len(nodes)} NODES SERVE {served.service}: {', '.join(nodes)}: STOP must be "
            "confirmed by all of them; keep the hardware stop at hand"
        )


@_alarm(STOPPED, _MED, is_reported=True, remedy=Remedy("release", ", then {} to release"))
def stopped(seen: Situation) -> Found:
    if seen.snapshot.runs_on:  # It stays the alarm that it was, acknowledged or not.
        yield "A GOAL RUNS ON BEHIND THE STOP: use the hardware stop"
    elif seen.snapshot.is_at_rest:
        yield "STOPPED: look for the cause"


def open_stop_texts(snapshot: Snapshot, stop: OpenStop, now: float) -> tuple[str, ...]:
    """Return the state of a STOP that the robot has not confirmed: in full, then shorter."""
    waited, answer, why = now - stop.asked, stop.answer, stop.why
    if answer not in (StopAnswer.AWAITED, StopAnswer.NONE):
        return (f"STOP {answer.value} {why}".rstrip(),)
    service = "" if snapshot.file.stop is None else snapshot.file.stop.service
    if service not in snapshot.offered and answer == StopAnswer.AWAITED:
        # The STOP waits for a server, or the server that it was sent to has left.
        return f"STOP NOT CONFIRMED ({not_offered(service)})", "STOP NOT CONFIRMED"
    if waited < 1:
        return ("STOP SENT",)
    silent = f"STOP SENT, {StopAnswer.NONE.value} {why}".rstrip() + f" for {waited:.0f} s"
    again = answer == StopAnswer.NONE
    more = ", sent again while the robot is heard" if again else " (not confirmed by the robot)"
    return silent + more, silent, f"STOP SENT, unanswered {waited:.0f} s"


# What the robot reports.


@_alarm(CONTACT_LOST, _HIGH, is_silence=True, holds=Holds.UNTIL_OVER)
def contact_lost(seen: Situation) -> Found:
    if seen.contact_is_lost:
        battery, motion = seen.snapshot.battery, seen.snapshot.motion
        last = max(battery.received or 0.0, motion.received or 0.0)
        yield f"CONTACT LOST for {seen.now - last:.0f} s: the robot may still be moving"


@_alarm(BATTERY_EMPTY, _HIGH, delay=2.0, is_reported=True, holds=Holds.UNTIL_ACKNOWLEDGED)
def battery_empty(seen: Situation) -> Found:
    battery, described = seen.snapshot.battery, seen.snapshot.file.battery
    if battery.percentage is None or battery.is_old(seen.now):
        yield None
    elif battery.percentage <= 0.0:
        refuses = described is not None and described.empty_refuses_moves
        more = "the robot refuses moves, charge it where it stands" if refuses else "charge it"
        yield f"BATTERY EMPTY: {more}"


@_alarm(
    LOW_BATTERY,
    _MED,
    delay=2.0,
    graver=BATTERY_EMPTY,
    is_reported=True,
    holds=Holds.UNTIL_ACKNOWLEDGED,
    remedy=Remedy(CHARGE, ", or {} to charge"),
)
def low_battery(seen: Situation) -> Found:
    battery = seen.snapshot.battery
    if battery.is_old(seen.now) or (battery.percentage is None and not battery.charging):
        yield None
    elif battery.percentage is None or battery.percentage <= 0.0 or battery.charging:
        return
    elif is_battery_low(seen.snapshot):
        is_moving = seen.snapshot.running_goal is not None
        dock = "dock the robot when this move is done" if is_moving else "dock the robot"
        yield f"LOW BATTERY {battery.percentage:.1f} %: {dock}"


@_alarm("battery health", _MED, delay=2.0, is_reported=True)
def unhealthy_battery(seen: Situation) -> Found:
    battery = seen.snapshot.battery
    if not battery.health or battery.is_old(seen.now):
        yield None
        return
    meaning = battery_health(seen.snapshot)
    if not meaning:
        yield f"BATTERY HEALTH {battery.health}: the console does not know this word"
    elif meaning == "replace":
        yield f"BATTERY HEALTH {battery.health}: have the battery replaced"


def is_battery_low(snapshot: Snapshot) -> bool:
    """Return True if the battery is low by its health or its percentage, whichever says so."""
    charge, threshold = snapshot.battery.percentage, snapshot.low_charge
    is_below = charge is not None and (charge <= 0.0 or charge < (threshold or 0.0))
    return is_below or battery_health(snapshot) == "low"


def battery_health(snapshot: Snapshot) -> str:
    """Return `good`, `low` or `replace`; "" for no health, or a word that is not in the file."""
    described = snapshot.file.battery
    return "" if described is None else described.health.get(snapshot.battery.health or "", "")


@_alarm("motor silent", _HIGH, is_reported=True, is_silence=True)
def motor_silent(seen: Situation) -> Found:
    snapshot, motion = seen.snapshot, seen.snapshot.motion
    is_moving = snapshot.running_goal is not None or motion.moving
    if motion.received is not None and motion.is_old(seen.now) and is_moving:
        topic = snapshot.file.motion.topic if snapshot.file.motion else "motion"
        yield (
            f"{topic} silent for {seen.now - motion.received:.0f} s while moving: "
            "the robot may still be driving"
        )


@_alarm("no word of the goal", _HIGH, is_reported=True, is_silence=True)
def goal_silent(seen: Situation) -> Found:
    goal = seen.snapshot.running_goal
    if goal is not None and goal.phase == Phase.LOST and not any(motor_silent(seen)):
        yield (
            f"NO WORD FROM {goal.kind.title.upper()} for "
            f"{seen.now - (goal.heard or goal.sent):.0f} s: the robot may still be driving"
        )


@_alarm("gauge", _MED, delay=2.0, is_reported=True, has_text=True)
def gauge_warning(seen: Situation) -> Found:
    for reading in seen.snapshot.gauges:
        title, unit = reading.gauge.title, reading.gauge.unit
        if reading.value is None or reading.is_old(seen.now):
            yield title, None
        elif reading.warning:
            value = f"{title.upper()} {reading.value:g} {unit}".rstrip()
            yield title, f"{value}: {reading.warning}"


@_alarm("node crashed", _HIGH)
def node_crashed(seen: Situation) -> Found:
    for node in seen.hosted:
        if node.life == Life.CRASHED:
            yield node.name, f"NODE CRASHED {node.name}: see why in Nodes, then start it again"


# Diagnostics: an error and a warning of one part are two alarms, of which the error counts.


_OF_A_PART = {"is_reported": True, "has_own_topic": True, "has_text": True}
_MAY_FLAP = {"delay": 2.0, "off_delay": 2.0}


@_alarm(DIAGNOSTIC_ERROR, _HIGH, **_MAY_FLAP, **_OF_A_PART)
def diagnostic_error(seen: Situation) -> Found:
    for status, text in _bad_parts(seen):
        if status.level is DiagnosticLevel.ERROR:
            yield _part_name(status.part), text


@_alarm(DIAGNOSTIC_WARNING, _MED, graver=DIAGNOSTIC_ERROR, **_MAY_FLAP, **_OF_A_PART)
def diagnostic_warning(seen: Situation) -> Found:
    bad, parts, topic = seen.bad_parts, _bad_parts(seen), seen.snapshot.file.diagnostics
    if bad and not parts:  # All are silent.
        last = max(status.received for status in bad)
        yield str(topic), f"DIAGNOSTICS STALE: nothing on {topic} for {seen.now - last:.0f} s"
    for status, text in parts:
        if status.level is not DiagnosticLevel.ERROR:
            yield _part_name(status.part), text
    if parts and len(bad) > _MOST_DIAGNOSTICS:
        yield _OTHERS, f"{len(bad) - _MOST_DIAGNOSTICS} MORE PARTS ARE NOT OK: see diagnostics"


def _bad_parts(seen: Situation) -> list[tuple[Diagnostic, str]]:
    bad, statuses = seen.bad_parts, seen.snapshot.diagnostics
    if len(bad) > 1 and all(status.is_silent_at(seen.now) for status in statuses):
        return []
    found = []
    for status in bad[:_MOST_DIAGNOSTICS]:
        silent = f"no status for {seen.now - status.received:.0f} s"
        text = silent if status.is_silent_at(seen.now) else status.message
        found.append((status, f"{status.level.value} {status.part}: {text or 'no message'}"))
    return found


def _part_name(part: str) -> str:
    """Return a part; in quotes if it would read like the name of another alarm."""
    return f'"{part}"' if part.startswith(("error ", "/")) or part == _OTHERS else part


def diagnostics_worst_first(snapshot: Snapshot, now: float) -> list[Diagnostic]:
    """Return the last status of each part with its level now: ERROR, WARN, STALE, OK, by name."""
    found = [status._replace(level=status.level_at(now)) for status in snapshot.diagnostics]
    return sorted(found, key=lambda status: (WORST_FIRST.index(status.level), status.key))


# Topics whose rate the robot file expects.


@_alarm("topic silent", _MED, delay=10.0, is_reported=True, is_silence=True)
def topic_silent(seen: Situation) -> Found:
    for topic, rule, rate in _rated(seen):
        if rate is None:
            yield topic, f"{topic} IS SILENT: nothing came, expected {rule.rate:g} Hz"
        elif seen.now - rate.heard > _silence(rule):
            silent = f"{seen.now - rate.heard:.0f} s"
            yield topic, f"{topic} IS SILENT for {silent}: expected {rule.rate:g} Hz"


@_alarm("topic slow", _LOW, delay=5.0, off_delay=5.0, is_reported=True)
def topic_slow(seen: Situation) -> Found:
    for topic, hertz, due, within in _beyond(seen, lambda share, tolerance: share < 1 - tolerance):
        yield topic, f"{topic} IS TOO SLOW, {hertz} Hz: expected {due:g} Hz, within {within}"


@_alarm("topic fast", _LOW, delay=5.0, off_delay=5.0, is_reported=True)
def topic_fast(seen: Situation) -> Found:
    for topic, hertz, due, within in _beyond(seen, lambda share, tolerance: share > 1 + tolerance):
        yield topic, f"{topic} IS TOO FAST, {hertz} Hz: expected {due:g} Hz, within {within}"


def _beyond(
    seen: Situation, is_so: Callable[[float, float], bool]
) -> Iterator[tuple[str, str, float, str]]:
    """Yield topics by their share of the expected rate, with both rates and the tolerance."""
    for topic, rule, rate in _rated(seen):
        due = rule.rate or 0.0
        if rate is None or rate.hertz is None or seen.now - rate.heard > _silence(rule):
            continue
        if is_so(rate.hertz / due, rule.tolerance):
            yield topic, f"{rate.hertz:.1f}", due, f"{rule.tolerance:.0%}"


def _rated(seen: Situation) -> Iterator[tuple[str, TopicRule, MessageRate | None]]:
    for rule in seen.snapshot.file.topics:
        if rule.rate is not None:
            topic = seen.snapshot.full(rule.topic)
            yield topic, rule, seen.snapshot.message_rates.get(topic)


def _silence(rule: TopicRule) -> float:
    return max(3 / (rule.rate or 1.0), LEAST_SILENCE)


# Frames that the robot file wants alive.


@_alarm("frame silent", _MED, delay=5.0, is_reported=True, is_silence=True, has_text=True)
def frame_silent(seen: Situation) -> Found:
    transforms = seen.snapshot.transforms
    for rule in seen.snapshot.file.frames:
        name, frame, most = rule.frame, transforms.frames.get(rule.frame), f"{rule.age:g} s"
        silence = 0.0 if frame is None else seen.now - frame.rate.heard
        age = None if frame is None else frame.age(seen.now)
        if frame is None and transforms.fault:
            yield name, f"FRAME {name} IS SILENT: {transforms.fault}"
        elif frame is None:
            yield name, f"FRAME {name} IS SILENT: no transform to it came, expected within {most}"
        elif age is not None and silence > rule.age:
            yield name, f"FRAME {name} IS SILENT for {silence:.1f} s: expected within {most}"
        elif age is not None and age > rule.age:
            yield name, f"FRAME {name} IS {age:.1f} s OLD by its stamp: expected within {most}"


# The graph, and the console itself.


@_alarm("several publishers", _MED, delay=_AFTER_GRAPH)
def several_publishers(seen: Situation) -> Found:
    for topic, names in seen.snapshot.publishers.items():
        text = f"{len(names)} PUBLISHERS of {topic}: {', '.join(names)}: their readings come mixed"
        yield f"/{topic}", text


@_alarm("name twice", _MED, delay=_AFTER_GRAPH)
def duplicate_name(seen: Situation) -> Found:
    for name in seen.snapshot.duplicate_nodes:
        yield name, f"TWO NODES NAMED {name}: a call reaches both of them"


@_alarm("no nodes", _MED, delay=5.0)
def no_nodes(seen: Situation) -> Found:
    snapshot = seen.snapshot
    if not seen.unseen or seen.hosted or snapshot.nodes or snapshot.other_namespaces:
        return
    if not seen.has_reports:
        yield f"NO NODES {seen.unseen}"
    elif not seen.contact_is_lost:  # rmw_fastrtps may not get the names again behind a cut.
        yield "NO NODE NAMES, though the robot is heard: start this console again"


@_alarm("no clock", _MED, delay=5.0)
def no_clock(seen: Situation) -> Found:
    snapshot = seen.snapshot
    waiting = ", ".join(snapshot.simulated_nodes)
    if waiting and not snapshot.has_clock:
        yield (
            f"NO CLOCK for {waiting}: use_sim_time is true and nobody publishes /clock: "
            "start the simulator, or set it to false"
        )


@_alarm("clocks differ", _LOW, delay=5.0)
def clocks_differ(seen: Situation) -> Found:
    offsets = sorted(seen.snapshot.clock_offsets.items(), key=lambda item: -abs(item[1]))
    if offsets:
        sources = ", ".join(
            f"{source} is {abs(offset):.1f} s {'ahead' if offset > 0 else 'behind'}"
            for source, offset in offsets[:_MOST_OFFSETS]
        )
        more = ", ..." if len(offsets) > _MOST_OFFSETS else ""
        yield f"CLOCKS DIFFER: {sources}{more}: set one of them (chrony or ntp)"


@_alarm("earlier stop", _LOW, remedy=Remedy("release", ": {} to release"))
def earlier_stop(seen: Situation) -> Found:
    motion, at = seen.snapshot.motion, seen.earlier_stop
    is_known = seen.snapshot.released is not None or seen.snapshot.is_stopped
    if at is not None and not (is_known or motion.stopped is not None or motion.moving):
        yield (
            f"STOP OF {time_of_day(at)[:-3]} HAS NO RELEASE IN THE JOURNAL: "
            "the robot may still be stopped"
        )


@_alarm("journal not written", _LOW)
def journal_not_written(seen: Situation) -> Found:
    if seen.journal_failure:
        yield f"JOURNAL NOT WRITTEN: {seen.journal_failure}"


@_alarm("recordings", _LOW)
def recording_trouble(seen: Situation) -> Found:
    if seen.recorder_trouble:
        yield seen.recorder_trouble


# All of them.

KINDS = sorted(_kinds, key=lambda kind: [*Priority].index(kind.priority))
_BY_NAME = {kind.name: kind for kind in KINDS}


def kind_of(name: str) -> Kind:
    """Return the kind of an alarm by its full name."""
    with_text = (kind for kind in KINDS if kind.has_text and name.startswith(f"{kind.name} "))
    return next(with_text, None) or _BY_NAME[name.partition(" /")[0]]


def graver_name(name: str) -> str:
    """Return the name of the graver alarm that may have the same cause; "" if there is none."""
    kind = kind_of(name)
    return kind.graver and kind.graver + name.removeprefix(kind.name)


class Conditions(NamedTuple):
    """The alarms by their full names whose conditions hold, and of which nothing is known now."""

    texts: dict[str, str]
    unknown: frozenset[str] = frozenset()


def conditions(seen: Situation) -> Conditions:
    """Evaluate the conditions of all alarms; without contact, only those still reported."""
    is_lost = seen.contact_is_lost
    texts, unknown = dict[str, str](), set[str]()
    for kind in KINDS:
        is_left_out = is_lost and kind.is_reported and not kind.has_own_topic
        for found in () if is_left_out else kind.condition(seen):
            subject, text = found if isinstance(found, tuple) else ("", found)
            name = f"{kind.name} {subject}" if subject else kind.name
            if text is None:
                unknown.add(name)
            else:
                texts[name] = text
    return Conditions(texts, frozenset(unknown))
