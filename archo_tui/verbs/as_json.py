"""The state of the robot as JSON has it, each reading with its age."""

from __future__ import annotations

import math
from typing import Any

from archo_tui.robot.state.audit_records import json_safe
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.station.conditions import Priority
from archo_tui.station.station import Station
from archo_tui.text.goal import remaining_text, running_word
from archo_tui.text.line_by_line import spans_to_text
from archo_tui.text.state import battery_word, motion_word


def state(station: Station) -> dict[str, Any]:
    """Return all that `status --json` prints: battery, motion, pose, goal, queue, alarms, STOP.

    None means not received, or not reported; ages are in seconds. The alarms are those of the last
    refresh of the station.
    """
    snapshot, now = station.robot.snapshot, station.clock.monotonic()
    battery, motion = snapshot.battery, snapshot.motion
    return {
        "robot": snapshot.file.name,
        "namespace": snapshot.namespace,
        "watching": station.robot.watching,
        "battery": {
            "percentage": _number(battery.percentage),  # In %.
            "voltage": _number(battery.voltage),  # In V.
            "charging": battery.charging,
            "word": battery_word(snapshot)[1],
            **_measured(battery.received, now),
        },
        "motion": {
            "moving": motion.moving,
            "stopped": _stopped(snapshot),
            "speed": _number(motion.speed),
            "time_factor": snapshot.time_factor,  # None for real seconds.
            "word": _motion_word(snapshot, now, 80),
            **_measured(motion.received, now),
        },
        "pose": _pose(snapshot, now),
        "goal": None if snapshot.goal is None else goal(snapshot.goal, now),
        "queue": {
            "waiting": [wanted.text for wanted in station.queue.waiting],
            "held": station.queue.hold_reason,
        },
        "alarms": [
            {
                "name": alarm.name,
                "text": alarm.text,
                "priority": alarm.priority.name,
                "state": alarm.state.value,
                "since": alarm.since,  # Unix time, in s.
            }
            for alarm in station.view.alarms
        ],
        "stop": _stop_state(snapshot),
        "line": in_line(station),
    }


def _stopped(snapshot: Snapshot) -> bool | None:
    """Return True if a confirmed STOP holds, else the robot's own report.

    None without one, or if that is in doubt.
    """
    if snapshot.latch is Latch.UNCERTAIN or snapshot.runs_on:
        return None
    return True if snapshot.stop_holds else snapshot.motion.stopped


def _pose(snapshot: Snapshot, now: float) -> dict[str, Any] | None:
    pose = snapshot.pose
    if snapshot.file.pose is None:
        return None
    return {
        "x": pose.x,  # In m.
        "y": pose.y,
        "yaw": pose.yaw,  # In degrees.
        "frame": pose.frame,
        **_measured(pose.received, now),
    }


def _stop_state(snapshot: Snapshot) -> str:
    """Return `open` for an unconfirmed STOP, `uncertain` if it may have ended, "" otherwise."""
    if snapshot.open_stop is not None:
        return "open"
    return "uncertain" if snapshot.latch is Latch.UNCERTAIN else ""


def in_line(station: Station) -> str:
    """Return the state in one line, such as `ARCHO 87 % MOVING to 12, 9.0 m left`.

    A held queue, and the HIGH alarms whose cause is not over, follow. The charge is `--` if it is
    unknown or old.
    """
    snapshot, now = station.robot.snapshot, station.clock.monotonic()
    charge, goal = snapshot.battery.percentage, snapshot.running_goal
    parts = [snapshot.file.name]
    if snapshot.file.battery is not None:
        old = charge is None or snapshot.battery.is_old(now)
        parts.append("-- %" if old else f"{charge:.0f} %")
    if goal is not None and not snapshot.is_stopped:
        left = remaining_text(goal)
        parts.append(f"{running_word(goal)}, {left}" if left else running_word(goal))
    else:
        parts.append(_motion_word(snapshot, now, 40))
    if station.queue.hold_reason:
        parts.append(f"held: {', '.join(wanted.text for wanted in station.queue.waiting)}")
    high = (alarm for alarm in station.view.alarms if alarm.priority == Priority.HIGH)
    grave = ", ".join(alarm.name for alarm in high if not alarm.is_over)
    if grave:
        parts.append(f"alarm: {grave}")
    return " ".join(parts)


def _motion_word(snapshot: Snapshot, now: float, width: int) -> str:
    return spans_to_text(motion_word(snapshot, now, width))


def goal(found: Goal, now: float) -> dict[str, Any]:
    """Return a goal as JSON has it: kind, values, phase, code, way left, age and so on.

    `values` is empty for another client's goal. `now` is monotonic; the age counts from the last
    feedback or answer.
    """
    return {
        "kind": found.kind.id,
        "values": json_safe(found.fields),
        "name": found.name,
        "phase": found.phase.value,
        "code": None if found.code is None else found.code.value,
        "mine": found.mine,
        "remaining": _number(found.remaining),
        "length": _number(found.length),
        "message": found.message,
        "age": _age(found.heard, now),
        "source": "commanded" if found.mine else "measured",
    }


def event(found: Event) -> dict[str, Any]:
    """Return an event as JSON has it, with its command and audit record if it has them."""
    told: dict[str, Any] = {
        "time": found.time,
        "level": found.level,
        "source": found.source,
        "text": found.text,
        "count": found.count,
    }
    if found.command:
        told["command"] = found.command
    if found.audit_record is not None:
        told |= found.audit_record.json_safe()._asdict()
    return told


def parameter(found: Parameter) -> dict[str, Any]:
    """Return a parameter as JSON has it; long values are cut, secret ones are not masked."""
    values = json_safe({"value": found.value, "initial": found.initial})
    return {
        "node": found.node,
        "name": found.name,
        "type": found.type,
        **values,
        "low": found.low,
        "high": found.high,
        "read_only": found.read_only,
    }


def _measured(received: float | None, now: float) -> dict[str, Any]:
    return {"age": _age(received, now), "source": "measured"}  # In s.


def _age(received: float | None, now: float) -> float | None:
    return None if received is None else round(max(now - received, 0.0), 3)


def _number(value: float | None) -> float | None:
    return value if value is None or math.isfinite(value) else None
