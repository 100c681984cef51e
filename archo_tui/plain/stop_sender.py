"""The sender of the STOPs that are typed into `--plain`.

It is a task of its own, beside the lines: a STOP waits for no other command, nor for the answer to
another STOP.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING

from archo_tui.plain.conditions import Conditions
from archo_tui.plain.input import Input
from archo_tui.robot.stop.gate import RateLimit
from archo_tui.verbs.base import Verb

if TYPE_CHECKING:
    from archo_tui.station.station import Station


class StopSender:
    """The sender of typed STOPs: one STOP to the robot for all that were read and not sent yet."""

    def __init__(
        self,
        station: Station,
        verb: Verb,
        typed: Input,
        conditions: Conditions,
        start: Callable[[Coroutine[None, None, None]], None],
        on_failure: Callable[[str], None],
    ) -> None:
        self._station, self._stops = station, station.robot.stops
        self._verb, self._typed, self._conditions = verb, typed, conditions
        self._start, self._on_failure = start, on_failure
        # Numbers by `Stops.count`; each STOP sent covers all that were read before it.
        self._sent_up_to = self._confirmed_up_to = 0

    async def run(self) -> None:
        """Send the typed STOPs as they are read, until the task is cancelled.

        At most two a second are sent, unless something else was requested since the last one.
        """
        unsent = self._typed.unanswered
        limit = RateLimit()
        while True:
            await self._conditions.wait(lambda: unsent and unsent[-1] > self._sent_up_to)
            delay = limit.delay(self._station.clock.monotonic())
            if delay > 0:
                # The STOPs before have stopped the robot, unless something was requested since.
                await self._conditions.wait_at_most(lambda: self._stops.superseded, delay)
            limit.record(self._station.clock.monotonic())
            self._sent_up_to = self._stops.count
            # A task, since the next STOP does not wait for this one's answer.
            self._start(self._send(self._sent_up_to))

    async def _send(self, number: int) -> None:
        """Send one STOP for all up to `number`, wait for the answer, and mark them as answered.

        They are marked also without a confirmation; `on_failure` is called then, unless the robot
        has confirmed a later one.
        """
        unanswered = self._typed.unanswered
        outcome = await self._verb.run(self._station, {})
        while unanswered and unanswered[0] <= number:
            unanswered.popleft()
        if outcome.ok:
            self._confirmed_up_to = max(self._confirmed_up_to, number)
        elif number > self._confirmed_up_to:  # Otherwise a later STOP has stopped the robot.
            self._on_failure(f"stop: {outcome.text}")
        self._conditions.check_again()

    def are_answered(self, up_to: int | None = None) -> bool:
        """Return True if every typed STOP up to a number was answered, or has timed out."""
        unanswered = self._typed.unanswered
        return not unanswered or (up_to is not None and unanswered[0] > up_to)
