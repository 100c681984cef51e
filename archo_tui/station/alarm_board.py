"""The board of all alarms that are not normal: conditions and times go into it.

Its alarms follow ISA-18.2: one is gone only when its condition is over and the operator has
acknowledged it; a shelved one is silent for a limited time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum

from archo_tui.robot.period import LEAST_SILENCE, Pause
from archo_tui.station.alarms import (
    BATTERY_EMPTY,
    BATTERY_HEALTH,
    CLOCKS_DIFFER,
    CONTACT_LOST,
    DIAGNOSTIC_ERROR,
    DIAGNOSTIC_WARNING,
    DUPLICATE_NAME,
    GAUGE_WARNING,
    GOAL_SILENT,
    LAST_KNOWN,
    LOW_BATTERY,
    MOTOR_SILENT,
    NO_CLOCK,
    NO_NODES,
    SEVERAL_PUBLISHERS,
    SEVERAL_STOP_SERVERS,
    STOP_UNCERTAIN,
    STOP_UNCONFIRMED,
    STOPPED,
    Alarm,
    AlarmState,
    kind_of,
)


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
# The alarms that follow from what the robot reports. While contact is lost they stay as they were.
_REPORTED = (
    *(BATTERY_EMPTY, STOPPED, LOW_BATTERY, BATTERY_HEALTH),
    *(MOTOR_SILENT, GOAL_SILENT, GAUGE_WARNING, DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING),
)
# Seconds that a condition must hold before the alarm is raised (ISA-18.2's on-delay). 30 s, because
# a killed node stays on the graph of ROS 2 for about 20 s.
ON_DELAY = {
    LOW_BATTERY: 2.0,
    BATTERY_EMPTY: 2.0,
    BATTERY_HEALTH: 2.0,
    GAUGE_WARNING: 2.0,
    DIAGNOSTIC_ERROR: 2.0,
    DIAGNOSTIC_WARNING: 2.0,
    STOP_UNCONFIRMED: 0.0,  # The condition itself waits for an answer.
    STOP_UNCERTAIN: 1.0,
    SEVERAL_STOP_SERVERS: 2.0,
    SEVERAL_PUBLISHERS: 30.0,
    DUPLICATE_NAME: 30.0,
    NO_NODES: 5.0,
    NO_CLOCK: 5.0,
    CLOCKS_DIFFER: 5.0,
}
SHELF_TIME = 600.0  # Seconds that an alarm stays shelved.


def _graver_name(name: str) -> str:
    """Return the name of the graver alarm that may have the same cause; "" if there is none."""
    if name == LOW_BATTERY:
        return BATTERY_EMPTY
    if kind_of(name) == DIAGNOSTIC_WARNING:
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
        self._last_found: dict[str, tuple[float, str]] = {}  # Of diagnostics: when, and the text.

    def copy(self) -> AlarmBoard:
        """Return another board with the same alarms, which changes independently."""
        board = AlarmBoard()
        board._alarms, board._pending = dict(self._alarms), dict(self._pending)
        board._pause, board._last_found = self._pause, dict(self._last_found)
        return board

    def update(
        self, found: dict[str, str], monotonic: float, now: float, known_over: Iterable[str] = ()
    ) -> list[Alarm]:
        """Raise, clear, replace and unshelve alarms by the conditions that hold now.

        A condition must have held for its ON_DELAY before its alarm is raised; a diagnostics
        condition counts as holding for the same time after it was last found. The texts of alarms
        that stay are brought up to date, too. Alarms about silence are not raised just after this
        process was suspended.

        Args:
            found: The texts of the conditions that hold, by alarm name (see `conditions`).
            monotonic: The time now, in monotonic seconds.
            now: The same as a Unix time.
            known_over: Names of alarms that may be cleared although contact is lost. All others
                that follow from the robot's reports stay, as last known, until there is contact
                again.

        Returns:
            The alarms whose state has changed. An alarm that comes off the shelf while its
            condition holds is in the list twice: gone, and raised again.
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
        flapping = self._flapping(found, monotonic)
        found = {**found, **flapping}
        for name in flapping:  # The warning of a part that has just reported an error.
            if kind_of(name) == DIAGNOSTIC_ERROR and self._is_active(name):
                found.pop(DIAGNOSTIC_WARNING + name.removeprefix(DIAGNOSTIC_ERROR), None)
        self._pending = {name: self._pending.get(name, monotonic) for name in found}
        for name, text in found.items():
            known = self._alarms.get(name)
            if known is not None and not known.is_over:
                self._alarms[name] = known._replace(text=text)
            elif name in flapping:
                continue
            elif kind_of(name) in (CONTACT_LOST, MOTOR_SILENT, GOAL_SILENT) and just_resumed:
                continue  # The silence was this process's own: it was suspended.
            elif monotonic - self._pending[name] >= ON_DELAY.get(kind_of(name), 0.0):
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
            is_reported = kind_of(alarm.name) in _REPORTED and alarm.name not in known_over
            if CONTACT_LOST in found and is_reported:
                text = alarm.text.removesuffix(LAST_KNOWN) + LAST_KNOWN
                self._alarms[alarm.name] = alarm._replace(text=text)
                continue
            changed += self._change(alarm, Change.CLEARED, now)
        return changed

    def _flapping(self, found: Mapping[str, str], monotonic: float) -> dict[str, str]:
        """Return the diagnostics alarms found less than their ON_DELAY ago, but not in `found`.

        A warning is left out if the error of the same part is in `found`. So a part that is bad
        again and again has its alarm, though it is never bad for the whole delay. The diagnostics
        in `found` are remembered for the next calls.

        Returns:
            The last text of each alarm, by its name.
        """
        for name, text in found.items():
            if kind_of(name) in (DIAGNOSTIC_ERROR, DIAGNOSTIC_WARNING):
                self._last_found[name] = monotonic, text
        self._last_found = {
            name: (last, text)
            for name, (last, text) in self._last_found.items()
            if monotonic - last < ON_DELAY[kind_of(name)]
        }
        return {
            name: text
            for name, (_, text) in self._last_found.items()
            if name not in found and _graver_name(name) not in found
        }

    def acknowledge(self, alarm: Alarm, now: float) -> list[Alarm]:
        """Acknowledge an alarm: the operator has seen it.

        An alarm whose condition is over leaves the board. One that is acknowledged, shelved or gone
        already stays as it is.

        Args:
            alarm: The alarm as the operator saw it; the alarm of its name on the board is changed.
            now: The time now, as a Unix time.

        Returns:
            The alarm if its state has changed, else an empty list.
        """
        known = self._alarms.get(alarm.name)
        return [] if known is None else self._change(known, Change.ACKNOWLEDGE, now)

    def shelve(self, alarm: Alarm, monotonic: float, now: float, reason: str = "") -> list[Alarm]:
        """Shelve an alarm for SHELF_TIME; if it is shelved, take it off the shelf.

        An alarm that is taken off is gone, and raised again by the next `update` if its condition
        holds.

        Args:
            alarm: The alarm as the operator saw it; the alarm of its name on the board is changed.
            monotonic: The time now, in monotonic seconds.
            now: The same as a Unix time.
            reason: The reason for shelving it, for the list and the journal.

        Returns:
            The alarm if its state has changed, else an empty list.
        """
        if alarm.name not in self._alarms:
            return []
        known = self._alarms[alarm.name]._replace(reason=reason)
        if known.state == AlarmState.SHELVED:
            return self._change(known, Change.UNSHELVE, now)
        ends, until = monotonic + SHELF_TIME, now + SHELF_TIME
        shelved = known._replace(shelf_ends=ends, shelved_until=until)
        return self._change(shelved, Change.SHELVE, now)

    def all(self) -> tuple[Alarm, ...]:
        """Return all alarms in the order of `Alarm.rank`.

        Unacknowledged alarms come first, then acknowledged, then shelved ones; among them active
        ones before those that are over, then the more important kinds.
        """
        return tuple(sorted(self._alarms.values(), key=lambda alarm: alarm.rank))

    def _is_active(self, name: str) -> bool:
        return name in self._alarms and not self._alarms[name].is_over

    def _change(self, alarm: Alarm, change: Change, now: float) -> list[Alarm]:
        """Put an alarm on the board in the state and with the times that a change gives it.

        The state stays if TRANSITIONS has no other. An alarm that is gone is removed.

        Returns:
            The alarm as it is now, if its state differs; else an empty list.
        """
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
