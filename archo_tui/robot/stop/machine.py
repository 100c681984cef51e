"""STOP as a machine: every rule about it, without I/O.

`Stop` is a state; each method is an event, takes the time with it, and returns the next state.
`tick` also returns what is to be done now. LATCH is the table of what is known of the last
confirmed STOP; the methods decide which event of it has happened.

An open STOP needs no table: it is open from its first call until YES, SAYS_STOPPED, ACCEPTED or
`given_up`, and shows the last answer that was no yes.

Times are monotonic seconds. Turns are the order in which requests leave and goals are tracked.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from enum import Enum, auto
from typing import NamedTuple

from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Latch, OpenStop, StopAnswer

# All in seconds.
OBEYED = 1.0  # From a confirmed STOP until the robot must stand and its goals must have ended.
CANCEL_AFTER = 0.3  # In which the robot may end its goals by itself.
CANCEL_OTHERS_AFTER = 1.0  # In which all servers must say yes.
REPEAT_AFTER = 1.0  # From an answer that is no yes to the next call.
SETTLED = 1.0  # From a change of nodes, in which reports of the old ones still come.

# The nodes that serve STOP, each with the ids of its endpoints, which a restart changes.
Servers = frozenset[tuple[str, frozenset[bytes]]]
NOBODY: Servers = frozenset()


class Event(Enum):
    """An event of the last confirmed STOP."""

    YES = auto()  # All servers said yes, however late, but not to a call from before the open one.
    YES_TO_PAST = auto()  # The same to a call behind which something was accepted before.
    SAYS_STOPPED = auto()  # The robot reports that it is stopped.
    SAYS_RELEASED = auto()  # The robot reports for the first time that it is no longer stopped.
    MOVES = auto()  # It moves for OBEYED, and never reports whether it is stopped.
    ACCEPTED = auto()  # A release or a goal that left behind every STOP.
    PEER_STOPPED = auto()  # Another console's STOP, of a robot that does not report its stops.
    PEER_UNDID = auto()  # Another console released its own STOP.
    MAY_BE_RELEASED = auto()  # By another console, or by a release that may have come before.
    LEFT_SILENT = auto()  # A node to which it was sent has left without an answer.
    SERVERS_SAME = auto()  # The nodes that confirmed it serve it, and none was restarted.
    SERVERS_DIFFER = auto()  # One of them has left or was restarted, or another one serves it.


class State(Enum):
    """The knowledge of the last confirmed STOP. The last two are both shown as uncertain."""

    NONE = auto()
    HELD = auto()
    UNCERTAIN = auto()  # Until its nodes are back.
    DOUBTED = auto()  # Until it is released or confirmed again.


_N, _H, _U, _D = State
_X = None  # Cannot happen there: the methods below do not ask.
LATCH: Mapping[Event, tuple[State | None, ...]] = {
    # From:                NONE HELD UNCERTAIN DOUBTED
    Event.YES:            (_H, _H, _H, _H),
    Event.YES_TO_PAST:    (_D, _X, _D, _D),
    Event.SAYS_STOPPED:   (_H, _X, _H, _H),
    Event.SAYS_RELEASED:  (_X, _N, _U, _X),
    Event.MOVES:          (_N, _D, _D, _D),
    Event.ACCEPTED:       (_N, _N, _N, _N),
    Event.PEER_STOPPED:   (_H, _X, _H, _H),
    Event.PEER_UNDID:     (_X, _N, _X, _X),
    Event.MAY_BE_RELEASED: (_N, _D, _D, _D),
    Event.LEFT_SILENT:    (_X, _D, _X, _X),
    Event.SERVERS_SAME:   (_X, _H, _H, _D),
    Event.SERVERS_DIFFER: (_X, _U, _U, _D),
}  # fmt: skip


class Result(NamedTuple):
    """The result of one call: `answer` AWAITED stands for a yes of all servers."""

    answer: StopAnswer
    why: str = ""

    @property
    def is_yes(self) -> bool:
        """True if all servers said yes."""
        return self.answer is StopAnswer.AWAITED


class Facts(NamedTuple):
    """The facts about the robot that `tick` goes by."""

    moves: bool  # A goal runs, or a motion is reported.
    is_heard: bool
    is_offered: bool  # A node serves STOP.


class StopEffect(Enum):
    """A thing to be done now, with the turn of a STOP."""

    SEND = auto()  # Call the servers, again or for the first time.
    CANCEL_OWN = auto()  # Cancel the goals of this console from before the turn.
    CANCEL_ALL = auto()  # Cancel every goal of the tracked actions, once for each press of STOP.
    CANCEL_OTHERS = auto()  # Cancel the goals of other clients from before the turn.


class Stop(NamedTuple):
    """The open STOP and the last confirmed one."""

    open: OpenStop | None = None
    state: State = State.NONE  # What is known of the last confirmed STOP.
    doubt: str = ""  # Why that is uncertain; "" if it is not.
    held: float = -math.inf  # When it was last confirmed or reported.
    released: float | None = None  # When a release or a goal was last accepted; None before.
    is_not_obeyed: bool = False  # The robot moves, and has not stood since a STOP OBEYED ago.
    holders_have_ended: bool = False  # Every node that may hold it was run here, and has ended.
    awaited: int = 0  # The calls whose servers still have time to answer.
    seen_stopped: float = -math.inf  # When a report of the robot closed an open STOP.
    pressed_turn: int = 0  # Of the last call that was not a repeat.
    first_turn: int = 0  # Of the open STOP's first call; answers to earlier calls do not count.
    answered_turn: int = 0  # Of the last call whose answer is shown.
    is_given_up: bool = False  # The STOP that was opened last.
    last_turn: int = 0  # Of the last call; 0 if a release or a goal was accepted behind it.
    undone: float = -math.inf  # When a release was last reported, of whatever it was.
    undone_by: str = ""  # The console that released; "" for this one.
    past_turn: int = 0  # A call from before it may have been undone by the time of its yes.
    peer_turn: int = 0  # When another console reported its last STOP.
    answered: float = -math.inf  # When the last answer came, or was over.
    obeyed: tuple[int, float] | None = None  # The turn of the last STOP to be obeyed, since when.
    cancels: tuple[int, float] | None = None  # Goals from before the turn, from when on.
    all_cancelled: int = 0  # The `pressed_turn` for which CANCEL_ALL was done last.
    others_before: int = 0  # Goals of others from before it are cancelled; 0: none are.
    called: Servers = NOBODY  # All nodes to which the open STOP was sent.
    asked_servers: Servers = NOBODY  # They may be gone by the time of the yes.
    holders: Servers = NOBODY  # The nodes that confirmed it.
    is_held_here: bool = False  # Only nodes of this process have served it since.
    stopped_early: frozenset[str] = frozenset()  # Nodes that carried it out before they spun.
    servers_changed: float = -math.inf
    seen_servers: Servers = NOBODY  # By the last look.
    peer: str = ""  # The console that sent it; "" for this one.
    reports: bool = False  # The robot reports whether it is stopped.
    says_stopped: bool = False
    due: float | None = None  # Since when the robot should stand, until it has.
    moves_since: float | None = None

    @property
    def latch(self) -> Latch:
        """`state` as it is shown."""
        return Latch.UNCERTAIN if self.state is State.DOUBTED else Latch[self.state.name]

    @property
    def may_start(self) -> bool:
        """True if a goal, a program or the console may start: no STOP is lost behind it."""
        return self.open is None and self.state is State.NONE

    def lets_publish(self, *, is_void: bool) -> bool:
        """Return True if a message may leave that may move the robot; `is_void` behind a STOP."""
        return self.may_start and not is_void

    @property
    def is_held_by_nobody(self) -> bool:
        """True if all nodes that held the STOP ran here and have ended, and no STOP is open."""
        return self.open is None and self.holders_have_ended

    @property
    def has_reached_nobody(self) -> bool:
        """True if the open STOP was never sent, since no node serves it, and none holds."""
        is_unsent = self.open is not None and self.open.answer is StopAnswer.NOT_SENT
        return is_unsent and self.last_turn < self.first_turn and self.state is State.NONE

    @property
    def shown(self) -> tuple[object, ...]:
        """The part that the operator is shown."""
        return self.open, self.latch, self.doubt, self.holders_have_ended, self.is_not_obeyed

    def _fire(self, event: Event, doubt: str = "") -> Stop:
        """Make the step that LATCH tells. The first lasting doubt stays."""
        state = LATCH[event][list(State).index(self.state)]
        assert state is not None, (event, self.state)
        if state in (State.NONE, State.HELD):
            doubt = ""
        elif self.state is State.DOUBTED or not doubt:
            doubt = self.doubt
        after = self._replace(state=state, doubt=doubt)
        if state is not State.NONE:
            return after
        others = 0 if self.open is None else self.others_before
        return after._replace(
            due=None, is_not_obeyed=False, holders_have_ended=False, others_before=others
        )

    # The open STOP.

    def calling(self, turn: int, now: float, *, is_pressed: bool) -> Stop:
        """Begin a call: without an open STOP, open one."""
        after = self._replace(awaited=self.awaited + 1)
        if is_pressed or self.open is None:
            after = after._replace(pressed_turn=turn)
        if self.open is not None:
            return after
        opened = after._replace(
            open=OpenStop(now), first_turn=turn, is_given_up=False, called=NOBODY
        )
        return opened._cancel_before(turn, now)

    def leaving(self, turn: int, servers: Servers) -> Stop:
        """Take down that a call leaves now, and to which nodes."""
        called = self.called | servers
        return self._replace(last_turn=turn, asked_servers=servers, called=called)

    def answered_by(
        self,
        result: Result,
        turn: int,  # Of the call.
        now: float,
        turn_now: int,
        asked: Servers,  # To which it was sent.
        servers: Servers,  # Those of now; one that came since then has not got it.
        here: Collection[str],  # The nodes of this process whose code may still run.
        *,
        is_late: bool = False,  # The call was over already, without an answer.
    ) -> Stop:
        """Take the result of a call."""
        before = self._replace(answered=now, awaited=self.awaited - (not is_late))
        is_earlier = self.open is not None and turn < self.first_turn
        if result.is_yes:
            # A call that another node has got as well is not confirmed by an earlier one.
            more = dict(self.called).keys() & dict(servers).keys() - dict(asked).keys()
            if is_earlier or (self.open is not None and asked and more):
                return before
            held = before._confirmed(turn, now, turn_now, asked, here)
            return held.served_by(servers, here, now)
        if turn < self.first_turn:
            return before
        if result.answer is StopAnswer.UNCONFIRMED:
            before = before._expect_obeyed(turn, now)
        shown = before.open
        if shown is None:
            return before
        if turn <= self.answered_turn and shown.answer is not StopAnswer.NONE:
            return before  # A later call was answered already.
        if (result.answer, shown.answer) == (StopAnswer.NONE, StopAnswer.REFUSED):
            return before  # A server that refuses late would be told as silent each time.
        answer = OpenStop(shown.asked, result.answer, result.why)
        return before._replace(answered_turn=turn, open=answer)

    def _confirmed(
        self, turn: int, now: float, turn_now: int, asked: Servers, here: Collection[str]
    ) -> Stop:
        """Hold, and close the open STOP.

        Without an open one, the yes is to a STOP that was given up or is past: the robot may have
        carried it out just now.
        """
        if self.open is None and self.state is State.HELD:
            return self._expect_obeyed(turn, now)
        event, due = Event.YES, now if self.open is None else self.open.asked
        if self.open is None:
            event = Event.YES_TO_PAST if turn < self.past_turn else Event.YES
            turn = turn_now
        silent = sorted(dict(self.called).keys() - dict(asked).keys())
        held = self._expect_obeyed(turn, now)._hold(event, now, asked, here)
        held = held._replace(open=None, due=due)
        if held.state is not State.HELD or not silent:
            return held
        return held._fire(Event.LEFT_SILENT, f"{silent[0]} has left without an answer")

    def given_up(self) -> Stop:
        """Close the open STOP though it is not confirmed: nothing is sent for it any more."""
        return self._replace(open=None, others_before=0, is_given_up=True)

    def must_follow(self, turn: int) -> bool:
        """Return True if STOP must be sent again, now that a request from before it is answered."""
        return self._is_behind(turn) and not self.is_given_up

    def _is_behind(self, turn: int) -> bool:
        """Return True if a STOP left after a request: the robot may obey that request last."""
        return (self.open is not None and turn < self.first_turn) or turn <= self.last_turn

    def goal_accepted(self, turn: int, now: float) -> Stop:
        """Take the yes to a goal; one from before a STOP changes nothing."""
        is_past = self._is_behind(turn) or turn <= self.peer_turn
        return self if is_past else self._end(turn, now)

    def release_accepted(self, turn: int, now: float, turn_now: int) -> Stop:
        """Take the yes to a release; the robot may carry out one from before a STOP last.

        Then no call so far confirms the STOP, which must be sent again.
        """
        before = self._replace(undone=now, undone_by="")
        if not self._is_behind(turn) and turn > self.peer_turn:
            return before._end(turn, now)
        after = before._unconfirmed_before(turn_now)
        return after._fire(Event.MAY_BE_RELEASED, "a release from before it was answered behind it")

    def _unconfirmed_before(self, turn: int) -> Stop:
        """Have calls from before a turn confirm nothing any more; an open STOP is due again."""
        after = self._replace(past_turn=turn)
        if self.open is None:
            return after
        return after._replace(first_turn=turn, open=OpenStop(self.open.asked))

    def is_wanted(self, turn: int) -> bool:
        """Return False for a call whose STOP was given up, or released, before it has left."""
        return self.open is not None or not (self.is_given_up or turn < self.past_turn)

    def _end(self, turn: int, now: float) -> Stop:
        after = self._fire(Event.ACCEPTED)
        return after._replace(
            last_turn=0,
            past_turn=max(self.past_turn, turn),
            others_before=0,
            released=now,
            open=None,
        )

    # The confirmed STOP.

    def _hold(
        self, event: Event, now: float, servers: Servers, here: Collection[str], peer: str = ""
    ) -> Stop:
        # If no node was kept, any later one would pass for those that confirmed it.
        holders = servers or self.asked_servers
        # A last report of nodes that have ended meanwhile does not put them elsewhere.
        was_here = self.is_held_here and self.holders == holders
        return self._fire(event, "it was answered behind a release")._replace(
            held=now,
            peer=peer,
            holders=holders,
            is_held_here=bool(holders) and (was_here or _are_here(holders, here)),
            # Of a STOP that was open when they started, they are holders.
            stopped_early=self.stopped_early if event is Event.YES else frozenset(),
            holders_have_ended=False,
            is_given_up=self.is_given_up and event is not Event.YES,
        )

    def carried_out_early(self, node: str) -> Stop:
        """Count a node that carried the STOP out before it spins as one of its holders."""
        return self._replace(stopped_early=self.stopped_early | {node})

    def served_by(self, servers: Servers, here: Collection[str], now: float) -> Stop:
        """Compare the nodes that serve STOP now with those that hold it."""
        if self.state is State.NONE:
            return self
        before = dict(self.holders)
        new = frozenset(pair for pair in servers if pair not in self.holders)
        is_held_here = self.is_held_here and _are_here(new, here)
        may_return = before.keys() & {*here}
        after = self._replace(
            is_held_here=is_held_here,
            holders_have_ended=is_held_here and not servers and not may_return,
            seen_servers=servers,
        )
        now_served = dict(servers)
        early = {node: now_served[node] for node in self.stopped_early if node in now_served}
        expected = {**before, **early}
        if not before or now_served == expected:
            left = self.stopped_early.difference(now_served)
            return after._replace(holders=servers, stopped_early=left)._fire(Event.SERVERS_SAME)
        others = sorted(node for node, ids in now_served.items() if ids != expected.get(node))
        if others:
            if servers != self.seen_servers:
                after = after._replace(servers_changed=now)
            return after._fire(Event.SERVERS_DIFFER, f"{others[0]} was started since")
        gone = min(expected.keys() - now_served.keys())
        return after._fire(Event.SERVERS_DIFFER, f"{gone} has left")

    def stopped_elsewhere(
        self, console: str, turn: int, now: float, servers: Servers, here: Collection[str]
    ) -> Stop:
        """Take another console's report that the robot confirmed its STOP."""
        after = self._expect_obeyed(turn, now)
        if self.reports:
            return after  # The robot's own reports tell.
        after = after._replace(peer_turn=turn, due=now)
        if self.state is State.HELD:
            return after
        # The report takes some time: what another console released just now may have been later.
        is_past = now - self.undone < SETTLED and self.undone_by != console
        event = Event.YES_TO_PAST if is_past else Event.PEER_STOPPED
        return after._hold(event, now, servers, here, console)

    def released_elsewhere(self, console: str, turn: int, now: float) -> Stop:
        """Take another console's report that the robot released a STOP.

        The robot may have done that last: earlier calls of the open STOP confirm it no more.
        """
        after = self._replace(undone=now, undone_by=console)._unconfirmed_before(turn)
        is_held = self.state is State.HELD
        if is_held and self.says_stopped and not self.holders_have_ended:
            return after  # The robot's own reports tell: this one may be older than its STOP.
        if is_held and self.peer == console:
            return after._fire(Event.PEER_UNDID)
        return after._fire(Event.MAY_BE_RELEASED, f"console {console} released it")

    def needs_servers(self, motion: Motion) -> bool:
        """Return True if `moved` needs to know who serves STOP now, which takes time to ask."""
        if self.state is State.HELD:
            return self.says_stopped and motion.stopped is False
        return bool(motion.stopped)

    def moved(self, motion: Motion, now: float, servers: Servers, here: Collection[str]) -> Stop:
        """Take a report of the only node that publishes it; `servers` only if `needs_servers`."""
        after = self
        # The report may be a last one of nodes that were replaced.
        is_settled = self.state is State.NONE or now - self.servers_changed >= SETTLED
        has_left = self.last_turn >= self.first_turn
        if self.open is not None and motion.stopped and is_settled and has_left:
            after = after._expect_obeyed(self.first_turn, now)
            after = after._replace(seen_stopped=now, due=self.open.asked, open=None)
        is_released = self.says_stopped and motion.stopped is False
        after = after._replace(
            reports=motion.stopped is not None, says_stopped=bool(motion.stopped)
        )
        if motion.stopped and self.state is not State.HELD and is_settled:
            after = after._hold(Event.SAYS_STOPPED, now, servers, here)
        elif is_released and self.state is State.HELD:
            # A node that was started anew may report it.
            after = after.served_by(servers, here, now)._fire(Event.SAYS_RELEASED)
            after = after._replace(past_turn=max(after.past_turn, after.last_turn))
        return after._judged_by(motion, is_released=is_released)

    def _judged_by(self, motion: Motion, *, is_released: bool) -> Stop:
        """Check whether a motion disobeys the STOP, or makes it uncertain."""
        now, due, since = motion.received, self.due, self.moves_since
        if is_released or not motion.moving:
            due = None
        elif self.says_stopped and due is None:  # Something else than a console stopped it.
            due = now
        is_not_obeyed = due is not None and now is not None and now - due >= OBEYED
        after = self._replace(due=due, is_not_obeyed=is_not_obeyed)
        if not motion.moving or now is None:
            return after._replace(moves_since=None)
        if since is None:
            return after._replace(moves_since=now)
        if now - since >= OBEYED and due is None and not self.reports:
            return after._fire(Event.MOVES, "the robot moves")
        return after

    # What follows.

    def _expect_obeyed(self, turn: int, now: float) -> Stop:
        """Expect that goals from before a STOP end, unless that is known of a later one."""
        after = self
        if self.obeyed is None or turn >= self.obeyed[0]:
            after = self._replace(obeyed=(turn, now))
        return after._cancel_before(turn, now)

    def _cancel_before(self, turn: int, now: float) -> Stop:
        """Have the goals from before a STOP cancelled in CANCEL_AFTER, or with older ones."""
        if self.cancels is None:
            return self._replace(cancels=(turn, now + CANCEL_AFTER))
        known, due = self.cancels
        if turn <= known:
            return self
        return self._replace(cancels=(turn, due if due > now else now + CANCEL_AFTER))

    def must_be_obeyed(self, now: float) -> int:
        """Return the turn of the last STOP that must be obeyed by now; 0 if there is none."""
        if self.obeyed is None or now - self.obeyed[1] < OBEYED:
            return 0
        return self.obeyed[0]

    def tick(self, now: float, facts: Facts) -> tuple[Stop, list[tuple[StopEffect, int]]]:
        """Return what is to be done at this moment. Call it several times a second."""
        after, todo = self, []
        if self.cancels is not None and now >= self.cancels[1]:
            todo.append((StopEffect.CANCEL_OWN, self.cancels[0]))
        if self._must_cancel_others(now, facts):
            turn = self.pressed_turn
            after = self._replace(all_cancelled=turn, others_before=turn)
            todo.append((StopEffect.CANCEL_ALL, turn))
        elif self.others_before:
            todo.append((StopEffect.CANCEL_OTHERS, self.others_before))
        if self._must_send(now, facts):
            todo.append((StopEffect.SEND, self.first_turn))
        return after, todo

    def _must_cancel_others(self, now: float, facts: Facts) -> bool:
        stop = self.open
        if stop is None or not facts.moves or self.all_cancelled == self.pressed_turn:
            return False
        return now - stop.asked >= CANCEL_OTHERS_AFTER

    def _must_send(self, now: float, facts: Facts) -> bool:
        """Return True if the open STOP is due again; never while a call is awaited."""
        if self.open is None or self.awaited:
            return False
        is_unsent = self.open.answer is StopAnswer.NOT_SENT
        if not (facts.is_offered if is_unsent else facts.is_heard):
            return False
        if self.open.answer is StopAnswer.UNCONFIRMED and not facts.moves:
            return False  # It can never be a yes; the motion tells.
        return now - self.answered >= REPEAT_AFTER


def _are_here(nodes: Servers, here: Collection[str]) -> bool:
    """Return True if this process runs all these nodes, and no other node has their names."""
    return all(node in here and len(ids) == 1 for node, ids in nodes)
