"""The alarms' conditions: which of them hold in a snapshot. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from archo_tui.clock import time_of_day
from archo_tui.robot.state import (
    WORST_FIRST,
    Diagnostic,
    DiagnosticLevel,
    Hosted,
    Latch,
    Life,
    OpenStop,
    Phase,
    Snapshot,
    StopAnswer,
    not_offered,
)
from archo_tui.station.alarms import (
    BATTERY_EMPTY,
    BATTERY_HEALTH,
    CLOCKS_DIFFER,
    CONTACT_LOST,
    DIAGNOSTIC_ERROR,
    DIAGNOSTIC_WARNING,
    DUPLICATE_NAME,
    EARLIER_STOP,
    GAUGE_WARNING,
    GOAL_SILENT,
    JOURNAL_NOT_WRITTEN,
    LOW_BATTERY,
    MOTOR_SILENT,
    MOVES_AFTER_STOP,
    NO_CLOCK,
    NO_NODES,
    NODE_CRASHED,
    RECORDING_TROUBLE,
    SEVERAL_PUBLISHERS,
    SEVERAL_STOP_SERVERS,
    STOP_UNCERTAIN,
    STOP_UNCONFIRMED,
    STOPPED,
)

_Conditions = Iterator[tuple[str, str]]  # The name of an alarm whose condition holds, and its text.


_ANSWER_TIME = 1.0  # Seconds that a STOP may take before it is an alarm.


def conditions(
    snapshot: Snapshot,
    now: float,
    hosted: Iterable[Hosted] = (),
    journal_failure: str = "",
    recorder_trouble: str = "",
    unseen: str = "",
    earlier_stop: float | None = None,
) -> dict[str, str]:
    """Return the alarms whose conditions hold, each with its text.

    While contact with the robot is lost, nothing is concluded from its last messages about battery,
    motion, goal and gauges: only CONTACT_LOST stands for them. Diagnostics that are still received
    have their alarms.

    Args:
        snapshot: The state of the robot.
        now: Monotonic time in seconds.
        hosted: The nodes that this process runs.
        journal_failure: The reason why the journal cannot be written; "" if it can.
        recorder_trouble: The failure of recordings that the operator has to know; "" for none.
        unseen: The rest of the text of the alarm `NO NODES`; "" to raise no such alarm.
        earlier_stop: Unix time of a STOP from before the start of this console that the journal has
            no release of; None if there is none.

    Returns:
        The texts by alarm name, see `Alarm.name`.
    """
    hosted = tuple(hosted)
    found = {
        **dict(_stop_conditions(snapshot, now, earlier_stop)),
        **dict(_console_conditions(journal_failure, recorder_trouble)),
        **dict(_graph_conditions(snapshot, now, hosted, unseen)),
    }
    if _is_contact_lost(snapshot, now):
        last = max(snapshot.battery.received or 0.0, snapshot.motion.received or 0.0)
        found[CONTACT_LOST] = f"CONTACT LOST for {now - last:.0f} s: the robot may still be moving"
        # What is still heard may tell why the rest is silent.
        heard = tuple(status for status in snapshot.diagnostics if not status.is_silent_at(now))
        return {**found, **dict(_diagnostic_conditions(snapshot._replace(diagnostics=heard), now))}
    return {
        **found,
        **dict(_battery_conditions(snapshot, now)),
        **dict(_motion_conditions(snapshot, now)),
        **dict(_gauge_conditions(snapshot, now)),
        **dict(_diagnostic_conditions(snapshot, now)),
    }


def _stop_conditions(snapshot: Snapshot, now: float, earlier_stop: float | None) -> _Conditions:
    stop = snapshot.open_stop
    if stop is not None and (stop.answer != StopAnswer.AWAITED or now - stop.asked >= _ANSWER_TIME):
        text = open_stop_texts(snapshot, stop, now)[0]
        yield STOP_UNCONFIRMED, f"{text}: use the hardware stop"
    if snapshot.latch is Latch.UNCERTAIN:
        remedy = f"{snapshot.latch_doubt}: stop again, or release it"
        if snapshot.stop_held_by_nobody:
            remedy = "every node that held it has ended here: release it"
        at = time_of_day(snapshot.latch_time)[:-3]
        yield STOP_UNCERTAIN, f"STOP OF {at} IS NO LONGER CERTAIN: {remedy}"
    served = snapshot.file.stop
    if served is not None and served.service in snapshot.duplicate_servers:
        nodes = snapshot.duplicate_servers[served.service]
        yield (
            SEVERAL_STOP_SERVERS,
            f"{len(nodes)} NODES SERVE {served.service}: {', '.join(nodes)}: STOP must be "
            "confirmed by all of them; keep the hardware stop at hand",
        )
    motion = snapshot.motion
    is_known = snapshot.released is not None or snapshot.is_stopped
    if earlier_stop is not None and not (is_known or motion.stopped is not None or motion.moving):
        yield (
            EARLIER_STOP,
            f"STOP OF {time_of_day(earlier_stop)[:-3]} HAS NO RELEASE IN THE JOURNAL: "
            "the robot may still be stopped",
        )
    if snapshot.still_running_after_stop:
        runs = "RUNS" if len(snapshot.still_running_after_stop) == 1 else "RUN"
        yield (
            MOVES_AFTER_STOP,
            f"STOP WAS ANSWERED, BUT {', '.join(snapshot.still_running_after_stop)} STILL {runs}: "
            "use the hardware stop",
        )
    elif _moves_after_stop(snapshot, now):
        yield MOVES_AFTER_STOP, "THE ROBOT MOVES ALTHOUGH STOP WAS SENT: use the hardware stop"


def _moves_after_stop(snapshot: Snapshot, now: float) -> bool:
    """Return True if the robot moves in spite of a STOP, by a motion message that is not old.

    For an open STOP that was sent, the message must report motion, and have come 1 s or more after
    the STOP was asked for. Otherwise True means that the robot has not obeyed a confirmed STOP.
    """
    stop, motion = snapshot.open_stop, snapshot.motion
    if motion.received is None or motion.is_old(now):
        return False
    if stop is None or stop.answer == StopAnswer.NOT_SENT:
        return snapshot.stop_not_obeyed
    return bool(motion.moving) and motion.received - stop.asked >= _ANSWER_TIME


def _console_conditions(journal_failure: str, recorder_trouble: str) -> _Conditions:
    if journal_failure:
        yield JOURNAL_NOT_WRITTEN, f"JOURNAL NOT WRITTEN: {journal_failure}"
    if recorder_trouble:
        yield RECORDING_TROUBLE, recorder_trouble


def _graph_conditions(
    snapshot: Snapshot, now: float, hosted: tuple[Hosted, ...], unseen: str
) -> _Conditions:
    has_nodes = bool(
        _has_reported(snapshot) or hosted or snapshot.nodes or snapshot.other_namespaces
    )
    if unseen and not has_nodes:
        yield NO_NODES, f"NO NODES {unseen}"
    waiting, still = snapshot.simulated_nodes, snapshot.clock_still_since
    if waiting and not snapshot.has_clock:
        yield (
            NO_CLOCK,
            f"NO CLOCK for {', '.join(waiting)}: use_sim_time is true and nobody publishes /clock: "
            "start the simulator, or set it to false",
        )
    elif waiting and still is not None:
        yield (
            NO_CLOCK,
            f"CLOCK STANDS STILL for {now - still:.0f} s, which {', '.join(waiting)} goes by: "
            "resume the simulator",
        )
    if snapshot.clock_offsets:
        worst = sorted(snapshot.clock_offsets.items(), key=lambda item: -abs(item[1]))
        sources = ", ".join(_offset_text(*item) for item in worst[:_MOST_OFFSETS])
        more = ", ..." if len(worst) > _MOST_OFFSETS else ""
        yield CLOCKS_DIFFER, f"CLOCKS DIFFER: {sources}{more}: set one of them (chrony or ntp)"
    for node in hosted:
        if node.life == Life.CRASHED:
            yield (
                f"{NODE_CRASHED} {node.name}",
                f"NODE CRASHED {node.name}: see why in Nodes, then start it again",
            )
    for topic, names in snapshot.publishers.items():
        yield (
            f"{SEVERAL_PUBLISHERS} /{topic}",
            f"{len(names)} PUBLISHERS of {topic}: {', '.join(names)}: their readings come mixed",
        )
    for name in snapshot.duplicate_nodes:
        yield f"{DUPLICATE_NAME} {name}", f"TWO NODES NAMED {name}: a call reaches both of them"


_MOST_OFFSETS = 3  # Sources that are named.


def _offset_text(source: str, offset: float) -> str:
    """Return `/base is 3.2 s behind`, for a clock compared with that of this computer."""
    return f"{source} is {abs(offset):.1f} s {'ahead' if offset > 0 else 'behind'}"


def _has_reported(snapshot: Snapshot) -> bool:
    """Return True if a message about battery or motion was received since the start."""
    return snapshot.battery.received is not None or snapshot.motion.received is not None


def _is_contact_lost(snapshot: Snapshot, now: float) -> bool:
    """Return True if battery and motion are silent, as far as the robot has reported them before.

    Without any report since the start there is no contact to lose.
    """
    battery, motion = snapshot.battery, snapshot.motion
    return (
        _has_reported(snapshot)
        and (battery.received is None or battery.is_old(now))
        and (motion.received is None or motion.is_old(now))
    )


def _battery_conditions(snapshot: Snapshot, now: float) -> _Conditions:
    battery = snapshot.battery
    if battery.is_old(now):
        return
    if battery.percentage is not None:
        if battery.percentage <= 0.0:
            described = snapshot.file.battery
            refuses = described is not None and described.empty_refuses_moves
            more = "the robot refuses moves, charge it where it stands" if refuses else "charge it"
            yield BATTERY_EMPTY, f"BATTERY EMPTY: {more}"
        elif is_battery_low(snapshot) and not battery.charging:
            is_moving = snapshot.running_goal is not None
            dock = "dock the robot when this move is done" if is_moving else "dock the robot"
            yield LOW_BATTERY, f"LOW BATTERY {battery.percentage:.1f} %: {dock}"
    if battery.health:
        meaning = battery_health(snapshot)
        if not meaning:
            yield (
                BATTERY_HEALTH,
                f"BATTERY HEALTH {battery.health}: the console does not know this word",
            )
        elif meaning == "replace":
            yield BATTERY_HEALTH, f"BATTERY HEALTH {battery.health}: have the battery replaced"


def _motion_conditions(snapshot: Snapshot, now: float) -> _Conditions:
    motion, goal = snapshot.motion, snapshot.running_goal
    is_moving = goal is not None or motion.moving
    if motion.received is not None and motion.is_old(now) and is_moving:
        topic = snapshot.file.motion.topic if snapshot.file.motion else "motion"
        yield (
            MOTOR_SILENT,
            f"{topic} silent for {now - motion.received:.0f} s while moving: "
            "the robot may still be driving",
        )
    elif goal is not None and goal.phase == Phase.LOST:
        yield (
            GOAL_SILENT,
            f"NO WORD FROM {goal.kind.title.upper()} for {now - (goal.heard or goal.sent):.0f} s: "
            "the robot may still be driving",
        )
    if snapshot.is_at_rest:
        yield STOPPED, "STOPPED: look for the cause"


def _gauge_conditions(snapshot: Snapshot, now: float) -> _Conditions:
    """Yield an alarm for each gauge whose reading is beyond a limit and not old."""
    for reading in snapshot.gauges:
        if reading.warning and not reading.is_old(now):
            title, unit = reading.gauge.title, reading.gauge.unit
            value = f"{title.upper()} {reading.value:g} {unit}".rstrip()
            yield f"{GAUGE_WARNING} {title}", f"{value}: {reading.warning}"


_OTHERS = "others"  # Of the alarm for the parts that have none of their own.
_MOST_DIAGNOSTICS = 20  # Parts with an alarm of their own; more would hide all other alarms.


def diagnostics_worst_first(snapshot: Snapshot, now: float) -> list[Diagnostic]:
    """Return the last status of each part with its level now, the worst first, then by name.

    The order is ERROR, WARN, STALE, OK.
    """
    found = [status._replace(level=status.level_at(now)) for status in snapshot.diagnostics]
    return sorted(found, key=lambda status: (WORST_FIRST.index(status.level), status.key))


def _diagnostic_conditions(snapshot: Snapshot, now: float) -> _Conditions:
    """Yield an alarm for each part that is not OK, the worst first.

    If all parts are silent, and several are not OK, they have one alarm together; the parts beyond
    the worst 20 have one, too.
    """
    bad = [s for s in diagnostics_worst_first(snapshot, now) if s.level is not DiagnosticLevel.OK]
    is_silent = all(status.is_silent_at(now) for status in snapshot.diagnostics)
    if len(bad) > 1 and is_silent:
        last = max(status.received for status in bad)
        topic = snapshot.file.diagnostics
        text = f"DIAGNOSTICS STALE: nothing on {topic} for {now - last:.0f} s"
        yield f"{DIAGNOSTIC_WARNING} {topic}", text
        return
    for status in bad[:_MOST_DIAGNOSTICS]:
        is_error = status.level is DiagnosticLevel.ERROR
        silent = f"no status for {now - status.received:.0f} s"
        text = silent if status.is_silent_at(now) else status.message
        yield (
            f"{DIAGNOSTIC_ERROR if is_error else DIAGNOSTIC_WARNING} {_part_name(status.part)}",
            f"{status.level.value} {status.part}: {text or 'no message'}",
        )
    if len(bad) > _MOST_DIAGNOSTICS:
        more = len(bad) - _MOST_DIAGNOSTICS
        yield f"{DIAGNOSTIC_WARNING} {_OTHERS}", f"{more} MORE PARTS ARE NOT OK: see diagnostics"


def _part_name(part: str) -> str:
    """Return a part as its alarm's name has it.

    It is in quotes if the alarm would read like that of another part, or of all parts, without.
    """
    error = DIAGNOSTIC_ERROR.removeprefix(DIAGNOSTIC_WARNING).strip()
    misleads = part.startswith((f"{error} ", "/")) or part == _OTHERS
    return f'"{part}"' if misleads else part


def open_stop_texts(snapshot: Snapshot, stop: OpenStop, now: float) -> tuple[str, ...]:
    """Return the state of a STOP that the robot has not confirmed, in words.

    Args:
        snapshot: The state of the robot.
        stop: The STOP.
        now: Monotonic time in seconds.

    Returns:
        The full text, then shorter ones for narrower places, if there are any.
    """
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


def is_battery_low(snapshot: Snapshot) -> bool:
    """Return True if the battery is low by the health it reports, or by its percentage.

    An empty one is low. A percentage below the threshold counts even if the robot calls the battery
    good. Old values count as well; False if nothing is known.
    """
    charge, threshold = snapshot.battery.percentage, snapshot.low_charge
    is_below = charge is not None and (charge <= 0.0 or charge < (threshold or 0.0))
    return is_below or battery_health(snapshot) == "low"


def battery_health(snapshot: Snapshot) -> str:
    """Return the meaning of the reported battery health by the robot file.

    Returns:
        `good`, `low` or `replace`; "" if no health was reported, or one that the file does not
        know.
    """
    described = snapshot.file.battery
    return "" if described is None else described.health.get(snapshot.battery.health or "", "")
