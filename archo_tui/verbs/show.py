"""The verbs that show the state, events, the last hour and diagnostics, and record it."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator, Mapping
from typing import Any

from archo_tui.base.clock import time_of_day
from archo_tui.base.errors import ArchoError
from archo_tui.recordings.recorder import BEGUN, SECONDS_AFTER, SPAN
from archo_tui.robot.outcome import WATCHING, Code, Outcome, Report
from archo_tui.robot.state.readings import FORGET_AFTER, Diagnostic
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.alarms import Alarm, advice, remedy_hints
from archo_tui.station.conditions import diagnostics_worst_first
from archo_tui.station.history import SPANS, Quantity, current_values
from archo_tui.station.station import Station
from archo_tui.text.alarm import diagnostic_line, no_diagnostics_text, state_word
from archo_tui.text.event import event_text
from archo_tui.text.line_by_line import (
    battery_text,
    ended_goal_text,
    goal_text,
    motion_text,
    queue_text,
    spans_to_text,
)
from archo_tui.text.state import elsewhere_text, gauge_line, motion_unit, no_data_text, pose_line
from archo_tui.verbs.as_json import event, state
from archo_tui.verbs.as_json import goal as goal_data
from archo_tui.verbs.goals import Go
from archo_tui.verbs.verb import Argument, Forms, Values, Verb

_EVENTS = 20


class Status(Verb):
    id, title, tells, lists = "status", "Status", True, True
    help = "Show the state of the robot"
    own_options = (("--line", "print one line, for a prompt"),)

    @classmethod
    def of_robot(cls, robot: RobotFile, forms: Forms) -> Iterator[Verb]:
        ask = next((go.how for go in Go.of_robot(robot, forms)), "")
        yield cls(ask, robot)

    def __init__(self, ask: str, robot: RobotFile) -> None:
        """Create the verb; `ask` is the hint how to send a goal, shown while there is none."""
        self.ask = ask
        names = ("release", *(command.id for command in robot.commands))
        self._typed = {name: f"type {name}" for name in names}

    def advice(self, alarm: Alarm, snapshot: Snapshot) -> str:
        """Return the text of an alarm, followed by the verb to type if one helps now."""
        return advice(alarm, remedy_hints(snapshot, self._typed))

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        title = snapshot.file.motion.title.lower() if snapshot.file.motion else "motion"
        waiting = queue_text(
            [wanted.text for wanted in station.queue.waiting], station.queue.hold_reason
        )
        elsewhere = elsewhere_text(snapshot) if no_data_text(snapshot) else ""
        lines = [
            *([elsewhere] if elsewhere else []),
            f"battery {battery_text(snapshot, now)}",
            f"{title} {motion_text(snapshot, now)}",
            *filter(None, [spans_to_text(pose_line(snapshot, now))]),
            *(spans_to_text(gauge_line(reading, now)) for reading in snapshot.gauges),
            f"goal {goal_text(snapshot, now, self.ask)}",
            *([f"queue {waiting}"] if waiting else []),
            *(f"alarm {state_word(a)}: {self.advice(a, snapshot)}" for a in station.view.alarms),
        ]
        return Report.of("\n".join(lines), state(station))


class Events(Verb):
    id, title, tells = "events", "Events", True
    help = f"Show the last {_EVENTS} events, or the last N"
    arguments = (Argument("n", optional=True),)
    own_options = (("--follow", "also print new events as they come"),)

    async def run(self, station: Station, values: Values) -> Outcome:
        given = values.get("n", str(_EVENTS))
        if not given.isdecimal() or not int(given):
            return Outcome(Code.MISUSE, f"not a count of events: {given}")
        last = station.robot.snapshot.events[-int(given) :]
        lines = [f"{time_of_day(found.time)} {event_text(found)}" for found in last]
        return Report.of("\n".join(lines) or "no events yet", [*map(event, last)])


class ShowHistory(Verb):
    """The verb `history`: the measured values of the last hour, and the goals that ended."""

    id, title, tells = "history", "History", True
    help = "Show the measured values of the last hour, and the results of the last goals"

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        hour = {quantity: _past(station, quantity) for quantity in _NAMES}
        goals = [{**goal_data(found, now), "time": found.time} for found in snapshot.history]
        lines = [_past_line(_NAMES[quantity], past) for quantity, past in hour.items()]
        lines += map(ended_goal_text, snapshot.history)
        text = "\n".join(filter(None, lines)) or "nothing yet"
        return Report.of(text, {**hour, "goals": goals})


_NAMES: dict[Quantity, str] = {
    "charge": "charge",
    "speed": "speed",
    "left": "way left",
    "x": "x",
    "y": "y",
}


def _past(station: Station, quantity: Quantity) -> dict[str, Any]:
    """Return a quantity's unit, and its finite value or None now and each of SPANS seconds ago."""
    snapshot, now = station.robot.snapshot, station.clock.monotonic()
    found = [(0.0, current_values(snapshot, now)[quantity])]
    for span in SPANS:
        oldest = station.history.ranges(quantity, span, int(span), now)[0]
        found.append((span, None if oldest is None else oldest[1]))
    readings = [
        {"age": age, "value": value if value is None or math.isfinite(value) else None}
        for age, value in found
    ]
    return {"unit": _unit(snapshot, quantity) or None, "readings": readings}


