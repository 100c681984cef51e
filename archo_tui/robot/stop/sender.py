"""The sending of STOP: calls, servers and answers, and what `machine` asks for. ROS thread only.

Each event goes to the machine, and what it returns is carried out; `answers_of` alone judges.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

from archo_tui.base.errors import in_one_line
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.outcome import Code, Outcome, outcome_of, refuses
from archo_tui.robot.runtime import Runtime
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.graph import not_offered
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Latch, StopAnswer
from archo_tui.robot.stop.machine import NOBODY, Facts, Result, Servers, Stop, StopEffect
from archo_tui.robot.telemetry import Telemetry
from archo_tui.robot_file import model

ALL_ANSWERS = 3.0  # Seconds that the answers of several servers are waited for.
FIRST_FOUND = 5.0  # Seconds from the start in which the robot may not be found yet.
_FIND_PERIOD = 0.1  # Seconds between two questions whether there is a server.
_PERIOD = 0.2  # Seconds between two ticks of the machine while a STOP is open or a goal runs.
_SAYS_NO_MORE = ("", "done", "ok", "stop", "stopped", "success")  # Texts of a plain confirmation.


class Answers(NamedTuple):
    """The answers to one call: for whoever sent it, and for the machine."""

    outcome: Outcome
    result: Result


class StopSender:
    """The sender of STOP."""

    def __init__(
        self,
        runtime: Runtime,
        service: model.StopServices | None,
        graph: Graph,
        checks: InterfaceChecks,
        goals: Goals,
        telemetry: Telemetry,
        unended_nodes: Callable[[], Collection[str]],
    ) -> None:
        self._node, self._clock, self._thread = runtime.node, runtime.clock, runtime.thread
        self._reporter, self._snapshots = runtime.reporter, runtime.snapshots
        self._served, self._graph, self._checks = service, graph, checks
        self._goals, self._telemetry, self._unended_nodes = goals, telemetry, unended_nodes
        self._begun = self._clock.monotonic()
        self.stop = Stop()
        self.time = 0.0  # Unix time at which the last STOP was confirmed; 0 before the first.
        # The running goals that began before a confirmed STOP, and should have ended by now.
        self.still_running: tuple[str, ...] = ()
        self._timer = self._node.create_steady_timer(_PERIOD, self.tick)
        self._timer.cancel()

    def _become(self, after: Stop) -> bool:
        """Take the next state; return True if that changes what is shown, and have it shown."""
        before, self.stop = self.stop, after
        if after.held != before.held:
            self.time = self._clock.now()
        if after.shown != before.shown:
            self.begin_ticking()
            self._snapshots.send()
        return (after.open, after.latch) != (before.open, before.latch)

    # Calls.

    async def send(self, *, is_pressed: bool = True) -> Outcome:
        """Send STOP, and wait until all servers have answered or their time is over."""
        outcome, _ = await self._call(self._begin_call(is_pressed=is_pressed))
        if outcome.ok:
            return outcome
        return outcome._replace(text=f"{outcome.text}: use the hardware stop")

    async def send_after_late_answer(self) -> None:
        """Send STOP again: the robot may have carried out a release from before it last."""
        outcome = await self.send(is_pressed=False)
        text = f"STOP, sent again behind an earlier command: {outcome.text}"
        self._reporter.report_stop_result(text, outcome.code)

    async def _send_again(self, turn: int, when: str) -> None:
        outcome, is_news = await self._call(turn)
        if is_news:
            self._reporter.report_stop_result(f"STOP, sent {when}: {outcome.text}", outcome.code)
        elif outcome.code is Code.REFUSED:  # Equal ones are one event with a count.
            self._reporter.warn(f"STOP, sent again: {outcome.text}")

    def _begin_call(self, *, is_pressed: bool = False) -> int:
        turn, now = self._node.next_turn(), self._clock.monotonic()
        self._become(self.stop.calling(turn, now, is_pressed=is_pressed))
        return turn

    async def _call(self, turn: int) -> tuple[Outcome, bool]:
        """Make a call; return its outcome, and True if it changes what is shown."""
        assert self._served is not None
        sent, asked = self._clock.monotonic(), NOBODY

        def record(answers: Answers, *, is_late: bool = False) -> bool:
            return self._become(
                self.stop.answered_by(
                    answers.result,
                    turn,
                    self._clock.monotonic(),
                    self._node.next_turn(),
                    asked,
                    self._servers(),
                    self._unended_nodes(),
                    is_late=is_late,
                )
            )

        def on_late(answers: Answers) -> None:
            if record(answers, is_late=True):
                text = f"STOP, answered late: {answers.outcome.text}"
                self._reporter.report_stop_result(text, answers.outcome.code)

        try:
            await self._find_server(self._served.service)
            # Before it leaves: a server may confirm it and be gone at once. On a graph of 4,000
            # names this takes some 15 ms.
            asked = self._servers()
            if self.stop.is_wanted(turn):
                answers = await self._ask_servers(self._served, asked, on_late)
            else:
                answers = _not_sent(Code.CANCELLED, "it was released or given up before it left")
        except Exception as error:  # Whatever failed, nothing was stopped.
            answers = _not_sent(Code.REFUSED, in_one_line(error))
        is_news = record(answers)
        if answers.outcome.code is Code.TIMEOUT and self.stop.seen_stopped >= sent:
            return Outcome(Code.DONE, "the robot says that it is stopped"), is_news
        return answers.outcome, is_news

    async def _find_server(self, service: str) -> None:
        """Look for a server of STOP; in the first 5 s of the console, wait for one."""
        end = self._begun + FIRST_FOUND
        while service not in self._graph.offered:
            self._graph.recheck_service(service)
            if service in self._graph.offered or self._clock.monotonic() >= end:
                return
            await self._node.pause(_FIND_PERIOD)

    async def _ask_servers(
        self, stop: model.StopServices, asked: Servers, on_late: Callable[[Answers], None]
    ) -> Answers:
        """Call STOP, and return what its servers answered in time."""
        name = stop.service
        if name not in self._graph.offered:
            return _not_sent(Code.NOT_OFFERED, not_offered(self._checks.full(name)))
        srv_type, request, reason = self._checks.request(name, stop.request)
        if srv_type is None:
            return _not_sent(Code.REFUSED, reason)
        servers = max(self._node.count_services(name), 1)
        wait = DEADLINE if servers == 1 else ALL_ANSWERS
        self._become(self.stop.leaving(self._node.next_turn(), asked))
        answers = await self._node.call_all(
            *(srv_type, name, request, servers, wait),
            lambda answers: on_late(answers_of(answers, servers, wait)),
        )
        return answers_of(answers, servers, wait)

    def _servers(self) -> Servers:
        if self._served is None:
            return NOBODY
        with suppress(Exception):  # A STOP leaves, and is answered, whatever the graph says.
            return frozenset(self._graph.holders(self._served.service).items())
        return NOBODY

    # Events of others.

    def on_goal_accepted(self, turn: int) -> None:
        """Record that a goal was accepted, by the turn of its request."""
        self._become(self.stop.goal_accepted(turn, self._clock.monotonic()))

    def on_release_accepted(self, turn: int) -> None:
        """Record that a release was accepted, by the turn of its request."""
        now, turn_now = self._clock.monotonic(), self._node.next_turn()
        self._become(self.stop.release_accepted(turn, now, turn_now))

    def give_up(self) -> None:
        """Send the open STOP no more, though it is not confirmed."""
        self._become(self.stop.given_up())

    def on_stopped_elsewhere(self, console: str) -> None:
        """Record that another console reports that the robot confirmed its STOP."""
        if self._served is not None:
            turn, now = self._node.next_turn(), self._clock.monotonic()
            servers, here = self._servers(), self._unended_nodes()
            self._become(self.stop.stopped_elsewhere(console, turn, now, servers, here))

    def on_released_elsewhere(self, console: str) -> None:
        """Record that another console reports that it released the STOP."""
        turn, now = self._node.next_turn(), self._clock.monotonic()
        self._become(self.stop.released_elsewhere(console, turn, now))

    def on_early_stop(self, node: str) -> None:
        """Record that a starting node of this process has carried the STOP out."""
        self._become(self.stop.carried_out_early(node))
        self.check_holders()

    def check_holders(self) -> None:
        """Compare the nodes that serve STOP now with those that confirmed it."""
        if self.stop.latch is not Latch.NONE:
            servers, here = self._servers(), self._unended_nodes()
            self._become(self.stop.served_by(servers, here, self._clock.monotonic()))

    def on_motion(self, motion: Motion) -> None:
        """Record a report of the only node that publishes the motion."""
        before, now = self.stop, self._clock.monotonic()
        servers = self._servers() if before.needs_servers(motion) else NOBODY
        self._become(before.moved(motion, now, servers, self._unended_nodes()))
        is_closed = before.open is not None and self.stop.open is None
        if is_closed and before.open and before.open.answer is StopAnswer.NONE:
            text = "STOP: the robot says that it is stopped"
            self._reporter.report_stop_result(text, Code.DONE)

    # What is due.

    def begin_ticking(self) -> None:
        """Start the timer of the machine, since a STOP or a goal may have begun."""
        if self._timer.is_canceled():
            self._timer.reset()

    def tick(self) -> None:
        """Carry out what the machine asks for now; end the timer if nothing is left to do."""
        goals, now = self._goals, self._clock.monotonic()
        if not goals.running and self.stop.open is None:
            self._timer.cancel()
        after, todo = self.stop.tick(now, self._facts(now))
        self._become(after)
        for what, turn in todo:
            if what is StopEffect.SEND:
                is_first = self.stop.open and self.stop.open.answer is StopAnswer.NOT_SENT
                when = "now" if is_first else "again"
                self._thread.submit(partial(self._send_again, self._begin_call(), when))
            elif what is StopEffect.CANCEL_ALL:
                self._thread.submit(self._cancel_all)
            else:
                goals.cancel_from_before(turn, mine=what is StopEffect.CANCEL_OWN)
        names = goals.names_from_before(self.stop.must_be_obeyed(now))
        if names != self.still_running:
            self.still_running = names
            self._snapshots.send_soon()

    def _facts(self, now: float) -> Facts:
        motion = self._telemetry.motion
        moves = bool(motion.moving) and not motion.is_old(now)
        service = "" if self._served is None else self._served.service
        if self.stop.open is not None and service not in self._graph.offered:
            self._graph.recheck_service(service)
        return Facts(
            moves=moves or bool(self._goals.running),
            is_heard=self._telemetry.is_robot_heard(),
            is_offered=service in self._graph.offered,
        )

    async def _cancel_all(self) -> None:
        """Cancel every goal of the tracked actions, and report what came of it."""
        runs_here = self._goals.ours is not None
        outcome = await self._goals.cancel_others()
        if outcome.code is Code.REFUSED and runs_here:
            return  # Only a goal of this console ran, whose end is an event.
        text = f"STOP was not confirmed in time: {outcome.text}"
        self._reporter.report_done(text, AuditRecord("cancel", {"all": True}, outcome.code))


def _not_sent(code: Code, reason: str) -> Answers:
    return Answers(Outcome(code, reason), Result(StopAnswer.NOT_SENT, f"({reason})"))


def answers_of(answers: list[Any], servers: int, wait: float) -> Answers:
    """Return what the answers of all servers to one call come to.

    It is a yes only if every server says yes. Otherwise a refusal counts first, then a missing
    answer, then one that is neither yes nor no.
    """
    read = [(answer, outcome_of(answer)) for answer in answers]
    refusals = [outcome.text for answer, outcome in read if refuses(answer)]
    of = f" by {len(refusals)} of {servers}" if servers > 1 else ""
    if refusals:
        outcome = Outcome(Code.REFUSED, f"REFUSED{of}: {refusals[0]}")
        return Answers(outcome, Result(StopAnswer.REFUSED, f"{of} ({refusals[0]})".lstrip()))
    if len(answers) < servers:
        if servers == 1:
            outcome = Outcome(Code.TIMEOUT, f"no answer in {wait:g} s")
            return Answers(outcome, Result(StopAnswer.NONE))
        counted = f"{len(answers)} of {servers} answered"
        outcome = Outcome(Code.TIMEOUT, f"{counted} in {wait:g} s")
        return Answers(outcome, Result(StopAnswer.NONE, f"from all ({counted})"))
    unclear = next((outcome for _, outcome in read if not outcome.ok), None)
    if unclear is not None:
        return Answers(unclear, Result(StopAnswer.UNCONFIRMED))
    text = read[0][1].text
    says_no_more = text.lower().rstrip(".!") in _SAYS_NO_MORE
    confirmed = "confirmed" if says_no_more else f"confirmed: {text}"
    return Answers(Outcome(Code.DONE, confirmed), Result(StopAnswer.AWAITED))
