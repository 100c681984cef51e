"""The memory of a confirmed STOP until it is released. ROS thread only.

The rules, each of which is checked in one method:

1. A confirmed STOP holds until a release or a goal is accepted behind it: `hold`, `release`.
2. It is certain only while the nodes that confirmed it are there, and none of them was restarted:
   `check_holders`. A node that starts here and carries it out counts as one.
3. A robot that never reports whether it is stopped makes it uncertain by moving (`on_motion`), and
   so does another console that releases it (`on_released_elsewhere`).
4. A robot that reports it decides by its reports: `on_motion`.
5. A robot that moves on behind a confirmed STOP does not obey: `is_not_obeyed`.
6. If every node that confirmed it was run by this process, and all of them have ended and left,
   nothing holds it any more: `check_holders`. A release then forgets it, since no node could
   confirm one. A node elsewhere that has served it since may hold it, too, however it got it.

Nothing is sent from here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

from archo_tui.clock import Clock
from archo_tui.robot.graph import Graph
from archo_tui.robot.state import Latch, Motion

OBEYED = 1.0  # Seconds after a confirmed STOP in which the robot comes to rest.
_SETTLED = 1.0  # Seconds after a change of nodes in which reports of the old ones still come.

# The ids of each node, by its full name, as `Graph.holders` returns them.
Ids = dict[str, frozenset[bytes]]


class StopLatch:
    """The memory of the last confirmed STOP.

    Attributes:
        state: The state of that STOP.
        doubt: Why the state is UNCERTAIN; "" in another state.
        time: Unix time at which that STOP was confirmed; 0 before the first.
        released: Monotonic time at which `release` was last called; None if it never was.
        other_turn: The turn in which another console reported its last STOP; 0 if none did, or the
            robot reports its stops.
        sent_to: The nodes to which this console sent its last STOP, set by the sender.
        is_not_obeyed: True if by the last message about the motion the robot moves, and has not
            stood since a confirmed STOP left at least OBEYED before.
        holders_have_ended: True if nothing holds the STOP any more (rule 6), by the last
            `check_holders`.
    """

    def __init__(
        self,
        service: str,
        clock: Clock,
        graph: Graph,
        unended_nodes: Callable[[], Collection[str]],
        on_change: Callable[[], None],
    ) -> None:
        """Create the memory, before any STOP.

        Args:
            service: The STOP's service as in the robot file; empty: the robot has none.
            clock: The console's clock.
            graph: Tells which nodes serve the STOP.
            unended_nodes: Returns the full names of the nodes of this process whose code may
                still run. A program that is suspended leaves the graph, and returns.
            on_change: Called when `state`, `doubt` or `holders_have_ended` has changed; not by
                `hold` and `release`, nor when `on_motion` makes the STOP hold or ends it.
        """
        self._service, self._clock, self._graph = service, clock, graph
        self._unended_nodes, self._on_change = unended_nodes, on_change
        self.state = Latch.NONE
        self.doubt = ""
        self.time = 0.0
        self.released: float | None = None
        self.other_turn = 0
        self.sent_to: Ids = {}
        self.is_not_obeyed = False
        self.holders_have_ended = False
        self._lasting_doubt = ""  # A doubt that no return of a node ends (rule 3), or "".
        self._other_console = ""  # The console that sent the STOP; "" for this one.
        self._holders: Ids = {}  # The nodes that confirmed it.
        self._is_held_here = False  # True while only nodes of this process have served it.
        self._stopped_early: set[str] = set()  # Nodes that carried it out before they spun.
        self._nodes_changed = 0.0  # Monotonic time at which a new node last served it.
        self._reports_stop = False  # True if the robot reports whether it is stopped.
        self._reported = False  # True if it last reported that it is stopped.
        self._sent: float | None = None  # When the STOP left, while the robot has not stood since.
        self._moves_since: float | None = None  # Monotonic time since when it reports a motion.

    def hold(self, other_console: str = "") -> None:
        """Record that the robot has just confirmed a STOP, and which nodes did (rule 1).

        The state is HELD, and earlier doubts are forgotten. The nodes are those that serve STOP
        now; if none does, those of `sent_to`. `on_change` is not called.

        Args:
            other_console: The console that sent the STOP; "" for this one.
        """
        self.state, self.doubt, self._lasting_doubt = Latch.HELD, "", ""
        self._other_console = other_console
        self.time = self._clock.now()
        # The nodes may have left by now. If none was kept, any later one would pass for them.
        before, self._holders = self._holders, self._graph.holders(self._service) or self.sent_to
        self._stopped_early.clear()
        # A last report of nodes that have ended meanwhile does not put them elsewhere.
        was_here = self._is_held_here and self._holders == before
        self._is_held_here = bool(self._holders) and (was_here or self._are_run_here(self._holders))
        self.holders_have_ended = False

    def release(self) -> None:
        """Forget the STOP, since a release or a goal was accepted behind it (rule 1).

        `released` becomes the present time, also if there was no STOP. `on_change` is not called.
        """
        self._end()
        self.released = self._clock.monotonic()

    def _end(self) -> None:
        self.state, self.doubt, self._lasting_doubt = Latch.NONE, "", ""
        self.holders_have_ended = self.is_not_obeyed = False
        self._sent = None

    def expect_standstill(self, sent: float) -> None:
        """Expect the robot to stand at least once after a STOP (rule 5).

        If it moves OBEYED later and has not stood in between, it `is_not_obeyed`.

        Args:
            sent: Monotonic time at which the STOP left.
        """
        self._sent = sent

    def add_stopped_early(self, node: str) -> None:
        """Count a starting node of this process as a holder of the STOP, and check the holders.

        Args:
            node: The full name of the node, which has carried out the STOP before it spins.
        """
        self._stopped_early.add(node)
        self.check_holders()

    def on_stopped_elsewhere(self, console: str, turn: int) -> None:
        """Record that another console reports that the robot confirmed its STOP.

        That STOP then holds as one of this console does; of one that holds already, the nodes and
        `time` stay. Nothing is done for a robot that reports its stops (rule 4).

        Args:
            console: The other console.
            turn: A number between those of this console's earlier and later requests.
        """
        if self._reports_stop:
            return
        self.other_turn, self._sent = turn, self._clock.monotonic()
        if self.state is not Latch.HELD:
            self.hold(console)
            self._on_change()

    def on_released_elsewhere(self, console: str) -> None:
        """Record that another console reports that it released the STOP.

        If that console sent the STOP and it is certain, or if the robot reports its stops, the STOP
        is over. Otherwise a STOP that holds is uncertain from now on, whatever its nodes do
        (rule 3).
        """
        if self._reports_stop or (self._other_console == console and self.state is Latch.HELD):
            self._end()
            self._on_change()
        else:
            self._cast_lasting_doubt(f"console {console} released it")

    def _cast_lasting_doubt(self, why: str) -> None:
        """Make a STOP uncertain, whatever its nodes do later (rule 3); keep the first reason."""
        if self.state is not Latch.NONE and not self._lasting_doubt:
            self.state, self.doubt, self._lasting_doubt = Latch.UNCERTAIN, why, why
            self._on_change()

    def check_holders(self) -> None:
        """Compare the nodes that serve STOP now with those that confirmed it (rules 2 and 6).

        The STOP becomes certain or uncertain accordingly, unless rule 3 has made it uncertain, and
        `holders_have_ended` is updated. Without a confirmed STOP nothing is done.
        """
        if self.state is Latch.NONE or not self._service:
            return
        before = (self.state, self.doubt, self.holders_have_ended)
        now = self._graph.holders(self._service)
        new = {node: ids for node, ids in now.items() if ids != self._holders.get(node)}
        self._is_held_here = self._is_held_here and self._are_run_here(new)
        may_return = self._holders.keys() & {*self._unended_nodes()}
        self.holders_have_ended = self._is_held_here and not now and not may_return
        if not self._lasting_doubt:
            self._compare_holders(now)
        if before != (self.state, self.doubt, self.holders_have_ended):
            self._on_change()

    def _are_run_here(self, nodes: Ids) -> bool:
        """Return True if this process runs all these nodes, and no other node has their names."""
        return nodes.keys() <= {*self._unended_nodes()} and all(
            len(ids) == 1 for ids in nodes.values()
        )

    def _compare_holders(self, now: Ids) -> None:
        """Make the STOP certain or uncertain (rule 2).

        It is certain if the nodes that serve it now are those that confirmed it, not restarted, or
        nodes that carried it out before they spun. Without known nodes, those of now are taken.

        Args:
            now: The nodes that serve it now.
        """
        stopped_early = {node: ids for node, ids in now.items() if node in self._stopped_early}
        expected = {**self._holders, **stopped_early}
        if not self._holders or now == expected:
            self._holders, self.state, self.doubt = now, Latch.HELD, ""
            self._stopped_early -= now.keys()
        else:
            self.state = Latch.UNCERTAIN
            gone = sorted(expected.keys() - now.keys())
            new = sorted(node for node, ids in now.items() if ids != expected.get(node))
            self.doubt = f"{new[0]} was started since" if new else f"{gone[0]} has left"
            if new:
                self._nodes_changed = self._clock.monotonic()

    def on_motion(self, motion: Motion) -> None:
        """Record a message about the robot's motion (rules 3, 4 and 5).

        A report that the robot is stopped makes a STOP hold, even if none was sent; an UNCERTAIN
        one does not hold again until a second after its nodes changed. The first report that the
        robot is no longer stopped ends a STOP that is certain.

        Args:
            motion: The message. Pass it only if a single node publishes the motion.
        """
        self._reports_stop = motion.stopped is not None
        is_released = self._reported and motion.stopped is False
        self._reported = bool(motion.stopped)
        if motion.stopped:
            is_settled = self._clock.monotonic() - self._nodes_changed >= _SETTLED
            if self.state is Latch.NONE or (self.state is Latch.UNCERTAIN and is_settled):
                self.hold()
        elif is_released and self.state is Latch.HELD:
            self.check_holders()  # A node that was started anew may report it.
            if self.state is Latch.HELD:
                self._end()
        self._check_motion(motion, is_released=is_released)

    def _check_motion(self, motion: Motion, *, is_released: bool) -> None:
        """Check whether a motion disobeys the STOP (rule 5), or makes it uncertain (rule 3)."""
        now = motion.received
        if is_released or not motion.moving:
            self._sent = None
        elif self._reported and self._sent is None:  # Something else than this console stopped it.
            self._sent = now
        sent = self._sent
        self.is_not_obeyed = sent is not None and now is not None and now - sent >= OBEYED
        if not motion.moving or now is None:
            self._moves_since = None
        elif self._moves_since is None:
            self._moves_since = now
        elif now - self._moves_since >= OBEYED and sent is None and not self._reports_stop:
            self._cast_lasting_doubt("the robot moves")