def _past_line(name: str, past: Mapping[str, Any]) -> str:
    """Return a line like `speed (m/s): now 0.80, 1 min ago 0.00`, or "" if no value is known."""
    known = [
        f"{f'{age / 60:.0f} min ago' if age else 'now'} {value:.2f}"
        for age, value in (each.values() for each in past["readings"])
        if value is not None
    ]
    unit = f" ({past['unit']})" if past["unit"] else ""
    return f"{name}{unit}: {', '.join(known)}" if known else ""


def _unit(snapshot: Snapshot, quantity: Quantity) -> str:
    """Return the unit of a quantity, or "" if the robot file names none or the goals several."""
    if quantity == "charge":
        return "%"
    if quantity == "speed":
        return motion_unit(snapshot, "speed") or ""
    if quantity in ("x", "y"):
        return "m"
    units = {kind.remaining.unit for kind in snapshot.file.goals if kind.remaining}
    return units.pop() if len(units) == 1 else ""


class ShowDiagnostics(Verb):
    """The verb `diagnostics`: list what the robot reports of its parts, the worst first."""

    id, title, tells = "diagnostics", "Diagnostics", True
    help = "List the diagnostics: what the robot reports of its parts, the worst first"

    def is_found(self, station: Station, values: Values) -> bool:
        snapshot = station.robot.snapshot
        return bool(snapshot.diagnostics) or not snapshot.file.diagnostics

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        found = diagnostics_worst_first(snapshot, now)
        lines = [diagnostic_line(status, now) for status in found]
        names = "name", "hardware_id", "message"
        data = [
            {name: getattr(status, name) for name in names}
            | {"level": status.level.value, "age": now - status.received}  # In s.
            for status in found
        ]
        return Report.of("\n".join(lines) or no_diagnostics_text(snapshot), data)


class ForgetPart(Verb):
    """The verb `forget`: drop a part that has been silent for FORGET_AFTER seconds."""

    id, title, tells = "forget", "Forget a part", True
    acts = True
    help = f"Forget a part of the diagnostics that has reported nothing for {FORGET_AFTER:g} s"
    arguments = (Argument("part", rest=True),)

    def disabled_reason(self, station: Station) -> str:
        snapshot, now = station.robot.snapshot, station.clock.monotonic()
        if any(status.is_gone_at(now) for status in snapshot.diagnostics):
            return ""
        return f"no part has been silent for {FORGET_AFTER:g} s"

    async def run(self, station: Station, values: Values) -> Outcome:
        return forget(station, _find_part(station, values["part"]))


def forget(station: Station, part: Diagnostic) -> Outcome:
    """Forget a part, unless it reported within FORGET_AFTER or the console only watches."""
    if station.robot.watching:
        return Outcome(Code.WATCHING, WATCHING)
    if not part.is_gone_at(station.clock.monotonic()):
        text = (
            f"{part.part}: only a part that has been silent for {FORGET_AFTER:g} s can be forgotten"
        )
        return Outcome(Code.REFUSED, text)
    station.robot.forget_diagnostic(part)
    return Outcome(Code.DONE, f"{part.part} was forgotten")


def _find_part(station: Station, name: str) -> Diagnostic:
    """Return the only part with a name, with or without its hardware id; raise ArchoError."""
    parts = station.robot.snapshot.diagnostics
    fitting = [status for status in parts if status.part == name]
    fitting = fitting or [status for status in parts if status.name == name]
    if len(fitting) == 1:
        return fitting[0]
    names = ", ".join(status.part for status in fitting or parts)
    if fitting:
        raise ArchoError(f"several parts are called {name!r}: {names}")
    raise ArchoError(f"no part is called {name!r}; there is: {names}")


class Keep(Verb):
    """The verb `keep`: record the last minute and the next seconds, and wait for the disk."""

    id, title, tells = "keep", "Keep the last minute", True
    survives_stop = True  # A STOP is what it may record.
    help = f"Keep the last minute: record the last {SPAN:g} s and the next {SECONDS_AFTER:g} s"
    started_text, is_slow = BEGUN, True

    async def run(self, station: Station, values: Values) -> Outcome:
        written: asyncio.Future[Outcome] = asyncio.get_running_loop().create_future()

        def on_disk(outcome: Outcome) -> None:
            if not written.done():  # Unless the caller has given up.
                written.set_result(outcome)

        begun = station.recorder.keep(on_disk)
        outcome = await written if begun.ok else begun
        data = {"recording": station.recorder.kept}
        return Report.of(outcome.text, data) if outcome.ok else outcome
