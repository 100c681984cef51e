"""Alarms in the manner of ISA-18.2, as a pure state machine: conditions and times come in.

An alarm is gone only when it is over and acknowledged. Shelved, it is silent for a limited time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import NamedTuple

from archo_tui.clock import time_of_day
from archo_tui.robot.period import LEAST_SILENCE, Pause
from archo_tui.robot.state import (
    Hosted,
    Latch,
    Life,
    OpenStop,
    Phase,
    Snapshot,
    StopAnswer,
    not_offered,
)


class Priority(Enum):
    """How soon to act; the value is glyph and word."""

    HIGH = "✗ HIGH"
    MED = "▲ MED"
    LOW = "● LOW"

    @property
    def glyph(self) -> str:
        """The first character of it."""
        return self.value[0]


class State(Enum):
    """The states of ISA-18.2; the value is the word in the list."""

    NORMAL = "normal"
    UNACKNOWLEDGED = "unacknowledged"
    ACKNOWLEDGED = "acknowledged"
    OVER = "over, unacknowledged"
    SHELVED = "shelved"
    REPLACED = "replaced by a graver one"  # of the same cause: it is not normal, and gone


class Change(Enum):
    """What can happen to an alarm."""

    RAISED = "raised"
    CLEARED = "cleared"
    ACKNOWLEDGE = "acknowledge"
    SHELVE = "shelve"
    UNSHELVE = "unshelve"  # by the operator, or because its time is over
    REPLACED = "replaced"  # by a graver alarm of the same cause


_NORMAL, _UNSEEN, _SEEN = State.NORMAL, State.UNACKNOWLEDGED, State.ACKNOWLEDGED
_OVER, _SHELVED, _REPLACED = State.OVER, State.SHELVED, State.REPLACED
# what is not here changes nothing; a shelved alarm that clears stays shelved for its time, and is
# raised again after it if its condition holds then
TRANSITIONS: dict[tuple[State, Change], State] = {
    (_NORMAL, Change.RAISED): _UNSEEN,
    (_UNSEEN, Change.CLEARED): _OVER,
    (_UNSEEN, Change.ACKNOWLEDGE): _SEEN,
    (_UNSEEN, Change.SHELVE): _SHELVED,
    (_UNSEEN, Change.REPLACED): _REPLACED,
    (_SEEN, Change.CLEARED): _NORMAL,
    (_SEEN, Change.SHELVE): _SHELVED,
    (_SEEN, Change.REPLACED): _REPLACED,
    (_OVER, Change.RAISED): _UNSEEN,
    (_OVER, Change.ACKNOWLEDGE): _NORMAL,
    (_OVER, Change.SHELVE): _SHELVED,
    (_SHELVED, Change.UNSHELVE): _NORMAL,
}

CONTACT_LOST, UNCONFIRMED, EMPTY = "contact lost", "stop not confirmed", "battery empty"
STOPPED, LOW, CRASHED = "stopped", "low battery", "node crashed"
WORD, MIXED, TWICE = "battery health", "several publishers", "name twice"
NO_WORD = "no word of the goal"
SILENT, UNWRITTEN, GAUGE = "motor silent", "journal not written", "gauge"
UNRECORDED = "recordings"
UNCERTAIN = "stop not certain"
OUTLIVED, STOPS = "moves after stop", "several stops"
NOBODY, NO_CLOCK = "no nodes", "no clock"
EARLIER = "earlier stop"
_PRIORITIES = {
    OUTLIVED: Priority.HIGH,
    UNCONFIRMED: Priority.HIGH,
    UNCERTAIN: Priority.HIGH,
    STOPS: Priority.HIGH,
    CONTACT_LOST: Priority.HIGH,
    EMPTY: Priority.HIGH,
    SILENT: Priority.HIGH,
    NO_WORD: Priority.HIGH,
    CRASHED: Priority.HIGH,
    STOPPED: Priority.MED,
    LOW: Priority.MED,
    WORD: Priority.MED,
    GAUGE: Priority.MED,
    MIXED: Priority.MED,
    TWICE: Priority.MED,
    NOBODY: Priority.MED,
    NO_CLOCK: Priority.MED,
    EARLIER: Priority.LOW,
    UNWRITTEN: Priority.LOW,
    UNRECORDED: Priority.LOW,
}  # of each kind; the worst first
_ORDER = list(_PRIORITIES)

# of what the robot says: they stand as they were while it is not heard
_HEARD = (EMPTY, STOPPED, LOW, WORD, SILENT, NO_WORD, GAUGE)
_LAST_KNOWN = " (last known)"
_CHARGER = "the command that charges"
# what to do, where that is a command: its id, and the words around the way to give it
_REMEDIES = {
    STOPPED: ("release", ", then {} to release"),
    EARLIER: ("release", ": {} to release"),
    LOW: (_CHARGER, ", or {} to charge"),
}
# s that a condition must hold before it counts; a node that was killed lingers on a ROS 2 graph
# for about 20 s
ON_DELAY = {
    LOW: 2.0,
    EMPTY: 2.0,
    WORD: 2.0,
    GAUGE: 2.0,
    UNCONFIRMED: 1.0,
    UNCERTAIN: 1.0,
    STOPS: 2.0,
    MIXED: 30.0,
    TWICE: 30.0,
    NOBODY: 5.0,
    NO_CLOCK: 5.0,
}
SHELF_TIME = 600.0  # s


class Alarm(NamedTuple):
    """One alarm; `text` says what and what to do. Times are Unix times, but for `shelf_ends`."""

    name: str  # its kind, and of which node where there are several
    text: str
    since: float
    state: State = State.UNACKNOWLEDGED
    until: float | None = None  # when its condition was over
    shelved_until: float | None = None  # as a time of day, for people
    shelf_ends: float | None = None  # monotonic s: a clock that is set must not silence it longer
    reason: str = ""  # why it was shelved

    @property
    def priority(self) -> Priority:
        """How soon to act."""
        return _PRIORITIES[_kind(self.name)]

    @property
    def is_over(self) -> bool:
        """True when its condition no longer holds."""
        return self.until is not None

    @property
    def acknowledged(self) -> bool:
        """True when nothing is left to acknowledge."""
        return self.state not in (State.UNACKNOWLEDGED, State.OVER)

    @property
    def rank(self) -> tuple[bool, bool, bool, int]:
        """Sorts what needs attention first to the front."""
        shelved = self.state == State.SHELVED
        return shelved, self.acknowledged, self.is_over, _ORDER.index(_kind(self.name))


def is_grave(alarms: Iterable[Alarm]) -> bool:
    """True while one of the gravest is not acknowledged."""
    return any(
        one.priority == Priority.HIGH and one.state == State.UNACKNOWLEDGED for one in alarms
    )


def advice(alarm: Alarm, given: Mapping[str, str]) -> str:
    """What an alarm says, with what to do; `given` says how: `press R` (see `ways`)."""
    command, words = _REMEDIES.get(alarm.name, ("", ""))
    if command not in given or alarm.is_over or alarm.text.endswith(_LAST_KNOWN):
        return alarm.text
    return alarm.text + words.format(given[command])


def ways(snapshot: Snapshot, by_id: Mapping[str, str]) -> dict[str, str]:
    """Return how to give the commands that `advice` knows; none of those that no node offers."""
    robot, found = snapshot.file, {}
    if robot.stop is not None and not snapshot.unavailable(robot.stop.release):
        found["release"] = by_id.get("release", "")
    for command in robot.commands:
        charges = "battery.charging" in command.toggle.values()
        if charges and not snapshot.unavailable(command.service):
            found.setdefault(_CHARGER, by_id.get(command.id, ""))
    return {name: way for name, way in found.items() if way}


def _kind(name: str) -> str:
    """Without the node that it is about."""
    return GAUGE if name.startswith(f"{GAUGE} ") else name.partition(" /")[0]


def conditions(
    snapshot: Snapshot,
    now: float,
    hosted: Iterable[Hosted] = (),
    unwritten: str = "",
    unrecorded: str = "",
    unseen: str = "",
    earlier_stop: float | None = None,
) -> dict[str, str]:
    """Which alarms' conditions hold at `now` (monotonic s), with the text for each.

    `unwritten` is why the journal is not written, `unrecorded` the text about recordings,
    `unseen` where no node is, when none is found, and what to try. `earlier_stop` is the Unix time
    of a STOP from before this console's start that the journal has no release of.
    """
    battery, motion = snapshot.battery, snapshot.motion
    found: dict[str, str] = {}
    if snapshot.open_stop is not None:
        text = stop_texts(snapshot, snapshot.open_stop, now)[0]
        found[UNCONFIRMED] = f"{text}: use the hardware stop"
    if snapshot.latch is Latch.UNCERTAIN:
        found[UNCERTAIN] = (
            f"STOP OF {time_of_day(snapshot.latch_time)[:-3]} IS NO LONGER CERTAIN: "
            f"{snapshot.latch_lost}: stop again, or release it"
        )
    stop = snapshot.file.stop
    if stop is not None and stop.service in snapshot.several:
        nodes = snapshot.several[stop.service]
        found[STOPS] = (
            f"{len(nodes)} NODES SERVE {stop.service}: {', '.join(nodes)}: STOP must be confirmed "
            "by all of them; keep the hardware stop at hand"
        )
    is_known = snapshot.released is not None or snapshot.is_stopped
    if earlier_stop is not None and not (is_known or motion.stopped is not None or motion.moving):
        found[EARLIER] = (
            f"STOP OF {time_of_day(earlier_stop)[:-3]} HAS NO RELEASE IN THE JOURNAL: "
            "the robot may still be stopped"
        )
    if _moves_on(snapshot, now):
        found[OUTLIVED] = "THE ROBOT MOVES ALTHOUGH STOP WAS SENT: use the hardware stop"
    if snapshot.outlived:
        runs = "RUNS" if len(snapshot.outlived) == 1 else "RUN"
        found[OUTLIVED] = (
            f"STOP WAS ANSWERED, BUT {', '.join(snapshot.outlived)} STILL {runs}: "
            "use the hardware stop"
        )
    if unwritten:
        found[UNWRITTEN] = f"JOURNAL NOT WRITTEN: {unwritten}"
    if unrecorded:
        found[UNRECORDED] = unrecorded
    hosted = tuple(hosted)
    heard = battery.received is not None or motion.received is not None
    if unseen and not (heard or hosted or snapshot.nodes or snapshot.elsewhere):
        found[NOBODY] = f"NO NODES {unseen}"
    waiting = [p.node for p in snapshot.parameters if p.name == "use_sim_time" and p.value is True]
    if waiting and not snapshot.has_clock:
        found[NO_CLOCK] = (
            f"NO CLOCK for {', '.join(waiting)}: use_sim_time is true and nobody publishes /clock: "
            "start the simulator, or set it to false"
        )
    for node in hosted:
        if node.life == Life.CRASHED:
            found[f"{CRASHED} {node.name}"] = (
                f"NODE CRASHED {node.name}: see why in Nodes, then start it again"
            )
    for topic, names in snapshot.publishers.items():
        found[f"{MIXED} /{topic}"] = (
            f"{len(names)} PUBLISHERS of {topic}: {', '.join(names)}: their readings come mixed"
        )
    for name in snapshot.twice:
        found[f"{TWICE} {name}"] = f"TWO NODES NAMED {name}: a call reaches both of them"
    if heard and (
        (battery.received is None or battery.is_old(now))
        and (motion.received is None or motion.is_old(now))
    ):
        # one cause, one alarm: what was last heard says nothing about now
        last = max(battery.received or 0.0, motion.received or 0.0)
        found[CONTACT_LOST] = f"CONTACT LOST for {now - last:.0f} s: the robot may still be moving"
        return found
    goal = snapshot.running_goal
    moving = goal is not None
    dock = "dock the robot when this move is done" if moving else "dock the robot"
    if battery.percentage is not None and not battery.is_old(now):
        if battery.percentage <= 0.0:
            described = snapshot.file.battery
            refuses = described is not None and described.empty_refuses_moves
            more = "the robot refuses moves, charge it where it stands" if refuses else "charge it"
            found[EMPTY] = f"BATTERY EMPTY: {more}"
        elif is_low(snapshot) and not battery.charging:
            found[LOW] = f"LOW BATTERY {battery.percentage:.1f} %: {dock}"
    if battery.health and not battery.is_old(now):
        if not health(snapshot):
            found[WORD] = f"BATTERY HEALTH {battery.health}: the console does not know this word"
        elif health(snapshot) == "replace":
            found[WORD] = f"BATTERY HEALTH {battery.health}: have the battery replaced"
    if motion.received is not None and motion.is_old(now) and (moving or motion.moving):
        topic = snapshot.file.motion.topic if snapshot.file.motion else "motion"
        found[SILENT] = (
            f"{topic} silent for {now - motion.received:.0f} s while moving: "
            "the robot may still be driving"
        )
    elif goal is not None and goal.phase == Phase.LOST:
        found[NO_WORD] = (
            f"NO WORD FROM {goal.kind.title.upper()} for {now - (goal.heard or goal.sent):.0f} s: "
            "the robot may still be driving"
        )
    if snapshot.is_at_rest:
        found[STOPPED] = "STOPPED: look for the cause"
    for reading in snapshot.gauges:
        if reading.warns and not reading.is_old(now):
            name, unit = reading.gauge.title, reading.gauge.unit
            found[f"{GAUGE} {name}"] = (
                f"{name.upper()} {reading.value:g} {unit}".rstrip() + f": {reading.warns}"
            )
    return found


def stop_texts(snapshot: Snapshot, stop: OpenStop, now: float) -> tuple[str, ...]:
    """What came of a STOP that the robot has not confirmed: in full, and ever shorter."""
    waited, answer, why = now - stop.asked, stop.answer, stop.why
    if answer not in (StopAnswer.AWAITED, StopAnswer.NONE):
        return (f"STOP {answer.value} {why}".rstrip(),)
    service = "" if snapshot.file.stop is None else snapshot.file.stop.service
    if service not in snapshot.offered and answer == StopAnswer.AWAITED:
        # it waits for a server, or the one that it was sent to has left
        return f"STOP NOT CONFIRMED ({not_offered(service)})", "STOP NOT CONFIRMED"
    if waited < 1:
        return ("STOP SENT",)
    silent = f"STOP SENT, {StopAnswer.NONE.value} {why}".rstrip() + f" for {waited:.0f} s"
    again = answer == StopAnswer.NONE
    more = ", sent again while the robot is heard" if again else " (not confirmed by the robot)"
    return silent + more, silent, f"STOP SENT, silent {waited:.0f} s"


def _moves_on(snapshot: Snapshot, now: float) -> bool:
    """True when the robot says that it moves, a while after a STOP."""
    stop, motion = snapshot.open_stop, snapshot.motion
    if motion.received is None or motion.is_old(now):
        return False
    if stop is None or stop.answer == StopAnswer.NOT_SENT:
        return snapshot.moves_on
    return bool(motion.moving) and motion.received - stop.asked >= 1.0


def is_low(snapshot: Snapshot) -> bool:
    """By the robot's own word, or by its percentage: a good word says nothing against that."""
    charge, threshold = snapshot.battery.percentage, snapshot.threshold
    is_below = charge is not None and threshold is not None and charge < threshold
    return is_below or health(snapshot) == "low"


