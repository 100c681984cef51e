"""Alarms in the manner of ISA-18.2: a pure state machine that conditions and times go into.

An alarm is gone only when its condition is over and the operator has acknowledged it. A shelved
alarm is silent for a limited time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import NamedTuple

from archo_tui.robot.period import LEAST_SILENCE, Pause
from archo_tui.robot.state import Snapshot


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


class Change(Enum):
    """An event that may change the state of an alarm."""

    RAISED = "raised"  # Its condition holds.
    CLEARED = "cleared"  # Its condition is over.
    ACKNOWLEDGE = "acknowledge"
    SHELVE = "shelve"
    UNSHELVE = "unshelve"  # By the operator, or because its time on the shelf is over.
    REPLACED = "replaced"  # By an alarm of higher priority with the same cause.


_NORMAL, _SHELVED, _REPLACED = AlarmState.NORMAL, AlarmState.SHELVED, AlarmState.REPLACED
_UNACKNOWLEDGED, _ACKNOWLEDGED = AlarmState.UNACKNOWLEDGED, AlarmState.ACKNOWLEDGED
_RETURNED = AlarmState.RETURNED
# A pair that is not listed changes nothing. A shelved alarm stays shelved for its time also if its
# condition is over, and is raised again afterwards if the condition holds then.
TRANSITIONS: dict[tuple[AlarmState, Change], AlarmState] = {
    (_NORMAL, Change.RAISED): _UNACKNOWLEDGED,
    (_UNACKNOWLEDGED, Change.CLEARED): _RETURNED,
    (_UNACKNOWLEDGED, Change.ACKNOWLEDGE): _ACKNOWLEDGED,
    (_UNACKNOWLEDGED, Change.SHELVE): _SHELVED,
    (_UNACKNOWLEDGED, Change.REPLACED): _REPLACED,
    (_ACKNOWLEDGED, Change.CLEARED): _NORMAL,
    (_ACKNOWLEDGED, Change.SHELVE): _SHELVED,
    (_ACKNOWLEDGED, Change.REPLACED): _REPLACED,
    (_RETURNED, Change.RAISED): _UNACKNOWLEDGED,
    (_RETURNED, Change.ACKNOWLEDGE): _NORMAL,
    (_RETURNED, Change.SHELVE): _SHELVED,
    (_SHELVED, Change.UNSHELVE): _NORMAL,
}

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
EARLIER_STOP = "earlier stop"
JOURNAL_NOT_WRITTEN = "journal not written"
RECORDING_TROUBLE = "recordings"

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
    EARLIER_STOP: Priority.LOW,
    JOURNAL_NOT_WRITTEN: Priority.LOW,
    RECORDING_TROUBLE: Priority.LOW,
}
_ORDER = list(_PRIORITIES)

# The alarms that follow from what the robot reports. While contact is lost they stay as they were.
_REPORTED = (
    *(BATTERY_EMPTY, STOPPED, LOW_BATTERY, BATTERY_HEALTH),
    *(MOTOR_SILENT, GOAL_SILENT, GAUGE_WARNING, DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING),
)
_LAST_KNOWN = " (last known)"

_CHARGE = "charge"  # The robot file's command that charges, whatever its id is.
# Alarms that a command helps against: the command's id, and the words around the way to give it.
_REMEDIES = {
    STOPPED: ("release", ", then {} to release"),
    EARLIER_STOP: ("release", ": {} to release"),
    LOW_BATTERY: (_CHARGE, ", or {} to charge"),
}
# Seconds that a condition must hold before the alarm is raised (ISA-18.2's on-delay). 30 s, because
# a killed node stays on the graph of ROS 2 for about 20 s.
ON_DELAY = {
    LOW_BATTERY: 2.0,
    BATTERY_EMPTY: 2.0,
    BATTERY_HEALTH: 2.0,
    GAUGE_WARNING: 2.0,
    DIAGNOSTIC_ERROR: 2.0,
    DIAGNOSTIC_WARNING: 2.0,
    STOP_UNCONFIRMED: 1.0,
    STOP_UNCERTAIN: 1.0,
    SEVERAL_STOP_SERVERS: 2.0,
    SEVERAL_PUBLISHERS: 30.0,
    DUPLICATE_NAME: 30.0,
    NO_NODES: 5.0,
    NO_CLOCK: 5.0,
}
SHELF_TIME = 600.0  # Seconds that an alarm stays shelved.


class Alarm(NamedTuple):
    """An alarm that is not normal.

    Attributes:
        name: Its kind, followed by the node, topic or gauge where there may be several.
        text: What is the case and what to do.
        since: Unix time at which it was raised.
        state: Its state by ISA-18.2.
        until: Unix time at which its condition was over; None while the condition holds.
        shelved_until: Unix time at which the shelf ends, for people; None if it is not shelved.
        shelf_ends: The same in monotonic seconds, so that setting the clock of the computer does
            not silence the alarm for longer.
        reason: Why the operator shelved it.
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
        return _PRIORITIES[_kind(self.name)]

    @property
    def is_over(self) -> bool:
        """True if its condition no longer holds."""
        return self.until is not None

    @property
    def acknowledged(self) -> bool:
        """True if nothing is left to acknowledge."""
        return self.state not in (AlarmState.UNACKNOWLEDGED, AlarmState.RETURNED)

    @property
    def rank(self) -> tuple[bool, bool, bool, int]:
        """The key to sort alarms by: what needs attention first comes first."""
        shelved = self.state == AlarmState.SHELVED
        return shelved, self.acknowledged, self.is_over, _ORDER.index(_kind(self.name))


