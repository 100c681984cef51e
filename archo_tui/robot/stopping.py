"""The sending of STOP, and the STOP that is not confirmed yet. ROS thread only.

The rules, each of which is checked in one method:

1. A STOP waits for nothing but a server of its service: `_find_server`, `_call`.
2. It is confirmed only when all servers have said yes (`stop_answers.py`), or the robot reports
   that it is stopped: `_record_result`, `on_motion`.
3. One that is not confirmed stays open, and is sent again while the robot is heard, also if it was
   refused, or as soon as there is a server: `must_repeat`, `send_again`.
4. An answer counts for the call that it belongs to, however late it comes: `_record_result`.
5. A STOP is past when a release or a goal is accepted that left after it, and never by one that
   left before it: `on_accepted`, `is_behind`. If a yes to it comes after that, it holds again: the
   robot may have carried it out last.
6. Whatever is answered, goals of this console that run on behind it are cancelled, and if it is not
   confirmed in time, those of other clients, too: `cancels_before`, `must_cancel_others`.

What a confirmed STOP means from then on is in `stop_latch.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection

from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot import services
from archo_tui.robot.fields import filled
from archo_tui.robot.graph import Graph
from archo_tui.robot.interface_checks import InterfaceChecks
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.services import Services
from archo_tui.robot.state import Latch, Motion, OpenStop, StopAnswer, not_offered
from archo_tui.robot.stop_answers import StopResult, not_sent, result_of
from archo_tui.robot.stop_latch import OBEYED, StopLatch
from archo_tui.robot_file import model

ALL_ANSWERS = 3.0  # Seconds that the answers of several servers are waited for.
FIRST_FOUND = 5.0  # Seconds from the start in which the robot may not be found yet.
_FIND_PERIOD = 0.1  # Seconds between two questions whether there is a server.
_REPEAT_AFTER = 1.0  # Seconds from an answer that is no yes to the next call.
_CANCEL_AFTER = 0.3  # Seconds in which the robot may end its goals by itself.
_CANCEL_OTHERS_AFTER = 1.0  # Seconds that all servers have to say yes.


class Stopping:
    """The sender of STOP, which counts the answers and keeps a STOP open until it is confirmed.

    Attributes:
        open: The STOP that is not confirmed yet, from its first call on; None if there is none.
        latch: What is known of the last confirmed STOP.
        cancels_others_before: The turn of a STOP; goals of other clients from before it are
            cancelled again and again. None if there is none.
    """

    def __init__(
        self,
        node: Node,
        stop: model.StopServices | None,
        clock: Clock,
        pending: Services,
        graph: Graph,
        checks: InterfaceChecks,
        unended_nodes: Callable[[], Collection[str]],
        on_change: Callable[[], None],
        report: Callable[[str, Code], None],
        report_again: Callable[[str], None],
    ) -> None:
        """Create the sender, before any STOP.

        Args:
            node: The console's own node.
            stop: The robot file's STOP; None: the robot has none.
            clock: The console's clock.
            pending: Makes the calls.
            graph: Tells which services are offered.
            checks: Tell the types of services.
            unended_nodes: Returns the full names of the nodes of this process whose code may
                still run.
            on_change: Called when `open` has changed, and when `latch` calls its own `on_change`.
            report: Called with the text and code of an outcome that no verb waits for any more.
            report_again: Called with a text that may be the same as before.
        """
        self._report_again = report_again
        self._node, self._stop, self._clock = node, stop, clock
        self._services, self._graph, self._checks = pending, graph, checks
        self._on_change, self._report = on_change, report
        self._begun = clock.monotonic()
        self.open: OpenStop | None = None
        self.latch = StopLatch(
            "" if stop is None else stop.service, clock, graph, unended_nodes, on_change
        )
        self._first_turn = 0  # The turn of the open STOP's first call; earlier calls do not count.
        self._answered_turn = 0  # The turn of the last call whose answer is shown.
        # The turn of the last STOP that was confirmed, and the monotonic time of that.
        self._confirmed: tuple[int, float] | None = None
        self._seen_stopped = -math.inf  # Monotonic time at which a report of it closed a STOP.
        # The turn of the last STOP; None if a release or a goal was accepted behind it.
        self._last_turn: int | None = None
        self._awaited = 0  # Calls whose answers are waited for.
        self._answered = -math.inf  # Monotonic time of the last answer, or of its absence.
        # Goals from before the turn are cancelled from the monotonic time on.
        self._cancels: tuple[int, float] | None = None
        self._others_cancelled = 0  # The turn of the last STOP for which goals of others were.
        self.cancels_others_before: int | None = None

    async def send(self) -> Outcome:
        """Send STOP, and wait until all servers have answered or their time is over.

        Without a server, one is waited for first (rule 1). The STOP is `open` until it is
        confirmed; then `latch` holds. The caller reports the outcome, but a later answer that
        changes what is shown is reported from here. The robot must have a STOP.

        Returns:
            The outcome, an error included; if the STOP is not confirmed, its text ends with the
            advice to use the hardware stop.
        """
        outcome, _ = await self._send()
        if outcome.ok:
            return outcome
        return outcome._replace(text=f"{outcome.text}: use the hardware stop")

    async def send_again(self) -> None:
        """Send the open STOP again, or for the first time (rule 3); nothing if none is open.

        A change of the answer is reported as an event, equal refusals as one with a count.
        """
        if self.open is None or self._awaited:
            return
        when = "now" if self.open.answer == StopAnswer.NOT_SENT else "again"
        outcome, is_news = await self._send()
        if is_news:
            self._report(f"STOP, sent {when}: {outcome.text}", outcome.code)
        elif outcome.code is Code.REFUSED:
            self._report_again(f"STOP, sent again: {outcome.text}")

    async def send_after_late_answer(self) -> None:
        """Send STOP again, since an earlier request was answered after it, and report the outcome.

        The earlier request may have been a release, which the robot then carried out last.
        """
        outcome = await self.send()
        self._report(f"STOP, sent again behind an earlier command: {outcome.text}", outcome.code)

    async def _send(self) -> tuple[Outcome, bool]:
        """Make one call, as of the open STOP; without an open one, open a STOP first.

        An answer that comes later and changes what is shown is reported.

        Returns:
            The outcome of the call, and True if it changes what is shown.
        """
        assert self._stop is not None
        sent, turn = self._clock.monotonic(), self._services.next_turn()
        if self.open is None:
            self.open, self._first_turn = OpenStop(sent), turn
            self._cancel_goals_from_before(turn)
        self._awaited += 1
        self._on_change()

        def on_late_result(result: StopResult) -> None:
            if self._record_result(result, turn, sent):
                self._report(f"STOP, answered late: {result.outcome.text}", result.outcome.code)

        try:
            await self._find_server(self._stop.service)
            result = await self._call(self._stop, on_late_result)
        except Exception as error:  # Whatever failed, nothing was stopped.
            result = not_sent(Code.REFUSED, in_one_line(error))
        finally:
            self._awaited -= 1
        self._answered = self._clock.monotonic()
        is_news = self._record_result(result, turn, sent)
        if result.outcome.code is Code.TIMEOUT and self._seen_stopped >= sent:
            return Outcome(Code.DONE, "the robot says that it is stopped"), is_news
        return result.outcome, is_news

    def _record_result(self, result: StopResult, turn: int, sent: float) -> bool:
        """Record the result of one call (rules 2 and 4).

        A yes makes the latch hold, also if its STOP was given up or released meanwhile, and closes
        the open STOP; one to a call from before the open STOP is ignored. Another result becomes
        the answer of the open STOP, unless a later call was answered before, or the call is from
        before the STOP that was opened last.

        Args:
            result: What the servers answered.
            turn: The number of the call.
            sent: Monotonic time at which the call began.

        Returns:
            True if that changes what is shown.
        """
        if result.outcome.ok:
            # A yes to a call from before the open STOP confirms no later one.
            is_earlier = self.open is not None and turn < self._first_turn
            return not is_earlier and self._record_yes(turn, sent)
        if turn < self._first_turn:
            return False
        if result.answer == StopAnswer.UNCONFIRMED:
            self._expect_obeyed(turn)
        if self.open is None:
            return False
        if turn <= self._answered_turn and self.open.answer != StopAnswer.NONE:
            return False  # A later call was answered already.
        if result.answer == StopAnswer.NONE and self.open.answer == StopAnswer.REFUSED:
            return False  # A server that refuses late would be told as silent each time.
        before, self._answered_turn = self.open, turn
        self.open = OpenStop(before.asked, result.answer, result.why)
        self._on_change()
        return self.open != before

    def _record_yes(self, turn: int, sent: float) -> bool:
        """Make the latch hold, and close the open STOP; return True if that changes what is shown.

        Without an open STOP, the yes is to one that was given up, or that is past: the robot may
        have carried it out just now.

        Args:
            turn: The number of the call.
            sent: Monotonic time at which the call began.
        """
        is_new = self.open is not None or self.latch.state is not Latch.HELD
        if self.open is None and is_new:
            turn, sent = self._services.next_turn(), self._clock.monotonic()
        self._expect_obeyed(turn)
        self.latch.hold()
        if is_new:
            self.latch.expect_standstill(sent if self.open is None else self.open.asked)
        self.close()
        return is_new

    def _expect_obeyed(self, turn: int) -> None:
        """Expect that goals from before a STOP end, unless that is known of a later one."""
        if self._confirmed is None or turn >= self._confirmed[0]:
            self._confirmed = turn, self._clock.monotonic()
        self._cancel_goals_from_before(turn)

    def _cancel_goals_from_before(self, turn: int) -> None:
        """Have the goals from before a STOP cancelled _CANCEL_AFTER, or when it is due already."""
        now = self._clock.monotonic()
        if self._cancels is None or turn > self._cancels[0]:
            is_due_soon = self._cancels is not None and self._cancels[1] > now
            due = self._cancels[1] if self._cancels and is_due_soon else now + _CANCEL_AFTER
            self._cancels = turn, due

    @property
    def cancels_before(self) -> int | None:
        """The turn of a STOP; goals of this console from before it must be cancelled.

        That does not end with a release. None if there was no STOP, or the robot still has time to
        end its goals itself.
        """
        if self._cancels is None or self._clock.monotonic() < self._cancels[1]:
            return None
        return self._cancels[0]

    def must_cancel_others(self, *, moves: bool) -> bool:
        """Return True, once for each open STOP, if goals of other clients must be cancelled.

        Args:
            moves: True if a goal runs, or the robot reports a motion.
        """
        stop = self.open
        if stop is None or not moves or self._others_cancelled == self._first_turn:
            return False
        if self._clock.monotonic() - stop.asked < _CANCEL_OTHERS_AFTER:
            return False
        self._others_cancelled = self.cancels_others_before = self._first_turn
        return True

    def is_behind(self, turn: int) -> bool:
        """Return True if a STOP left after the request of that turn, or is about to leave (rule 5).

        The robot may obey the request last: a busy server takes waiting requests in any order. A
        STOP behind which something was accepted no longer counts.

        Args:
            turn: The number of the request.
        """
        is_before_open = self.open is not None and turn < self._first_turn
        return is_before_open or (self._last_turn is not None and turn <= self._last_turn)

    def on_accepted(self, turn: int) -> None:
        """Record that a release or a goal was accepted: STOPs from before it are past (rule 5).

        The open STOP is closed, and the latch released, even if it did not hold. Nothing is done if
        a STOP of this or another console came after the request.

        Args:
            turn: The number of the request of the release or the goal.
        """
        if self.is_behind(turn) or turn <= self.latch.other_turn:
            return
        self._last_turn = self.cancels_others_before = None
        self.latch.release()
        if self.open is not None:
            self.close()

    def on_stopped_elsewhere(self, console: str) -> None:
        """Record that another console reports that the robot has confirmed its STOP.

        Goals from before now must end, as with a STOP of this console. The open STOP of this
        console stays open. For a robot whose file has no STOP, nothing is done.

        Args:
            console: The other console.
        """
        if self._stop is None:
            return
        turn = self._services.next_turn()
        self._expect_obeyed(turn)
        self.latch.on_stopped_elsewhere(console, turn)

    def on_motion(self, motion: Motion) -> None:
        """Record a message about the robot's motion: "stopped" confirms the open STOP (rule 2).

        The confirmation is reported as an event if the STOP's answer was NONE: not every server
        had answered in time. The latch gets each message.

        Args:
            motion: The message. Pass it only if a single node publishes the motion.
        """
        if self.open is not None and motion.stopped:
            self._expect_obeyed(self._first_turn)
            self._seen_stopped = self._clock.monotonic()
            self.latch.expect_standstill(self.open.asked)
            if self.open.answer == StopAnswer.NONE:
                text = "STOP, sent again: the robot says that it is stopped"
                self._report(text, Code.DONE)
            self.close()
        self.latch.on_motion(motion)

    def close(self) -> None:
        """Forget the open STOP: it is confirmed, past, or given up. The latch stays as it is."""
        self.open = None
        self._on_change()

    def give_up(self) -> None:
        """Close the open STOP though it is not confirmed, and leave goals of others alone."""
        self.cancels_others_before = None
        self.close()

    @property
    def is_held_by_nobody(self) -> bool:
        """True if all nodes that held the STOP ran here and have ended, and no STOP is open.

        The latch knows this since its last `check_holders`.
        """
        return self.open is None and self.latch.holders_have_ended

    def must_repeat(self, *, moves: bool) -> bool:
        """Return True if the open STOP must be sent again (rule 3); never while a call is awaited.

        That is so a second after an answer that is no yes. One that can be neither yes nor no
        counts only while the robot moves, and one without a server as soon as there is one.

        Args:
            moves: True if a goal runs, or the robot reports a motion.
        """
        if self._stop is None or self.open is None or self._awaited:
            return False
        answer = self.open.answer
        if answer == StopAnswer.NOT_SENT:
            self._graph.recheck_service(self._stop.service)
            return self._stop.service in self._graph.offered
        if answer == StopAnswer.UNCONFIRMED and not moves:
            return False
        return self._clock.monotonic() - self._answered >= _REPEAT_AFTER

    @property
    def obeyed_stop_turn(self) -> int | None:
        """The turn of the last STOP that the robot must have obeyed by now.

        Goals from before it must have ended. Only STOPs count that all servers answered, none with
        a refusal, or behind which the robot reported that it is stopped, and those of other
        consoles; a release does not clear it. None if there was none, or the last one was
        answered or reported less than OBEYED ago.
        """
        if self._confirmed is None:
            return None
        turn, confirmed = self._confirmed
        return turn if self._clock.monotonic() - confirmed >= OBEYED else None

    async def _find_server(self, service: str) -> None:
        """Look for a server of STOP (rule 1); in the first 5 s of the console, wait for one."""
        end = self._begun + FIRST_FOUND
        while service not in self._graph.offered:
            self._graph.recheck_service(service)
            if service in self._graph.offered or self._clock.monotonic() >= end:
                return
            await self._services.pause(_FIND_PERIOD)

    async def _call(
        self, stop: model.StopServices, on_late_result: Callable[[StopResult], None]
    ) -> StopResult:
        """Make one call, and return what its servers answered in time (rule 1).

        If there is no server, or its type does not fit, nothing is sent, as the result tells.

        Args:
            stop: The robot file's STOP.
            on_late_result: Called if the last answer comes later, within `services.LATE`.
        """
        name = stop.service
        if name not in self._graph.offered:
            return not_sent(Code.NOT_OFFERED, not_offered(self._checks.full(name)))
        srv_type, reason = self._checks.fitting_class(name, stop.request)
        if srv_type is None:
            return not_sent(Code.REFUSED, reason)
        request = filled(srv_type.Request(), stop.request)
        servers = max(self._node.count_services(name), 1)
        wait = services.DEADLINE if servers == 1 else ALL_ANSWERS
        # Before it leaves: a server may confirm it and be gone at once. On a graph of 4,000 names
        # this takes some 15 ms.
        self._last_turn, self.latch.sent_to = self._services.next_turn(), self._graph.holders(name)
        answers = await self._services.call_all(
            *(srv_type, name, request, servers, wait),
            lambda answers: on_late_result(result_of(answers, servers, wait)),
        )
        return result_of(answers, servers, wait)
