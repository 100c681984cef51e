"""The verb `wait`, and the conditions that it waits for."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Sequence

from archo_tui.robot.messages.typed import parse_number
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.conditions import BATTERY_EMPTY, CONTACT_LOST
from archo_tui.station.station import Station
from archo_tui.text.goal import remaining_text
from archo_tui.text.state import no_data_text
from archo_tui.verbs.goals import Go
from archo_tui.verbs.verb import DISCOVERY_TIME, TIMEOUT, Argument, Forms, Values, Verb

POLL_PERIOD = 0.05  # Seconds between two checks.
SENT = "sent"  # The key of the ends of the goals that the requester has sent.
_STATES, _WITH_NUMBER = ("idle", "arrived", "ready", "stopped"), ("left", "battery")
_WAITS = "idle, arrived, ready, stopped, left N or battery N"
Check = Callable[[], Outcome | None]  # Returns None while the condition does not hold yet.


async def wait_until(station: Station, check: Check, timeout: float | None) -> Outcome:
    """Return the outcome of a condition, or RAN_OUT, by which nothing is cancelled."""
    clock = station.clock
    end = None if timeout is None else clock.monotonic() + timeout
    while (outcome := check()) is None:
        if end is not None and clock.monotonic() >= end:
            drives = station.running_goal is not None
            return Outcome(Code.RAN_OUT, "the robot still drives" if drives else "not yet")
        await clock.sleep(POLL_PERIOD)
    return outcome


def outcome_if_over(ends: Sequence[asyncio.Future[Outcome]]) -> Outcome | None:
    """Return the outcome of the first goal that did not arrive, else of the last one.

    None while one of them still runs.
    """
    if not all(end.done() for end in ends):
        return None
    outcomes = [end.result() for end in ends]
    return next((each for each in outcomes if each.code != Code.ARRIVED), outcomes[-1])


class Wait(Verb):
    """The verb `wait`: the outcome is DONE, or REFUSED for what can never hold."""

    id, title = "wait", "Wait"
    help = f"Wait for a state of the robot: {_WAITS}"
    arguments = (
        Argument("state", completer=lambda *_: (*_STATES, *_WITH_NUMBER)),
        Argument("n", optional=True),
    )
    is_slow = True
    timeout_help = "give up after S seconds with exit code 4"

    def __init__(self, robot: RobotFile, go: Go | None) -> None:
        self._robot, self._go = robot, go

    @classmethod
    def of_robot(cls, robot: RobotFile, forms: Forms) -> Iterator[Verb]:
        yield cls(robot, next(Go.of_robot(robot, forms), None))

    def values(self, words: Sequence[str]) -> Values:
        """Return the `state` and its `number`."""
        if len(words) == 1 and words[0] in _STATES:
            return {"state": words[0]}
        if len(words) != 2 or words[0] not in _WITH_NUMBER:
            raise ValueError(f"needs {_WAITS}")
        state, text = words
        try:
            number = parse_number(text)
        except ValueError:
            unit = " of percent" if state == "battery" else ""
            raise ValueError(f"{state}: not a number{unit}: {text}") from None
        if state == "battery" and not 0 <= number <= 100:
            raise ValueError(f"battery: from 0 to 100 percent, not {text}")
        if state == "battery" and self._robot.battery is None:
            raise ValueError("the robot file names no battery")
        return {"state": state, "number": number}

    async def run(self, station: Station, values: Values) -> Outcome:
        check = self.check(station, values)
        return await wait_until(station, check, values.get(TIMEOUT))

    def check(self, station: Station, values: Values) -> Check:
        """Return the check of a condition, which is about the goal that runs now."""
        running, sent, number = station.running_goal, values.get(SENT), values.get("number", 0.0)
        checks: dict[str, Check] = {
            "idle": lambda: _idle(station),
            "ready": lambda: self._ready(station),
            "stopped": lambda: _stopped(station),
            "battery": lambda: _charged(station, number),
            "left": lambda: _arrived(station, running, number),
            "arrived": lambda: outcome_if_over(sent) if sent else _arrived(station, running),
        }
        return checks[values["state"]]

    def _ready(self, station: Station) -> Outcome | None:
        """Return success once a goal could be sent and driven; a refusal if it never can be."""
        why = self._go.refusal(station) if self._go else "the robot file names no goal"
        if why:
            is_final = station.robot.watching or self._go is None
            return Outcome(Code.REFUSED, why) if is_final else None
        names = {alarm.name for alarm in station.view.alarms if not alarm.is_over}
        is_bad = station.robot.snapshot.is_stopped or names & {CONTACT_LOST, BATTERY_EMPTY}
        return None if is_bad or _is_silent(station) else Outcome(Code.DONE, "ready")


def _idle(station: Station) -> Outcome | None:
    """Return success once no goal runs or is due, and nothing moves; None without data."""
    snapshot = station.robot.snapshot
    busy = snapshot.running_goal is not None or station.queue.is_going or _may_move(station)
    # A goal of a robot that does not report its motion may not be found yet.
    is_new = snapshot.file.motion is None and station.age < DISCOVERY_TIME
    is_known = not (is_new or no_data_text(snapshot))
    return Outcome(Code.DONE, "idle") if is_known and not busy else None


def _stopped(station: Station) -> Outcome | None:
    """Return success while nothing moves and a stop is reported or, without reports, sure."""
    snapshot, described = station.robot.snapshot, station.robot.file.motion
    goal = snapshot.running_goal
    is_blind = snapshot.motion.moving is None
    may_run = goal is not None and goal.kind.stop_cancels and is_blind
    if snapshot.still_running_after_stop or may_run:
        return None
    is_stopped = snapshot.latch is Latch.HELD and snapshot.open_stop is None
    if described is not None and described.reports_stop:
        is_stopped = snapshot.says_stopped
    return Outcome(Code.DONE, "stopped") if is_stopped and not _may_move(station) else None


def _arrived(station: Station, wanted: Goal | None, left: float = -1.0) -> Outcome | None:
    """Return the outcome of the goal that ran when the wait began; a refusal if none did.

    It is a success as soon as no more than `left` of its way is left.
    """
    if wanted is None:
        return Outcome(Code.REFUSED, "no goal is running")
    snapshot = station.robot.snapshot
    known = [goal for goal in (snapshot.goal, *snapshot.history) if goal is not None]
    goal = next((goal for goal in known if goal.number == wanted.number), None)
    if goal is None:
        return Outcome(Code.REFUSED, "the goal is not known")
    outcome = goal.outcome_at(station.clock.monotonic())
    is_near = goal.remaining is not None and goal.remaining <= left
    return Outcome(Code.DONE, remaining_text(goal)) if outcome is None and is_near else outcome


def _charged(station: Station, number: float) -> Outcome | None:
    battery = station.robot.snapshot.battery
    charge, old = battery.percentage, battery.is_old(station.clock.monotonic())
    if charge is None or charge < number or old:  # An old charge says nothing about now.
        return None
    return Outcome(Code.DONE, f"{charge:.1f} %")


def _is_silent(station: Station) -> bool:
    """Return True while reports of the motion, if the robot file names any, are missing or old."""
    motion, described = station.robot.snapshot.motion, station.robot.file.motion
    silent = motion.received is None or motion.is_old(station.clock.monotonic())
    return described is not None and silent


def _may_move(station: Station) -> bool:
    return _is_silent(station) or bool(station.robot.snapshot.motion.moving)