def any_urgent(alarms: Iterable[Alarm]) -> bool:
    """Return whether an active alarm of high priority is not acknowledged."""
    return any(
        alarm.priority == Priority.HIGH and alarm.state == AlarmState.UNACKNOWLEDGED
        for alarm in alarms
    )


def advice(alarm: Alarm, hints: Mapping[str, str]) -> str:
    """Return the text of an alarm, with the command that helps while its condition holds.

    Args:
        alarm: The alarm.
        hints: How to give each command that may help, from `remedy_hints`.
    """
    command, words = _REMEDIES.get(alarm.name, ("", ""))
    if command not in hints or alarm.is_over or alarm.text.endswith(_LAST_KNOWN):
        return alarm.text
    return alarm.text + words.format(hints[command])


def remedy_hints(snapshot: Snapshot, hints_by_id: Mapping[str, str]) -> dict[str, str]:
    """Choose how to give the commands that help against alarms.

    Args:
        snapshot: What is known of the robot: a command that no node offers is left out.
        hints_by_id: How to give each command by its id, as `press R` or `type release`.

    Returns:
        The hints that `advice` takes.
    """
    robot, hints = snapshot.file, {}
    if robot.stop is not None and not snapshot.unavailable(robot.stop.release):
        hints["release"] = hints_by_id.get("release", "")
    for command in robot.commands:
        charges = "battery.charging" in command.toggle.values()
        if charges and not snapshot.unavailable(command.service):
            hints.setdefault(_CHARGE, hints_by_id.get(command.id, ""))
    return {command: hint for command, hint in hints.items() if hint}


# Behind their names stands the title of a gauge, or the name of a part: any text.
_WITH_TEXT = (GAUGE_WARNING, DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING)


def _kind(name: str) -> str:
    """Return the name of an alarm without the node, topic, gauge or part that it is about."""
    for kind in _WITH_TEXT:
        if name.startswith(f"{kind} "):
            return kind
    return name.partition(" /")[0]


def is_diagnostic(alarm: Alarm) -> bool:
    """Return whether an alarm is about a part that the robot reports by diagnostics."""
    return _kind(alarm.name) in (DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING)


def _graver_name(name: str) -> str:
    """Return the name of the alarm that is graver and has the same cause; "" if there is none."""
    if name == LOW_BATTERY:
        return BATTERY_EMPTY
    if _kind(name) == DIAGNOSTIC_WARNING:
        return DIAGNOSTIC_ERROR + name.removeprefix(DIAGNOSTIC_WARNING)
    return ""


