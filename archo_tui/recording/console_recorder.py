"""The console's own topics in a recording, and the watch for events that begin one."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui.clock import LAST_STAMP
from archo_tui.recording import triggers
from archo_tui.recording.box import BEGUN, KEPT, BlackBox
from archo_tui.recording.data import to_data
from archo_tui.recording.ring import LazyMessage
from archo_tui.recording.state import change_key, console_state
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import LEVELS, OWN_LEVELS, Event
from archo_tui.station.alarms import Alarm
from archo_tui.station.view import View

JOURNAL, STATE = "/archo_tui/journal", "/archo_tui/state"
_EVENT_WEIGHT = 1000  # Bytes that a waiting event takes, approximately.
_STATE_WEIGHT = 20_000  # The same of a view.
_MAX_STATE_AGE = 10.0  # Seconds after which an unchanged state is recorded again.


class ConsoleRecorder:
    """The recorder of what the console did and showed, which also triggers recordings.

    `record_event` is called on the robot's thread, everything else on the event loop.

    Attributes:
        kept: The name of the last recording on the disk that the operator asked for; "" for none.
    """

    def __init__(self, box: BlackBox) -> None:
        self._box = box
        self._last_view: View | None = None
        self._last_key: tuple[object, ...] = ()
        self._state_time = 0.0  # Monotonic time of the last recorded state, in s.
        self.kept = ""  # The last recording on the disk that the operator asked for.

    @property
    def trouble(self) -> str:
        """Return a warning that recordings are not written or fill their budget; "" for none."""
        return self._box.trouble

    def record_event(self, event: Event) -> None:
        """Record an event that tells what a console did; ignore all others.

        The robot's own log lines are recorded as messages of `/rosout`.
        """
        if event.level in OWN_LEVELS or event.source == "console":
            self._box.receive(JOURNAL, LazyMessage(partial(_to_log, event), _EVENT_WEIGHT))

    def on_view(self, view: View, changed: Sequence[Alarm]) -> None:
        """Record the view if more than readings changed or 10 s have passed; tick the black box.

        A STOP, an alarm of high priority or a failed goal since the last call begins a recording,
        or prolongs the one that goes on. The first call begins none.

        Args:
            view: The station's view of now.
            changed: Alarms whose state differs from the last call.
        """
        now = change_key(view)
        if now != self._last_key or view.now - self._state_time > _MAX_STATE_AGE:
            self._last_key, self._state_time = now, view.now
            self._box.receive(STATE, LazyMessage(partial(_to_string, view), _STATE_WEIGHT))
        if self._last_view is not None:
            for why in triggers.reasons_to_record(self._last_view, view, changed):
                self._box.trigger(why)
        self._last_view = view
        self._box.tick()

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Record the last minute and the next 5 s, because the operator asked for it.

        The outcome that is returned is always DONE: the recording has begun. `kept` names it when
        it is on the disk.

        Args:
            written: Called on the event loop when the recording is on the disk or could not be
                written, with the outcome; not called if the console has ended by then.
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


def _to_string(view: View, first: bool, since: float) -> Any:
    state = to_data(console_state(view, since, with_events=first))
    return String(data=json.dumps(state, ensure_ascii=False, separators=(",", ":")))
