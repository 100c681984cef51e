"""An alarm that is not normal, and the board of all of them: conditions and times go into it.

They follow ISA-18.2: one is gone only when its condition is over and the operator has acknowledged
it; a shelved one is silent for a limited time.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from enum import Enum
from typing import NamedTuple

from archo_tui.base.clock import Monotonic, UnixTime
from archo_tui.robot.goals.queue import Holding
from archo_tui.robot.messages.period import LEAST_SILENCE, Pause
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.conditions import (
    CHARGE,
    CONTACT_LOST,
    DIAGNOSTIC_ERROR,
    DIAGNOSTIC_WARNING,
    KINDS,
    Holds,
    Kind,
    Priority,
    graver_name,
    kind_of,
)


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
    def is_urgent(self) -> bool:
        """True if it is of high priority, unacknowledged, and its condition holds."""
        return self.priority is Priority.HIGH and self.state is AlarmState.UNACKNOWLEDGED

    @property
    def rank(self) -> tuple[bool, bool, bool, int]:
        """The key to sort alarms by: what needs attention first comes first, shelved ones last."""
        shelved = self.state == AlarmState.SHELVED
        return shelved, self.acknowledged, self.is_over, KINDS.index(self.kind)


def any_urgent(alarms: Iterable[Alarm]) -> bool:
    """Return True if an alarm of high priority is unacknowledged and its condition holds."""
    return any(alarm.is_urgent for alarm in alarms)


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
            hints.setdefault(CHARGE, hints_by_id.get(command.id, ""))
    return {command: hint for command, hint in hints.items() if hint}


# The board.


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
SHELF_TIME = 600.0  # Seconds that an alarm stays shelved.


class AlarmBoard:
    """All alarms that are not normal.

    Each method that changes alarms returns those whose state differs now, as they are now. An alarm
    that is gone is among them, with the state NORMAL or REPLACED.
    """

    def __init__(self) -> None:
        self._alarms: dict[str, Alarm] = {}
        self._pending: dict[str, float] = {}  # Since when each condition holds, monotonic seconds.
        self._last_found: dict[str, tuple[float, str]] = {}  # When, and the text.
        self._pause = Pause()

    def update(
        self,
        found: dict[str, str],
        monotonic: float,
        now: float,
        known_over: Iterable[str] = (),
        unknown: Collection[str] = (),
    ) -> list[Alarm]:
        """Raise, clear, replace and unshelve alarms by the conditions that hold now.

        Those in `unknown` stay as they are; `known_over` may be cleared although contact is lost,
        which makes all that the robot reports unknown. An alarm that comes off the shelf
        while its condition holds is returned twice: gone, and raised again.
        """
        self._pause = self._pause.checked_at(monotonic)
        changed = self._unshelve(monotonic, now)
        recent = self._recent(found, monotonic)
        # The warning of a part that has just reported an error is none beside it.
        graver = {name for name in recent if self._is_active(name)}
        found = {
            name: text
            for name, text in {**found, **recent}.items()
            if graver_name(name) not in graver
        }
        pending = [*found, *(name for name in unknown if name in self._pending)]
        self._pending = {name: self._pending.get(name, monotonic) for name in pending}
        for name, text in found.items():
            known = self._alarms.get(name)
            if known is not None and not known.is_over:
                self._alarms[name] = known._replace(text=text)
            elif name not in recent and self._is_due(name, monotonic):
                raised = known or Alarm(name, text, now, AlarmState.NORMAL)
                changed += self._change(raised._replace(text=text), Change.RAISED, now)
        for alarm in list(self._alarms.values()):
            graver_one = graver_name(alarm.name)
            if alarm.is_over and graver_one in found and not self._is_active(graver_one):
                # The battery is at least low until it has been empty for that alarm's delay.
                changed += self._change(alarm, Change.RAISED, now)
        for alarm in list(self._alarms.values()):
            graver_one = graver_name(alarm.name)
            if alarm.name in found or alarm.is_over:
                continue
            if graver_one in found:
                # One cause has one alarm at a time, and no moment without an alarm.
                if self._is_active(graver_one):
                    changed += self._change(alarm, Change.REPLACED, now)
                continue
            is_reported = kind_of(alarm.name).is_reported and alarm.name not in known_over
            is_unknown = alarm.name in unknown or (CONTACT_LOST in found and is_reported)
            if is_unknown:
                text = alarm.text.removesuffix(LAST_KNOWN) + LAST_KNOWN
                self._alarms[alarm.name] = alarm._replace(text=text)
                continue
            changed += self._change(alarm, Change.CLEARED, now)
        return changed

    def _unshelve(self, monotonic: float, now: float) -> list[Alarm]:
        changed: list[Alarm] = []
        for alarm in list(self._alarms.values()):
            if alarm.shelf_ends is None:
                continue
            until = now + alarm.shelf_ends - monotonic
            if monotonic >= alarm.shelf_ends:
                changed += self._change(alarm, Change.UNSHELVE, now)
            # The clock of the computer was set: people see when the shelf really ends.
            elif abs(until - (alarm.shelved_until or 0.0)) > 1.0:
                self._alarms[alarm.name] = alarm._replace(shelved_until=until)
        return changed

    def _recent(self, found: Mapping[str, str], monotonic: float) -> dict[str, str]:
        """Return what was found within its off-delay, and is not found now, nor as a graver one.

        So a part that is bad again and again has its alarm, though never for the whole delay.
        """
        self._last_found |= {name: (monotonic, text) for name, text in found.items()}
        self._last_found = {
            name: last
            for name, last in self._last_found.items()
            if monotonic - last[0] < kind_of(name).off_delay
        }
        return {
            name: text
            for name, (_, text) in self._last_found.items()
            if name not in found and graver_name(name) not in found
        }

    def _is_due(self, name: str, monotonic: float) -> bool:
        """Return True if a condition has held for its delay; our own suspension is no silence."""
        kind = kind_of(name)
        is_own = kind.is_silence and monotonic - self._pause.resumed < LEAST_SILENCE
        return not is_own and monotonic - self._pending[name] >= kind.delay

    def acknowledge(self, alarm: Alarm, now: float) -> list[Alarm]:
        """Acknowledge the alarm of that name; one whose condition is over leaves the board."""
        known = self._alarms.get(alarm.name)
        return [] if known is None else self._change(known, Change.ACKNOWLEDGE, now)

    def shelve(self, alarm: Alarm, monotonic: float, now: float, reason: str = "") -> list[Alarm]:
        """Shelve an alarm for SHELF_TIME, or take it off the shelf: `update` may raise it again."""
        if alarm.name not in self._alarms:
            return []
        known = self._alarms[alarm.name]._replace(reason=reason)
        if known.state == AlarmState.SHELVED:
            return self._change(known, Change.UNSHELVE, now)
        ends, until = monotonic + SHELF_TIME, now + SHELF_TIME
        shelved = known._replace(shelf_ends=ends, shelved_until=until)
        return self._change(shelved, Change.SHELVE, now)

    def all(self) -> tuple[Alarm, ...]:
        """Return all alarms in the order of `Alarm.rank`."""
        return tuple(sorted(self._alarms.values(), key=lambda alarm: alarm.rank))

    def _is_active(self, name: str) -> bool:
        return name in self._alarms and not self._alarms[name].is_over

    def _change(self, alarm: Alarm, change: Change, now: float) -> list[Alarm]:
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
    """The high alarms that have called the operator, once each time raised; the caller rings."""

    def __init__(self) -> None:
        self._rung: set[tuple[str, float]] = set()  # Name, and Unix time at which it was raised.

    def take_new(self, alarms: Iterable[Alarm]) -> list[Alarm]:
        """Return the alarms to ring for now, and remember that they have rung."""
        on_board = {(alarm.name, alarm.since): alarm for alarm in alarms}
        self._rung &= on_board.keys()
        new = {
            key: alarm
            for key, alarm in on_board.items()
            if alarm.is_urgent and key not in self._rung
        }
        self._rung |= new.keys()
        return list(new.values())
