"""The kinds of alarms, their priorities, and the alarm itself with its state by ISA-18.2."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from archo_tui.robot.goals.queue import Holding


class Priority(Enum):
    """The urgency of an alarm, by which the operator acts; the value is glyph and word."""

    HIGH = "✗ HIGH"
    MED = "▲ MED"
    LOW = "● LOW"

    @property
    def glyph(self) -> str:
        """The one character that stands for the priority."""
        return self.value[0]


class AlarmState(Enum):
    """The states of ISA-18.2; the value is the word in the list of alarms.

    RETURNED is ISA-18.2's "returned to normal unacknowledged". REPLACED is ours: an alarm of
    higher priority stands for the same cause, so the alarm is gone although nothing is normal.
    """

    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    ACKNOWLEDGED = "acknowledged"
    RETURNED = "over, unacknowledged"
    SHELVED = "shelved"
    REPLACED = "replaced by a graver one"


# The kinds of alarms, as lists, journal and --plain name them.
MOVES_AFTER_STOP = "moves after stop"
STOP_UNCONFIRMED = "stop not confirmed"
STOP_UNCERTAIN = "stop not certain"
SEVERAL_STOP_SERVERS = "several stops"
CONTACT_LOST = "contact lost"
BATTERY_EMPTY = "battery empty"
MOTOR_SILENT = "motor silent"
GOAL_SILENT = "no word of the goal"
NODE_CRASHED = "node crashed"
STOPPED = "stopped"
LOW_BATTERY = "low battery"
BATTERY_HEALTH = "battery health"
GAUGE_WARNING = "gauge"
DIAGNOSTIC_ERROR = "diagnostics error"
DIAGNOSTIC_WARNING = "diagnostics"
SEVERAL_PUBLISHERS = "several publishers"
DUPLICATE_NAME = "name twice"
NO_NODES = "no nodes"
NO_CLOCK = "no clock"
CLOCKS_DIFFER = "clocks differ"
EARLIER_STOP = "earlier stop"
JOURNAL_NOT_WRITTEN = "journal not written"
RECORDING_TROUBLE = "recordings"
BATTERY_ALARMS = LOW_BATTERY, BATTERY_EMPTY
_HOLDING = (CONTACT_LOST, *BATTERY_ALARMS)

# Within a priority, the alarm that is listed first is shown first.
_PRIORITIES = {
    MOVES_AFTER_STOP: Priority.HIGH,
    STOP_UNCONFIRMED: Priority.HIGH,
    STOP_UNCERTAIN: Priority.HIGH,
    SEVERAL_STOP_SERVERS: Priority.HIGH,
    CONTACT_LOST: Priority.HIGH,
    BATTERY_EMPTY: Priority.HIGH,
    MOTOR_SILENT: Priority.HIGH,
    GOAL_SILENT: Priority.HIGH,
    NODE_CRASHED: Priority.HIGH,
    DIAGNOSTIC_ERROR: Priority.HIGH,
    STOPPED: Priority.MED,
    LOW_BATTERY: Priority.MED,
    BATTERY_HEALTH: Priority.MED,
    GAUGE_WARNING: Priority.MED,
    DIAGNOSTIC_WARNING: Priority.MED,
    SEVERAL_PUBLISHERS: Priority.MED,
    DUPLICATE_NAME: Priority.MED,
    NO_NODES: Priority.MED,
    NO_CLOCK: Priority.MED,
    CLOCKS_DIFFER: Priority.LOW,
    EARLIER_STOP: Priority.LOW,
    JOURNAL_NOT_WRITTEN: Priority.LOW,
    RECORDING_TROUBLE: Priority.LOW,
}
_ORDER = list(_PRIORITIES)

LAST_KNOWN = " (last known)"


class Alarm(NamedTuple):
    """An alarm that is not normal.

    Attributes:
        name: The kind of the alarm, followed by the node, topic, gauge or part where there may be
            several.
        text: The situation, and what to do.
        since: Unix time at which it was raised.
        state: The state of the alarm by ISA-18.2.
        until: Unix time at which its condition was over; None while the condition holds.
        shelved_until: Unix time at which the shelf ends, for people; None if it is not shelved.
        shelf_ends: The same in monotonic seconds, so that setting the clock of the computer does
            not silence the alarm for longer.
        reason: The operator's reason for shelving it; "" for none.
    """

    name: str
    text: str
    since: float
    state: AlarmState = AlarmState.UNACKNOWLEDGED
    until: float | None = None
    shelved_until: float | None = None
    shelf_ends: float | None = None
    reason: str = ""

    @property
    def priority(self) -> Priority:
        """The urgency, which its kind decides."""
        return _PRIORITIES[kind_of(self.name)]

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
        return shelved, self.acknowledged, self.is_over, _ORDER.index(kind_of(self.name))


def any_urgent(alarms: Iterable[Alarm]) -> bool:
    """Return True if an alarm of high priority is unacknowledged and its condition holds."""
    return any(
        alarm.priority == Priority.HIGH and alarm.state == AlarmState.UNACKNOWLEDGED
        for alarm in alarms
    )


# Behind their names stands the title of a gauge, or the name of a part: any text.
_WITH_TEXT = (GAUGE_WARNING, DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING)


def kind_of(name: str) -> str:
    """Return the name of an alarm without the node, topic, gauge or part that it is about."""
    for kind in _WITH_TEXT:
        if name.startswith(f"{kind} "):
            return kind
    return name.partition(" /")[0]


def is_diagnostic(alarm: Alarm) -> bool:
    """Return True if an alarm is about a part that the robot reports by diagnostics."""
    return kind_of(alarm.name) in (DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING)


def holding(alarms: Iterable[Alarm]) -> Holding:
    """Return the alarms that hold every queue.

    These are a lost contact, acknowledged or not, and a low or empty battery that is not
    acknowledged.
    """
    active = [alarm for alarm in alarms if alarm.name in _HOLDING and not alarm.is_over]
    now = (
        alarm.name
        for alarm in active
        if alarm.name == CONTACT_LOST or alarm.state == AlarmState.UNACKNOWLEDGED
    )
    return Holding(next(now, ""), frozenset(alarm.name for alarm in active))
