"""The poll each second: of the graph, and of all that depends on what is there. ROS thread only."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from archo_tui.robot.clients import CLIENT, CONSOLE
from archo_tui.robot.parts import Parts
from archo_tui.robot_file import check

POLL_PERIOD = 1.0  # Seconds between two polls: rclpy has no event for a change of the graph.
_EARLY = 0.05  # Seconds by which a poll may be early.

SETTLED = 5.0  # Seconds without a new node after which the graph counts as discovered.
NAMED = 3  # Nodes that one line names; it counts the others.


class Poller:
    """The polling of the graph, and of all that depends on what is there."""

    def __init__(self, robot: Parts) -> None:
        self._robot = robot
        self._next = float("-inf")  # When the next poll is due, in monotonic seconds.
        self._arrivals = Arrivals(robot.clock.monotonic())
        self._consoles: set[str] | None = None  # The other consoles; None before the first poll.
        self._mismatches: frozenset[str] = frozenset()  # Those that were reported.
        robot.node.create_steady_timer(POLL_PERIOD, self._poll_if_due)

    def _poll_if_due(self) -> None:
        """Poll the graph, unless a rest after the last poll is due, as on a very large graph."""
        if self._robot.clock.monotonic() >= self._next:
            self.poll()

    def poll(self) -> None:
        """Poll the graph now, and bring all that depends on it up to date."""
        robot, graph, reporter = self._robot, self._robot.graph, self._robot.reporter
        begun = robot.clock.monotonic()
        changed = graph.poll()
        self._next = begun + graph.rest - _EARLY
        robot.stop_sender.check_holders()
        robot.changes.author = CONSOLE if graph.silent_consoles else CLIENT
        self._report_consoles()
        now = robot.clock.monotonic()
        for text in self._arrivals.compare(graph.names, robot.own_nodes(), now):
            reporter.warn(text)
        robot.telemetry.resubscribe()
        robot.frames.update()
        robot.lifecycles.poll(graph.listed.services)
        for text in robot.changes.take_due(robot.clock.monotonic()):
            reporter.note("PEER", text)
        faults = self._find_faults()
        if changed or faults != robot.faults or robot.snapshots.is_stale:
            robot.faults = faults
            robot.snapshots.send_soon()
        self._report_mismatches()
        robot.parameters.poll(graph.node_counts, graph.services)
        self._forget_clocks()

    def _find_faults(self) -> dict[str, str]:
        robot = self._robot
        faults = {**robot.telemetry.faults, **robot.checks.misfits()}
        for kind in robot.file.goals:
            if nodes := robot.graph.duplicates.get(kind.action):
                faults[kind.action] = check.duplicate_servers(kind.action, nodes)
        return faults

    def _report_consoles(self) -> None:
        """Add an event for each console that came or left; none for those of the first poll."""
        now = set(self._robot.graph.consoles)
        known = now if self._consoles is None else self._consoles
        for verb, names in (("came", now - known), ("left", known - now)):
            for name in sorted(names):
                self._robot.reporter.note("PEER", f"console {name} {verb}")
        self._consoles = now

    def _report_mismatches(self) -> None:
        mismatches = [text for found in self._robot.graph.listed.all for text in found.mismatches]
        for text in mismatches:
            if text not in self._mismatches:
                self._robot.reporter.warn(text)
        self._mismatches = frozenset(mismatches)

    def _forget_clocks(self) -> None:
        """Forget the offsets of nodes and topics that left; in simulated time of all topics."""
        graph, offsets = self._robot.graph, self._robot.clock_offsets
        gone = [
            source
            for source in offsets.large
            if source not in graph.names and (graph.has_clock or not graph.is_published(source))
        ]
        if gone:
            offsets.forget(gone)
            self._robot.snapshots.send_soon()


class Arrivals:
    """A comparison of the nodes at each poll of the graph with those at the poll before.

    No line is made for a node that comes while the graph is first discovered, nor for one that this
    process ever hosted: its host reports that node.
    """

    def __init__(self, now: float) -> None:
        self._known: set[str] = set()
        self._own: set[str] = set()
        self._settles = now + SETTLED

    def compare(self, names: Iterable[str], own: Collection[str], now: float) -> list[str]:
        """Return `node NAME left` and `node NAME came` for each that did since the last call."""
        found = set(names)
        self._own.update(own)
        came, left = found - self._known, self._known - found
        self._known = found
        if now < self._settles:
            self._settles = now + SETTLED if came else self._settles
            came = set()
        return [*_lines("left", left - self._own), *_lines("came", came - self._own)]


def _lines(verb: str, names: Collection[str]) -> list[str]:
    """Return a line for each node, or one for all if there are more than NAMED."""
    nodes = [name.lstrip("/") for name in sorted(names)]
    if len(nodes) <= NAMED:
        return [f"node {name} {verb}" for name in nodes]
    more = len(nodes) - NAMED
    return [f"{len(nodes)} nodes {verb}: {', '.join(nodes[:NAMED])} and {more} more"]