class AlarmBoard:
    """All alarms that are not normal.

    Each method that changes alarms returns those whose state differs now, as they are now. An
    alarm that is gone is among them, with the state NORMAL or REPLACED.
    """

    def __init__(self) -> None:
        """Make an empty board."""
        self._alarms: dict[str, Alarm] = {}
        self._pending: dict[str, float] = {}  # Since when each condition holds, monotonic seconds.
        self._pause = Pause()

    def copy(self) -> AlarmBoard:
        """Return another board with the same alarms, which changes independently."""
        board = AlarmBoard()
        board._alarms, board._pending = dict(self._alarms), dict(self._pending)
        board._pause = self._pause
        return board

    def update(
        self, found: dict[str, str], monotonic: float, now: float, known_over: Iterable[str] = ()
    ) -> list[Alarm]:
        """Raise, clear and unshelve alarms by the conditions that hold now.

        Args:
            found: The texts of the conditions that hold, by alarm name (see `conditions`).
            monotonic: The time now, in monotonic seconds.
            now: The same as a Unix time.
            known_over: Alarms that are cleared although contact is lost. All others that follow
                from the robot's reports stay until there is contact again.

        Returns:
            The alarms whose state has changed.
        """
        changed: list[Alarm] = []
        self._pause = self._pause.checked_at(monotonic)
        just_resumed = monotonic - self._pause.resumed < LEAST_SILENCE
        for alarm in list(self._alarms.values()):
            if alarm.shelf_ends is not None and monotonic >= alarm.shelf_ends:
                changed += self._change(alarm, Change.UNSHELVE, now)
            elif alarm.shelf_ends is not None:
                until = now + alarm.shelf_ends - monotonic
                # The clock of the computer was set: people see when the shelf really ends.
                if abs(until - (alarm.shelved_until or 0.0)) > 1.0:
                    self._alarms[alarm.name] = alarm._replace(shelved_until=until)
        self._pending = {name: self._pending.get(name, monotonic) for name in found}
        for name, text in found.items():
            known = self._alarms.get(name)
            if known is not None and not known.is_over:
                self._alarms[name] = known._replace(text=text)
            elif _kind(name) in (CONTACT_LOST, MOTOR_SILENT, GOAL_SILENT) and just_resumed:
                continue  # The silence was this process's own: it was suspended.
            elif monotonic - self._pending[name] >= ON_DELAY.get(_kind(name), 0.0):
                raised = known or Alarm(name, text, now, AlarmState.NORMAL)
                changed += self._change(raised._replace(text=text), Change.RAISED, now)
        for alarm in list(self._alarms.values()):
            graver = _graver_name(alarm.name)
            if alarm.is_over and graver in found and not self._is_active(graver):
                # The battery is at least low until BATTERY_EMPTY has held for its on-delay.
                changed += self._change(alarm, Change.RAISED, now)
        for alarm in list(self._alarms.values()):
            graver = _graver_name(alarm.name)
            if alarm.name in found or alarm.is_over:
                continue
            if graver in found:
                # One cause has one alarm at a time, and no moment without an alarm.
                if self._is_active(graver):
                    changed += self._change(alarm, Change.REPLACED, now)
                continue
            is_reported = _kind(alarm.name) in _REPORTED and alarm.name not in known_over
            if CONTACT_LOST in found and is_reported:
                text = alarm.text.removesuffix(_LAST_KNOWN) + _LAST_KNOWN
                self._alarms[alarm.name] = alarm._replace(text=text)
                continue
            changed += self._change(alarm, Change.CLEARED, now)
        return changed

    def acknowledge(self, alarm: Alarm, now: float) -> list[Alarm]:
        """Acknowledge an alarm: the operator has seen it.

        Args:
            alarm: The alarm as the operator saw it; its state by now decides what changes.
            now: The time now, as a Unix time.

        Returns:
            The alarm if its state has changed, else an empty list.
        """
        return self._change(self._alarms.get(alarm.name, alarm), Change.ACKNOWLEDGE, now)

    def shelve(self, alarm: Alarm, monotonic: float, now: float, reason: str = "") -> list[Alarm]:
        """Shelve an alarm for SHELF_TIME; if it is shelved, take it off the shelf.

        Args:
            alarm: The alarm as the operator saw it; its state by now decides what changes.
            monotonic: The time now, in monotonic seconds.
            now: The same as a Unix time.
            reason: Why it is shelved, for the list and the journal.

        Returns:
            The alarm if its state has changed, else an empty list.
        """
        known = self._alarms.get(alarm.name, alarm)._replace(reason=reason)
        if known.state == AlarmState.SHELVED:
            return self._change(known, Change.UNSHELVE, now)
        ends, until = monotonic + SHELF_TIME, now + SHELF_TIME
        shelved = known._replace(shelf_ends=ends, shelved_until=until)
        return self._change(shelved, Change.SHELVE, now)

    def all(self) -> tuple[Alarm, ...]:
        """Return all alarms: unacknowledged first, then active, then by priority; shelved last."""
        return tuple(sorted(self._alarms.values(), key=lambda alarm: alarm.rank))

    def _is_active(self, name: str) -> bool:
        return name in self._alarms and not self._alarms[name].is_over

    def _change(self, alarm: Alarm, change: Change, now: float) -> list[Alarm]:
        """Carry out a change and keep its times; return the alarm if its state differs now."""
        state = TRANSITIONS.get((alarm.state, change), alarm.state)
        new = alarm._replace(state=state)
        if change in (Change.CLEARED, Change.REPLACED):
            new = new._replace(until=now)
        elif change == Change.RAISED:
            since = alarm.since if alarm.state == AlarmState.SHELVED else now
            new = new._replace(since=since, until=None)
        if state != AlarmState.SHELVED:
            new = new._replace(shelf_ends=None, shelved_until=None)
        if state in (AlarmState.NORMAL, AlarmState.REPLACED):
            self._alarms.pop(alarm.name, None)
        else:
            self._alarms[alarm.name] = new
        return [new] if state != alarm.state else []


class AlarmBell:
    """The record of which alarms the operator was called for, by bell and notification.

    An alarm of high priority calls once each time that it is raised.
    """

    def __init__(self) -> None:
        """Create a bell that has not rung for any alarm."""
        self._rung: set[tuple[str, float]] = set()  # Name, and Unix time at which it was raised.

    def take_new(self, alarms: Iterable[Alarm]) -> list[Alarm]:
        """Return the alarms to ring for now, and remember that they have rung.

        Args:
            alarms: All alarms on the board.
        """
        on_board = {(alarm.name, alarm.since): alarm for alarm in alarms}
        self._rung &= on_board.keys()
        new = {
            key: alarm
            for key, alarm in on_board.items()
            if alarm.priority == Priority.HIGH
            and alarm.state == AlarmState.UNACKNOWLEDGED
            and key not in self._rung
        }
        self._rung |= new.keys()
        return list(new.values())
