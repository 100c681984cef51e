"""The lines that `--plain` prints: news of the robot, outcomes, and failures."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from archo_tui.clock import time_of_day
from archo_tui.plain.news import is_event_news, is_goal_news
from archo_tui.plain.output import Output
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.safe_text import safe
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.station.approvals import LIFETIME
from archo_tui.terminal.ascii import ascii_only, in_ascii
from archo_tui.verbs.status import Status
from archo_tui.words import line_by_line
from archo_tui.words.event import event_text

if TYPE_CHECKING:
    from archo_tui.station.station import Station


class Printer:
    """The printer of events, goals, alarms and requests, each change once; it never waits."""

    def __init__(
        self, station: Station, output: Output, status: Status, is_ending: Callable[[], bool]
    ) -> None:
        self._station, self._output, self._status = station, output, status
        self._clock, self._is_ending = station.clock, is_ending
        self._ascii = ascii_only()
        self._printed_events: set[int] = set()  # Numbers of events in the last snapshot.
        self.goal: Goal | None = None
        self.has_failed = False  # The exit code is 1 then.
        self.requests_shown_at: dict[int, float] = {}  # Monotonic s, by number.

    def print_news(self, snapshot: Snapshot) -> None:
        """Print the events and the goal's state that are news; set `goal` and `has_failed`."""
        for event in snapshot.events:
            if event.number not in self._printed_events and is_event_news(
                event, snapshot.goal, self._station.view.hosted, is_ending=self._is_ending()
            ):
                self.print_timed(event_text(event), event.time)
        self._printed_events = {event.number for event in snapshot.events}
        self._print_goal(snapshot)

    def _print_goal(self, snapshot: Snapshot) -> None:
        goal, before = snapshot.goal, self.goal
        self.goal = goal
        if any(ended.mine and ended.phase != Phase.ARRIVED for ended in snapshot.history):
            self.has_failed = True
        if goal is None:
            return
        if before is not None and before.number != goal.number:
            before = None
        if is_goal_news(before, goal):
            now = self._clock.monotonic()
            self.print_timed(f"goal {line_by_line.goal_text(snapshot, now, self._status.ask)}")

    def print_alarms(self, changed: list[Alarm]) -> None:
        """Print the new state of each alarm, with the text and a remedy of a raised one."""
        for alarm in changed:
            is_new = alarm.state == AlarmState.UNACKNOWLEDGED
            snapshot = self._station.robot.snapshot
            text = self._status.advice(alarm, snapshot) if is_new else alarm.name
            self.print_timed(f"alarm {alarm.state.value}: {text}")

    def print_requests(self) -> None:
        """Print each new request of an assistant, and what to type to answer it."""
        for request in self._station.view.requests:
            if request.number not in self.requests_shown_at:
                self.requests_shown_at[request.number] = self._clock.monotonic()
                ways = f"allow {request.number} or deny {request.number}, within {LIFETIME:g} s"
                self.print_timed(f"{request.requester.source} wants: {request.text} ({ways})")

    def print_failure(self, text: str) -> None:
        self.print_timed(f"failed: {text}")
        self.has_failed = True

    def print_timed(self, text: str, at: float | None = None) -> None:
        """Print a text behind a time of day; `at` is Unix time in seconds, None for now."""
        self.print_text(f"{time_of_day(self._clock.now() if at is None else at)} {text}")

    def print_text(self, text: str) -> None:
        """Print lines, with a mark in place of each control character.

        On a terminal that takes only ASCII, other characters are replaced.
        """
        lines = [safe(line) for line in text.splitlines()]
        self._output.put(
            "".join(f"{in_ascii(line) if self._ascii else line}\n" for line in lines).encode()
        )
