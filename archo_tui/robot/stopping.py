"""The STOP that was asked for, until the robot has confirmed it. ROS thread only.

One call of a service reaches every server of its name, and each answers; a client cannot choose.
So the answers to one call are counted, and only when all say yes has the robot been stopped.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot import message_classes, services
from archo_tui.robot.fields import filled
from archo_tui.robot.graph import Graph
from archo_tui.robot.offers import Offers
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.services import Services
from archo_tui.robot.state import Latch, Motion, OpenStop, StopAnswer, not_offered
from archo_tui.robot_file import model

ALL_ANSWERS = 3.0  # s that the answers of several servers are waited for
OBEYED = 1.0  # s after the answer to a STOP in which every goal has ended
FIRST_FOUND = 5.0  # s from the start in which the robot may not be found yet
_SETTLED = 1.0  # s after a change of nodes in which what the one before has said still comes
_FIND_PERIOD = 0.1  # s between two looks for a server
_NOTHING_NEW = (
    "",
    "done",
    "ok",
    "stop",
    "stopped",
    "success",
)  # in the answer to a STOP that is confirmed


class _Said(NamedTuple):
    """What came of one call of STOP."""

    outcome: Outcome
    answer: StopAnswer = StopAnswer.AWAITED  # and why, until it is over
    why: str = ""


class Stopping:
    """Sends STOP, counts the answers, and remembers one that was not confirmed."""

    def __init__(
        self,
        node: Node,
        stop: model.StopServices | None,
        clock: Clock,
        pending: Services,
        graph: Graph,
        offers: Offers,
        changed: Callable[[], None],
        tell: Callable[[str, Code], None],
    ) -> None:
        """`changed()` is called with each new state.

        `tell(text, code)` is called with what came of a STOP that nobody waits for.
        """
        self._node, self._stop, self._clock = node, stop, clock
        self._services, self._graph, self._offers = pending, graph, offers
        self._changed, self._tell = changed, tell
        self._begun = clock.monotonic()
        self.open: OpenStop | None = None  # the first that is not confirmed
        self._first = 0  # the turn of that first one: an answer to an earlier one is not to it
        self._told = 0  # the turn of the one that was answered so
        self._answered: tuple[float, float] | None = None  # when the last was sent, and confirmed
        self._unheeded: float | None = None  # when one was sent, if the robot moved ever since
        self._is_latched = False  # as the robot said last
        self.is_unheeded = False  # the robot says that it moves, though it has confirmed a STOP
        self._left: int | None = None  # the turn of the last one, that nothing was accepted behind
        self.latch = Latch.NONE
        self.lost = ""  # why an UNCERTAIN one is not certain
        self.time = 0.0  # Unix time of that STOP
        self._doubt = ""  # why one that the robot does not report is not certain, whoever holds it
        self._by = ""  # the other console that sent it; empty: this one did
        self._theirs = 0  # the turn in which another console told of its last one
        self._reports = False  # the robot says whether it is stopped
        self._moves_since: float | None = None  # since when it says that it moves, monotonic s
        self.released: float | None = None  # when the robot confirmed a release, monotonic s
        self._holders: dict[str, frozenset[bytes]] = {}  # the nodes that hold it, and their ids
        self._asked: dict[str, frozenset[bytes]] = {}  # those that the last STOP was sent to
        self._told_anew: set[str] = set()  # those that their host told of it at their start
        self._changed_at = 0.0  # when another node than these was seen, monotonic s

    async def send(self) -> Outcome:
        """Stop the robot; ends when all servers answered, or did not in time."""
        outcome, _ = await self._send()
        if outcome.ok:
            return outcome
        return outcome._replace(text=f"{outcome.text}: use the hardware stop")

    async def send_again(self) -> None:
        """A STOP that was not answered, while the robot is heard: it may drive on.

        Answers to earlier calls still count. One that could not be sent is sent now.
        """
        if self.open is None:
            return
        sent = "now" if self.open.answer == StopAnswer.NOT_SENT else "again"
        outcome, is_news = await self._send()
        if is_news:
            self._tell(f"STOP, sent {sent}: {outcome.text}", outcome.code)

    async def _send(self) -> tuple[Outcome, bool]:
        """How one call ended, and whether that was news."""
        assert self._stop is not None
        sent, number = self._clock.monotonic(), self._services.turn()
        if self.open is None:
            self.open, self._first = OpenStop(sent), number
        self._changed()

        def late(said: _Said) -> None:
            if self._take(said, number, sent):
                self._tell(f"STOP, answered late: {said.outcome.text}", said.outcome.code)

        try:
            await self._found(self._stop.service)
            said = await self._call(self._stop, late)
        except Exception as error:  # whatever it is, nobody was stopped
            said = _not_sent(Code.REFUSED, in_one_line(error))
        return said.outcome, self._take(said, number, sent)

    def _take(self, said: _Said, number: int, sent: float) -> bool:
        """What came of the call of that turn, sent at that time; True when it is news."""
        if number < self._first:  # something was allowed behind it, and then stopped again
            return False
        if said.outcome.ok or said.answer == StopAnswer.UNCONFIRMED:
            self._answered = sent, self._clock.monotonic()
        if said.outcome.ok:
            self._hold()
        if self.open is None:  # another one was confirmed meanwhile
            return False
        if said.outcome.ok:
            self._unheeded = self.open.asked
            self.over()
            return True
        if number <= self._told and self.open.answer != StopAnswer.NONE:  # one has more to say
            return False
        before, self._told = self.open, number
        self.open = OpenStop(before.asked, said.answer, said.why)
        self._changed()
        return self.open != before

    def is_behind(self, turn: int) -> bool:
        """True when a STOP left after that turn, or was asked for then and has not left yet.

        Which of the two the robot takes last is open: one that is busy takes what waits for it in
        an order of its own.
        """
        is_before_open = self.open is not None and turn < self._first
        return is_before_open or (self._left is not None and turn <= self._left)

    def past(self, turn: int) -> None:
        """A release or a goal of that turn was accepted: a STOP before it is past."""
        if self.is_behind(turn) or turn <= self._theirs:
            return
        self._left = self._unheeded = None
        self.latch, self.released, self._doubt = Latch.NONE, self._clock.monotonic(), ""
        if self.open is not None:
            self.over()

    def _hold(self) -> None:
        """Remember that the robot is stopped, and by which nodes."""
        assert self._stop is not None
        self.latch, self.lost, self._doubt, self._by = Latch.HELD, "", "", ""
        self.time = self._clock.now()
        # a node may leave as it confirms: any node that comes later would pass for it
        self._holders = self._graph.holders(self._stop.service) or self._asked
        self._told_anew.clear()

    def told_anew(self, node: str) -> None:
        """A node that was started here was told of the STOP before anything else."""
        self._told_anew.add(node)
        self.look_at_holders()

    def stopped_elsewhere(self, console: str) -> None:
        """Take another console's word that the robot has confirmed its STOP.

        It ends the goals from before it, as one of ours does. Of a robot that does not report a
        stop itself nothing else tells of it here.
        """
        if self._stop is None:
            return
        now = self._clock.monotonic()
        self._answered = now, now
        if self._reports:
            return
        self._theirs = self._services.turn()
        self._unheeded = now  # it is to come to rest from now on
        if self.latch is not Latch.HELD:
            self._hold()
            self._by = console
            self._changed()

    def released_elsewhere(self, console: str) -> None:
        """Take another console's word that it has released the STOP.

        Of a robot that does not report a stop itself the STOP is then no longer certain, unless
        that console sent it.
        """
        if self._reports or (self._by == console and self.latch is Latch.HELD):
            self.latch = Latch.NONE
            self._changed()
        else:
            self._cast_doubt(f"console {console} released it")

    def _cast_doubt(self, why: str) -> None:
        """Hold a STOP that the robot does not report for uncertain, until a release or another."""
        if self.latch is not Latch.NONE and not self._doubt:
            self.latch, self.lost, self._doubt = Latch.UNCERTAIN, why, why
            self._changed()

    def look_at_holders(self) -> None:
        """See whether the nodes that hold the STOP are those that confirmed it."""
        if self.latch is Latch.NONE or self._stop is None or self._doubt:
            return
        now, before = self._graph.holders(self._stop.service), (self.latch, self.lost)
        anew = {node: ids for node, ids in now.items() if node in self._told_anew}
        held = {**self._holders, **anew}
        if not self._holders or now == held:
            self._holders, self.latch, self.lost = now, Latch.HELD, ""
            self._told_anew -= now.keys()
        else:
            self.latch = Latch.UNCERTAIN
            gone = sorted(held.keys() - now.keys())
            new = sorted(node for node, ids in now.items() if ids != held.get(node))
            self.lost = f"{new[0]} was started since" if new else f"{gone[0]} has left"
            if new:
                self._changed_at = self._clock.monotonic()
        if before != (self.latch, self.lost):
            self._changed()

    def heard(self, motion: Motion) -> None:
        """What the robot says of itself, by one node only."""
        if self.open is not None and motion.stopped:
            self._unheeded = self.open.asked
            if self.open.answer == StopAnswer.NONE:
                said = "STOP, sent again: the robot says that it is stopped"
                self._tell(said, Code.DONE)
            self.over()
        self._reports = motion.stopped is not None
        released = self._is_latched and motion.stopped is False
        self._is_latched = bool(motion.stopped)
        if motion.stopped:
            settled = self._clock.monotonic() - self._changed_at >= _SETTLED
            if self.latch is Latch.NONE or (self.latch is Latch.UNCERTAIN and settled):
                self._hold()
        elif released and self.latch is Latch.HELD:
            self.look_at_holders()  # it may be another node that says so
            if self.latch is Latch.HELD:
                self.latch = Latch.NONE
        if released or not motion.moving:
            self._unheeded = None
        elif self._is_latched and self._unheeded is None:  # whoever stopped it
            self._unheeded = motion.received
        since, now = self._unheeded, motion.received
        self.is_unheeded = since is not None and now is not None and now - since >= OBEYED
        if not motion.moving or now is None:
            self._moves_since = None
        elif self._moves_since is None:
            self._moves_since = now
        elif now - self._moves_since >= OBEYED and since is None and not self._reports:
            self._cast_doubt("the robot moves")

    def over(self) -> None:
        """It is confirmed, past, or given up."""
        self.open = None
        self._changed()

    @property
    def is_to_be_repeated(self) -> bool:
        """True for one that the robot may not have got.

        Not every server has answered, or there was none as it was asked for, and now there is.
        """
        if self._stop is None or self.open is None:
            return False
        is_late = self.open.answer == StopAnswer.NOT_SENT
        is_late = is_late and self._stop.service in self._graph.offered
        return is_late or self.open.answer == StopAnswer.NONE

    @property
    def obeyed_since(self) -> float | None:
        """When the last confirmed one was sent, once what ran before it must have ended."""
        if self._answered is None:
            return None
        sent, confirmed = self._answered
        return sent if self._clock.monotonic() - confirmed >= OBEYED else None

    async def _found(self, name: str) -> None:
        """Wait for a server: up to DEADLINE after a restart of its node, longer at the start."""
        now = self._clock.monotonic()
        end = max(now + services.DEADLINE, self._begun + FIRST_FOUND)
        while name not in self._graph.offered and self._clock.monotonic() < end:
            await self._services.pause(_FIND_PERIOD)
            self._graph.look_for(name)

    async def _call(self, stop: model.StopServices, late: Callable[[_Said], None]) -> _Said:
        """One call: what its servers said of it, in time; or `late`."""
        name = stop.service
        if name not in self._graph.offered:
            reason = not_offered(self._offers.full(name))
            return _not_sent(Code.NOT_OFFERED, reason)
        srv_type, reason = self._offers.fitting(name, stop.request)
        if srv_type is None:
            return _not_sent(Code.REFUSED, reason)
        request = filled(srv_type.Request(), stop.request)
        servers = max(self._node.count_services(name), 1)
        wait = services.DEADLINE if servers == 1 else ALL_ANSWERS
        self._left, self._asked = self._services.turn(), self._graph.holders(name)
        answers = await self._services.call_all(
            *(srv_type, name, request, servers, wait),
            lambda answers: late(_said(answers, servers, wait)),
        )
        return _said(answers, servers, wait)


def _not_sent(code: Code, reason: str) -> _Said:
    return _Said(Outcome(code, reason), StopAnswer.NOT_SENT, f"({reason})")


def _said(answers: list[Any], servers: int, wait: float) -> _Said:
    """What the answers of so many servers come to."""
    said = [(answer, message_classes.outcome_of(answer)) for answer in answers]
    refused = [outcome.text for answer, outcome in said if message_classes.refuses(answer)]
    of = f" by {len(refused)} of {servers}" if servers > 1 else ""
    if refused:
        outcome = Outcome(Code.REFUSED, f"REFUSED{of}: {refused[0]}")
        return _Said(outcome, StopAnswer.REFUSED, f"{of} ({refused[0]})".lstrip())
    if len(answers) < servers:
        if servers == 1:
            return _Said(Outcome(Code.TIMEOUT, f"no answer in {wait:g} s"), StopAnswer.NONE)
        counted = f"{len(answers)} of {servers} answered"
        outcome = Outcome(Code.TIMEOUT, f"{counted} in {wait:g} s")
        return _Said(outcome, StopAnswer.NONE, f"from all ({counted})")
    doubtful = next((outcome for _, outcome in said if not outcome.ok), None)
    if doubtful is not None:
        return _Said(doubtful, StopAnswer.UNCONFIRMED)
    return _Said(Outcome(Code.DONE, _confirmed(said[0][1].text)))


def _confirmed(text: str) -> str:
    """That it is, and the robot's own words where they say more."""
    return "confirmed" if text.lower().rstrip(".!") in _NOTHING_NEW else f"confirmed: {text}"
