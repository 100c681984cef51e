"""The alarms, one entry each, and an alarm with its state by ISA-18.2.

A further alarm is a function in conditions.py, a row of KINDS here, and a row of docs/alarms.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from typing import NamedTuple

from archo_tui.clock import Monotonic, UnixTime
from archo_tui.robot.goals.queue import Holding
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station import conditions as when
from archo_tui.station.conditions import Found, Situation


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
_CHARGE = "charge"  # The robot file's command that charges, whatever its id is.


class Kind(NamedTuple):
    """All that is fixed about an alarm."""

    name: str  # Behind it may stand a node, topic or part.
    priority: Priority
    # Yields what it is about, and its text, for each that holds.
    condition: Callable[[Situation], Found]
    delay: float = 0.0  # Seconds until it is raised (ISA-18.2's on-delay).
    off_delay: float = 0.0  # Seconds for which it counts on after it was last found.
    graver: str = ""  # The alarm that replaces it: both may have one cause.
    is_reported: bool = False  # By the robot: without contact it stays as it is.
    has_own_topic: bool = False  # It is evaluated without contact, too.
    is_silence: bool = False  # About silence: after a suspension it is our own.
    has_text: bool = False  # Behind its name stands any text, not a node or topic.
    holds: Holds | None = None
    remedy: Remedy | None = None


_HIGH, _MED, _LOW = Priority
_AFTER_GRAPH = 30.0  # A killed node stays on the graph of ROS 2 for about 20 s.
# Of one priority, the one that is listed first is shown first.
KINDS = (
    Kind("moves after stop", _HIGH, when.moves_after_stop),
    Kind("stop not confirmed", _HIGH, when.stop_unconfirmed),
    Kind("stop not certain", _HIGH, when.stop_uncertain, 1.0),
    Kind("several stops", _HIGH, when.several_stop_servers, 2.0),
    Kind(CONTACT_LOST, _HIGH, when.contact_lost, is_silence=True, holds=Holds.UNTIL_OVER),
    Kind(
        *(BATTERY_EMPTY, _HIGH, when.battery_empty, 2.0),
        is_reported=True,
        holds=Holds.UNTIL_ACKNOWLEDGED,
    ),
    Kind("motor silent", _HIGH, when.motor_silent, is_reported=True, is_silence=True),
    Kind("no word of the goal", _HIGH, when.goal_silent, is_reported=True, is_silence=True),
    Kind("node crashed", _HIGH, when.node_crashed),
    Kind(
        *(DIAGNOSTIC_ERROR, _HIGH, when.diagnostic_error, 2.0, 2.0),
        is_reported=True,
        has_own_topic=True,
        has_text=True,
    ),
    Kind(
        *(STOPPED, _MED, when.stopped),
        is_reported=True,
        remedy=Remedy("release", ", then {} to release"),
    ),
    Kind(
        *(LOW_BATTERY, _MED, when.low_battery, 2.0),
        graver=BATTERY_EMPTY,
        is_reported=True,
        holds=Holds.UNTIL_ACKNOWLEDGED,
        remedy=Remedy(_CHARGE, ", or {} to charge"),
    ),
    Kind("battery health", _MED, when.unhealthy_battery, 2.0, is_reported=True),
    Kind("gauge", _MED, when.gauge_warning, 2.0, is_reported=True, has_text=True),
    Kind(
        *(DIAGNOSTIC_WARNING, _MED, when.diagnostic_warning, 2.0, 2.0),
        graver=DIAGNOSTIC_ERROR,
        is_reported=True,
        has_own_topic=True,
        has_text=True,
    ),
    Kind("topic silent", _MED, when.topic_silent, 10.0, is_reported=True, is_silence=True),
    Kind("topic slow", _LOW, when.topic_slow, 5.0, 5.0, is_reported=True),
    Kind("topic fast", _LOW, when.topic_fast, 5.0, 5.0, is_reported=True),
    Kind(
        *("frame silent", _MED, when.frame_silent, 5.0),
        is_reported=True,
        is_silence=True,
        has_text=True,
    ),
    Kind("several publishers", _MED, when.several_publishers, _AFTER_GRAPH),
    Kind("name twice", _MED, when.duplicate_name, _AFTER_GRAPH),
    Kind("no nodes", _MED, when.no_nodes, 5.0),
    Kind("no clock", _MED, when.no_clock, 5.0),
    Kind("clocks differ", _LOW, when.clocks_differ, 5.0),
    Kind(
        *("earlier stop", _LOW, when.earlier_stop),
        remedy=Remedy("release", ": {} to release"),
    ),
    Kind("journal not written", _LOW, when.journal_not_written),
    Kind("recordings", _LOW, when.recording_trouble),
)
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
    """Evaluate the conditions of all alarms.

    While contact is lost, nothing is concluded from the robot's last messages but by diagnostics
    that are still received.
    """
    is_lost = seen.contact_is_lost
    texts, unknown = dict[str, str](), set[str]()
    for kind in KINDS:
        is_left_out = is_lost and kind.is_reported and not kind.has_own_topic
        for subject, text in () if is_left_out else kind.condition(seen):
            name = f"{kind.name} {subject}" if subject else kind.name
            if text is None:
                unknown.add(name)
            else:
                texts[name] = text
    return Conditions(texts, frozenset(unknown))


class AlarmState(Enum):
    """The states of ISA-18.2; the value is the word in the list of alarms."""

    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    ACKNOWLEDGED = "acknowledged"
    RETURNED = "over, unacknowledged"  # ISA-18.2: returned to normal unacknowledged.
    SHELVED = "shelved"
    REPLACED = "replaced by a graver one"  # Ours: for the same cause; it may still hold.


LAST_KNOWN = " (last known)"


class Alarm(NamedTuple):
    """An alarm that is not normal."""

    name: str  # Its kind's, and the node, topic, gauge or part if there may be several.
    text: str  # The situation, and what to do.
    since: UnixTime  # When it was raised.
    state: AlarmState = AlarmState.UNACKNOWLEDGED
    until: UnixTime | None = None  # None while its condition holds.
    shelved_until: UnixTime | None = None  # For people; None if it is not shelved.
    shelf_ends: Monotonic | None = None  # The same, unmoved by the clock.
    reason: str = ""  # The operator's, for shelving it.

    @property
    def kind(self) -> Kind:
        """All that is fixed about it."""
        return kind_of(self.name)

    @property
    def priority(self) -> Priority:
        """The urgency, which its kind decides."""
        return self.kind.priority

    @property
    def holds_until_acknowledged(self) -> bool:
        """True if it holds the queue until the operator acknowledges it."""
        return self.kind.holds is Holds.UNTIL_ACKNOWLEDGED

    @property
    def short_text(self) -> str:
        """The text up to its first colon: what is the case, without what to do."""
        return self.text.partition(": ")[0]

    @property
    def is_over(self) -> bool:
        """True if the condition of the alarm no longer holds."""
        return self.until is not None

    @property
    def acknowledged(self) -> bool:
        """True if nothing is left to acknowledge; a shelved alarm counts as acknowledged."""
        return self.state not in (AlarmState.UNACKNOWLEDGED, AlarmState.RETURNED)

    @property
    def rank(self) -> tuple[bool, bool, bool, int]:
        """The key to sort alarms by: what needs attention first comes first, shelved ones last."""
        shelved = self.state == AlarmState.SHELVED
        return shelved, self.acknowledged, self.is_over, KINDS.index(self.kind)


def any_urgent(alarms: Iterable[Alarm]) -> bool:
    """Return True if an alarm of high priority is unacknowledged and its condition holds."""
    return any(
        alarm.priority == Priority.HIGH and alarm.state == AlarmState.UNACKNOWLEDGED
        for alarm in alarms
    )


def is_diagnostic(alarm: Alarm) -> bool:
    """Return True if an alarm is about a part that the robot reports by diagnostics."""
    return alarm.kind.name in (DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING)


def holding(alarms: Iterable[Alarm]) -> Holding:
    """Return the alarms that hold every queue."""
    active = [alarm for alarm in alarms if alarm.kind.holds is not None and not alarm.is_over]
    now = (
        alarm.name
        for alarm in active
        if not alarm.holds_until_acknowledged or alarm.state == AlarmState.UNACKNOWLEDGED
    )
    return Holding(next(now, ""), frozenset(alarm.name for alarm in active))


def advice(alarm: Alarm, hints: Mapping[str, str]) -> str:
    """Return the text of an alarm, with the command that helps now by `remedy_hints`."""
    remedy = alarm.kind.remedy
    is_past = alarm.is_over or alarm.text.endswith(LAST_KNOWN)
    if remedy is None or remedy.command not in hints or is_past:
        return alarm.text
    return alarm.text + remedy.words.format(hints[remedy.command])


def remedy_hints(snapshot: Snapshot, hints_by_id: Mapping[str, str]) -> dict[str, str]:
    """Return how to give each offered command that helps against alarms, as `press R`."""
    robot, hints = snapshot.file, {}
    if robot.stop is not None and not snapshot.unavailable(robot.stop.release):
        hints["release"] = hints_by_id.get("release", "")
    for command in robot.commands:
        charges = "battery.charging" in command.toggle.values()
        if charges and not snapshot.unavailable(command.service):
            hints.setdefault(_CHARGE, hints_by_id.get(command.id, ""))
    return {command: hint for command, hint in hints.items() if hint}
