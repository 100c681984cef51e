"""The recorder of what a console did and showed, and the events that begin a recording."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from datetime import datetime
from functools import partial
from pathlib import Path

from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui import __version__
from archo_tui.clock import LAST_STAMP
from archo_tui.recordings.recorder import BEGUN, BlackBox
from archo_tui.recordings.ring import LazyMessage
from archo_tui.recordings.state import change_key, to_json
from archo_tui.recordings.store import KEPT
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import LEVELS, OWN_LEVELS, Event, Goal, Phase, Snapshot
from archo_tui.robot_file.dump import dump
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.alarms import Alarm, AlarmState, Priority
from archo_tui.station.view import View

JOURNAL, STATE = "/archo_tui/journal", "/archo_tui/state"
_STOP = "STOP"
_EVENT_BYTES, _STATE_BYTES = 1000, 20_000  # That a waiting event or view takes, approximately.
_MAX_STATE_AGE = 10.0  # Seconds after which an unchanged state is recorded again.
_MAX_JOURNAL_BYTES = 1_000_000  # Read from the end of the journal.


class ConsoleRecorder:
    """The recorder of what the console did and showed, which also triggers recordings.

    `record_event` is called on the robot's thread, everything else on the event loop.
    """

    def __init__(self, box: BlackBox) -> None:
        self._box = box
        self._last_view: View | None = None
        self._last_key: tuple[object, ...] = ()
        self._state_time = 0.0  # Monotonic time of the last recorded state, in s.
        self.kept = ""  # The last recording on the disk that the operator asked for.

    @property
    def trouble(self) -> str:
        """A warning that recordings are not written or fill their budget; "" for none."""
        return self._box.trouble

    def record_event(self, event: Event) -> None:
        """Record an event that tells what a console did; the robot's own lines are on `/rosout`."""
        if event.level in OWN_LEVELS or event.source == "console":
            self._box.receive(JOURNAL, Log, LazyMessage(partial(_to_log, event), _EVENT_BYTES))

    def on_view(self, view: View, changed: Sequence[Alarm]) -> None:
        """Record a view of which more than readings changed; tick the black box, or trigger it.

        `changed` are the alarms whose state differs from the last call.
        """
        key = change_key(view)
        if key != self._last_key or view.now - self._state_time > _MAX_STATE_AGE:
            self._last_key, self._state_time = key, view.now
            self._box.receive(STATE, String, LazyMessage(partial(_to_string, view), _STATE_BYTES))
        if self._last_view is not None:
            for why in reasons_to_record(self._last_view, view, changed):
                self._box.trigger(why)
        self._last_view = view
        self._box.tick()

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Record the last minute and the next 5 s by hand; return that it has begun.

        `written` gets the outcome on the event loop when it is on the disk, or could not be
        written.
        """
        loop = None if written is None else asyncio.get_running_loop()

        def on_disk(name: str, failure: str) -> None:
            self.kept = name or self.kept
            outcome = Outcome(Code.DONE, f"recorded {name}")
            if failure:
                outcome = Outcome(Code.REFUSED, f"recording not written: {failure}")
            if loop is not None and written is not None:
                with suppress(RuntimeError):  # The loop is closed if the console has ended.
                    loop.call_soon_threadsafe(written, outcome)

        self._box.trigger(KEPT, by_hand=True, on_written=on_disk)
        return Outcome(Code.DONE, BEGUN)


def _to_log(event: Event, _first: bool, _since: float) -> Log:
    seconds, rest = divmod(int(event.time * 1e9), 10**9)
    return Log(
        stamp=Time(sec=min(seconds, LAST_STAMP), nanosec=rest),
        level=LEVELS.get(event.level, LEVELS["INFO"]),
        name=event.source,
        msg=f"{event.level}: {event.text}" if event.level in OWN_LEVELS else event.text,
        file=event.code,  # How it ended, as the journal says it.
        function=event.command,  # The `ros2` command line with the same effect.
    )


def _to_string(view: View, first: bool, since: float) -> String:
    return String(data=to_json(view, since, with_events=first))


def reasons_to_record(before: View, now: View, changed: Sequence[Alarm]) -> list[str]:
    """Return the reasons to begin or prolong a recording: STOPs, grave alarms, failed goals."""
    return [*_stop_reasons(before, now), *_alarm_reasons(changed), *_goal_reasons(before, now)]


def _stop_reasons(before: View, now: View) -> Iterator[str]:
    old, new = before.snapshot, now.snapshot
    # A stop that the robot reported from the beginning on is not new.
    stops_now = new.motion.stopped and old.motion.received is not None and not old.motion.stopped
    if (
        stops_now
        or (new.open_stop is not None and old.open_stop is None)
        or _has_new_stop_event(old, new)
    ):
        yield _STOP


def _has_new_stop_event(old: Snapshot, new: Snapshot) -> bool:
    """Return True if an event that `old` lacks tells of a STOP, which may be over by now."""
    if new.events is old.events:
        return False
    known = max((event.number for event in old.events), default=0)
    since = (event.audit_record for event in new.events if event.number > known)
    return any(record is not None and record.verb == "stop" for record in since)


def _alarm_reasons(changed: Sequence[Alarm]) -> Iterator[str]:
    for alarm in changed:
        if alarm.priority == Priority.HIGH and alarm.state == AlarmState.UNACKNOWLEDGED:
            yield alarm.name


def _goal_reasons(before: View, now: View) -> Iterator[str]:
    known = max((goal.number for goal in before.snapshot.history), default=0)
    for goal in reversed(now.snapshot.history):
        if goal.number > known and _failed(goal):
            yield f"{goal.name}: {goal.word.lower()}"


def _failed(goal: Goal) -> bool:
    called_off = goal.phase == Phase.CANCELLED and goal.cancel_asked is not None
    return goal.started is not None and goal.phase != Phase.ARRIVED and not called_off


def attachments(robot: RobotFile, journal: Path, begin: float, end: float) -> dict[str, str]:
    """Return the text of each attachment by its name: robot file, journal lines, versions.

    The lines are those between two Unix times; a journal that cannot be read counts as empty.
    """
    return {
        "robot.yaml": dump(robot),
        "journal.jsonl": "".join(_journal_lines(journal, begin, end)),
        "versions.json": json.dumps({"archo-tui": __version__, "python": sys.version.split()[0]}),
    }


def _journal_lines(journal: Path, begin: float, end: float) -> list[str]:
    try:
        with open(journal, "rb") as file:
            file.seek(max(journal.stat().st_size - _MAX_JOURNAL_BYTES, 0))
            text = file.read(_MAX_JOURNAL_BYTES).decode("utf-8", "replace")
    except OSError:
        return []
    return [line for line in text.splitlines(keepends=True) if begin <= _line_time(line) <= end]


def _line_time(line: str) -> float:
    try:
        return datetime.fromisoformat(json.loads(line)["time"]).timestamp()
    except (ValueError, KeyError, TypeError):  # The first line read may lack its beginning.
        return 0.0