def health(snapshot: Snapshot) -> str:
    """What the battery's word means: good, low, replace; empty: none was said, or it is unknown."""
    described = snapshot.file.battery
    return "" if described is None else described.health.get(snapshot.battery.health or "", "")


class AlarmBoard:
    """The alarms that are not normal. Every method that changes some returns them as they are."""

    def __init__(self) -> None:
        self._alarms: dict[str, Alarm] = {}
        self._pending: dict[str, float] = {}  # condition -> monotonic s since it holds
        self._pause = Pause()

    def copy(self) -> AlarmBoard:
        """Another one with the same alarms."""
        board = AlarmBoard()
        board._alarms, board._pending = dict(self._alarms), dict(self._pending)
        board._pause = self._pause
        return board

    def update(
        self, found: dict[str, str], monotonic: float, now: float, known_over: Iterable[str] = ()
    ) -> list[Alarm]:
        """Take the conditions that hold now (`conditions`); `now` is a Unix time.

        While contact is lost, alarms by what the robot said stay, but for those in `known_over`.
        """
        changed: list[Alarm] = []
        self._pause = self._pause.look(monotonic)
        just_resumed = monotonic - self._pause.resumed < LEAST_SILENCE
        for alarm in list(self._alarms.values()):
            if alarm.shelf_ends is not None and monotonic >= alarm.shelf_ends:
                changed += self._change(alarm, Change.UNSHELVE, now)
            elif alarm.shelf_ends is not None:
                until = now + alarm.shelf_ends - monotonic
                if abs(until - (alarm.shelved_until or 0.0)) > 1.0:  # the time of day was set
                    self._alarms[alarm.name] = alarm._replace(shelved_until=until)
        self._pending = {name: self._pending.get(name, monotonic) for name in found}
        for name, text in found.items():
            known = self._alarms.get(name)
            if known is not None and not known.is_over:
                self._alarms[name] = known._replace(text=text)
            elif _kind(name) in (CONTACT_LOST, SILENT, NO_WORD) and just_resumed:
                continue
            elif monotonic - self._pending[name] >= ON_DELAY.get(_kind(name), 0.0):
                raised = known or Alarm(name, text, now, State.NORMAL)
                changed += self._change(raised._replace(text=text), Change.RAISED, now)
        low = self._alarms.get(LOW)
        if low is not None and low.is_over and EMPTY in found and not self._stands(EMPTY):
            changed += self._change(low, Change.RAISED, now)  # until it is sure that it is empty
        for alarm in list(self._alarms.values()):
            if alarm.name in found or alarm.is_over:
                continue
            if alarm.name == LOW and EMPTY in found:  # one cause, one alarm, and no gap between
                if self._stands(EMPTY):
                    changed += self._change(alarm, Change.REPLACED, now)
                continue
            is_heard = _kind(alarm.name) in _HEARD and alarm.name not in known_over
            if CONTACT_LOST in found and is_heard:
                text = alarm.text.removesuffix(_LAST_KNOWN) + _LAST_KNOWN
                self._alarms[alarm.name] = alarm._replace(text=text)
                continue
            changed += self._change(alarm, Change.CLEARED, now)
        return changed

    def acknowledge(self, alarm: Alarm, now: float) -> list[Alarm]:
        """Somebody has seen it."""
        return self._change(self._alarms.get(alarm.name, alarm), Change.ACKNOWLEDGE, now)

    def shelve(self, alarm: Alarm, monotonic: float, now: float, reason: str = "") -> list[Alarm]:
        """Silence it for SHELF_TIME, or take it off the shelf."""
        known = self._alarms.get(alarm.name, alarm)._replace(reason=reason)
        if known.state == State.SHELVED:
            return self._change(known, Change.UNSHELVE, now)
        ends, until = monotonic + SHELF_TIME, now + SHELF_TIME
        shelved = known._replace(shelf_ends=ends, shelved_until=until)
        return self._change(shelved, Change.SHELVE, now)

    def all(self) -> tuple[Alarm, ...]:
        """Unacknowledged first, then active, then by priority; shelved last."""
        return tuple(sorted(self._alarms.values(), key=lambda alarm: alarm.rank))

    def _stands(self, name: str) -> bool:
        return name in self._alarms and not self._alarms[name].is_over

    def _change(self, alarm: Alarm, change: Change, now: float) -> list[Alarm]:
        state = TRANSITIONS.get((alarm.state, change), alarm.state)
        new = alarm._replace(state=state)
        if change in (Change.CLEARED, Change.REPLACED):
            new = new._replace(until=now)
        elif change == Change.RAISED:
            since = alarm.since if alarm.state == State.SHELVED else now
            new = new._replace(since=since, until=None)
        if state != State.SHELVED:
            new = new._replace(shelf_ends=None, shelved_until=None)
        if state in (State.NORMAL, State.REPLACED):
            self._alarms.pop(alarm.name, None)
        else:
            self._alarms[alarm.name] = new
        return [new] if state != alarm.state else []


class Ringer:
    """Says of which alarms somebody is to be told: grave ones, once each time that they come."""

    def __init__(self) -> None:
        self._told: set[tuple[str, float]] = set()  # name, and since when

    def news(self, alarms: Iterable[Alarm]) -> list[Alarm]:
        """Those of all the alarms that are new and grave."""
        standing = {(alarm.name, alarm.since): alarm for alarm in alarms}
        self._told &= standing.keys()
        found = {
            which: alarm
            for which, alarm in standing.items()
            if alarm.priority == Priority.HIGH
            and alarm.state == State.UNACKNOWLEDGED
            and which not in self._told
        }
        self._told |= found.keys()
        return list(found.values())
