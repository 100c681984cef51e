"""Tells the black box what no topic of the robot says, and when to write."""

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
from archo_tui.recording.ring import Later
from archo_tui.recording.state import parts, state
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import LEVELS, OWN_LEVELS, Event
from archo_tui.station.alarms import Alarm
from archo_tui.station.station import View

JOURNAL, STATE = "/archo_tui/journal", "/archo_tui/state"
_LOG = 1000  # bytes of an event that waits, about
_VIEW = 20_000  # and of a view
_ANEW = 10.0  # s after which a state is kept though it is the same


class Witness:
    """`happened` is called on the robot's thread, all else on the loop."""

    def __init__(self, box: BlackBox) -> None:
        self._box = box
        self._before: View | None = None
        self._parts: tuple[object, ...] = ()
        self._told = 0.0  # monotonic s
        self.kept = ""  # name of the last recording begun by hand that is on the disk

    @property
    def trouble(self) -> str:
        """What an operator is to know, or an empty string."""
        return self._box.trouble

    def happened(self, event: Event) -> None:
        """What this console and others did and were answered."""
        if event.level in OWN_LEVELS or event.source == "console":
            self._box.hear(JOURNAL, Later(partial(_log, event), _LOG))

    def look(self, view: View, changed: Sequence[Alarm]) -> None:
        """Keep what has changed, begin to record when something happened, end when it is over."""
        now = parts(view)
        if now != self._parts or view.now - self._told > _ANEW:
            self._parts, self._told = now, view.now
            self._box.hear(STATE, Later(partial(_state, view), _VIEW))
        if self._before is not None:
            for why in triggers.happened(self._before, view, changed):
                self._box.trigger(why)
        self._before = view
        self._box.look()

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Begin to record the last minute, and what follows; `written` as in `Recorder`."""
        loop = None if written is None else asyncio.get_running_loop()

        def on_disk(name: str, failure: str) -> None:
            self.kept = name or self.kept
            said = Outcome(Code.DONE, f"recorded {name}")
            if failure:
                said = Outcome(Code.REFUSED, f"recording not written: {failure}")
            if loop is not None and written is not None:
                with suppress(RuntimeError):  # the console has ended, and its loop is closed
                    loop.call_soon_threadsafe(written, said)

        self._box.trigger(KEPT, by_hand=True, written=on_disk)
        return Outcome(Code.DONE, BEGUN)


def _log(event: Event, _first: bool) -> Log:
    seconds, rest = divmod(int(event.time * 1e9), 10**9)
    return Log(
        stamp=Time(sec=min(seconds, LAST_STAMP), nanosec=rest),
        level=LEVELS.get(event.level, LEVELS["INFO"]),
        name=event.source,
        msg=f"{event.level}: {event.text}" if event.level in OWN_LEVELS else event.text,
        function=event.command,  # the ros2 command line that does the same
    )


def _state(view: View, first: bool) -> Any:
    said = to_data(state(view, whole=first))
    return String(data=json.dumps(said, ensure_ascii=False, separators=(",", ":")))
