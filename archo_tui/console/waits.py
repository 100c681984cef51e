"""What a client waits for: the conditions of `wait`, and streams of events and of a goal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn

from archo_tui.client.protocol import is_valid_timeout
from archo_tui.robot.clients import Requester
from archo_tui.robot.messages.typed import parse_number
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.snapshot import Latch
from archo_tui.station.conditions import BATTERY_EMPTY, CONTACT_LOST
from archo_tui.station.station import Station
from archo_tui.text.goal import remaining_text
from archo_tui.text.state import no_data_text
from archo_tui.verbs.as_json import event, state
from archo_tui.verbs.as_json import goal as goal_data
from archo_tui.verbs.verb import DISCOVERY_TIME, Verb

WAITS = "idle, arrived, ready, stopped, left N or battery N"
POLL_PERIOD = 0.05  # Seconds between two checks.
_FOLLOW_PERIOD = 0.2  # Seconds between two polls: five a second, as on the screen.
Check = Callable[[], Outcome | None]  # Returns None while the condition does not hold yet.
Send = Callable[[dict[str, Any]], None]


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


def timeout_of(request: Mapping[str, Any]) -> float | None:
    """Return the timeout of a request in seconds; None without one; ValueError if it is no time."""
    timeout = request.get("timeout")
    if timeout is not None and not is_valid_timeout(timeout):
        raise ValueError(f"timeout: not a time in s: {str(timeout)[:40]}")
    return timeout


def condition(station: Station, verbs: Mapping[str, Verb], words: Sequence[str]) -> Check:
    """Return the check for `wait WORDS`, which gives DONE, or REFUSED if it can never hold.

    ValueError if there is no such condition.
    """
    robot = station.robot

    def idle() -> Outcome | None:
        """Return success once no goal runs or is due, and nothing moves; None without data."""
        busy = robot.snapshot.running_goal is not None or station.queue.is_going
        # A goal of a robot that does not report its motion may not be found yet.
        is_new = robot.file.motion is None and station.age < DISCOVERY_TIME
        if is_new or no_data_text(robot.snapshot):
            return None
        return None if busy or _may_move(station) else Outcome(Code.DONE, "idle")

    def ready() -> Outcome | None:
        """Return success once a goal could be sent and driven; a refusal if it never can be."""
        why = verbs["go"].refusal(station) if "go" in verbs else "the robot file names no goal"
        if not why:
            return None if _is_goal_pointless(station) else Outcome(Code.DONE, "ready")
        return Outcome(Code.REFUSED, why) if robot.watching or "go" not in verbs else None

    def stopped() -> Outcome | None:
        done = _is_stopped(station) and not _may_move(station)
        return Outcome(Code.DONE, "stopped") if done else None

    running = robot.snapshot.running_goal

    def arrived() -> Outcome | None:
        """Return the outcome of the goal that ran when the wait began; a refusal if none did."""
        if running is None:
            return Outcome(Code.REFUSED, "no goal is running")
        goal = _newest_state_of(station, running)
        if goal is None:
            return Outcome(Code.REFUSED, "the goal is not known")
        return goal.outcome_at(station.clock.monotonic())

    def left() -> Outcome | None:
        """Return success once a goal that ran has so little of its way left, or its outcome."""
        if (outcome := arrived()) is not None:
            return outcome
        goal = _newest_state_of(station, running) if running is not None else None
        if goal is None or goal.remaining is None or goal.remaining > number:
            return None
        return Outcome(Code.DONE, remaining_text(goal))

    checks = {"idle": idle, "ready": ready, "arrived": arrived, "stopped": stopped}
    if len(words) == 1 and words[0] in checks:
        return checks[words[0]]
    if len(words) == 2 and words[0] in ("left", "battery"):
        try:
            number = parse_number(words[1])
        except ValueError:
            unit = " of percent" if words[0] == "battery" else ""
            raise ValueError(f"{words[0]}: not a number{unit}: {words[1]}") from None
        if words[0] == "left":
            return left
        if not 0 <= number <= 100:
            raise ValueError(f"battery: from 0 to 100 percent, not {words[1]}")
        if robot.file.battery is None:
            raise ValueError("the robot file names no battery")

        def charged() -> Outcome | None:
            battery = robot.snapshot.battery
            charge, old = battery.percentage, battery.is_old(station.clock.monotonic())
            if charge is None or charge < number or old:  # An old charge says nothing about now.
                return None
            return Outcome(Code.DONE, f"{charge:.1f} %")

        return charged
    raise ValueError(f"wait needs {WAITS}")


def _is_silent(station: Station) -> bool:
    """Return True while reports of the motion, if the robot file names any, are missing or old."""
    motion, described = station.robot.snapshot.motion, station.robot.file.motion
    silent = motion.received is None or motion.is_old(station.clock.monotonic())
    return described is not None and silent


def _may_move(station: Station) -> bool:
    return _is_silent(station) or bool(station.robot.snapshot.motion.moving)


def _is_stopped(station: Station) -> bool:
    """Return True while the robot reports a stop or, without such reports, a STOP surely holds."""
    snapshot, described = station.robot.snapshot, station.robot.file.motion
    if described is not None and described.reports_stop:
        return snapshot.says_stopped
    return snapshot.latch is Latch.HELD and snapshot.open_stop is None


def _is_goal_pointless(station: Station) -> bool:
    """Return True while the robot is stopped, its battery is empty, or its reports are missing."""
    names = {alarm.name for alarm in station.view.alarms if not alarm.is_over}
    is_bad = station.robot.snapshot.is_stopped or not names.isdisjoint(
        (CONTACT_LOST, BATTERY_EMPTY)
    )
    return is_bad or _is_silent(station)


def _newest_state_of(station: Station, wanted: Goal) -> Goal | None:
    snapshot = station.robot.snapshot
    known = (goal for goal in (snapshot.goal, *snapshot.history) if goal is not None)
    return next((goal for goal in known if goal.number == wanted.number), None)


async def follow_events(station: Station, send: Send) -> NoReturn:
    """Send each event from now on, and the state when its line changes, until cancelled.

    An event that repeats is sent again.
    """
    seen = {event.number: event.count for event in station.robot.snapshot.events}
    line = ""
    while True:
        events = station.robot.snapshot.events
        for new in events:
            if seen.get(new.number) != new.count:
                send({"event": event(new)})
        seen = {event.number: event.count for event in events}
        current = state(station)
        if current["line"] != line:
            line = current["line"]
            send({"state": current})
        await station.clock.sleep(_FOLLOW_PERIOD)


async def follow_goal(station: Station, requester: Requester, send: Send) -> NoReturn:
    """Send the state of a goal of `requester` when it changes, but not its end, until cancelled."""
    last = None
    while True:
        current = station.goals.goal_of(requester)
        if current is not None and current != last:
            last = current
            send({"goal": goal_data(current, station.clock.monotonic())})
        await station.clock.sleep(_FOLLOW_PERIOD)
