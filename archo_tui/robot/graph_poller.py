"""The polling of the graph, each second, and the reports of what changed on it."""

from __future__ import annotations

from collections.abc import Callable, Collection

from archo_tui.clock import Clock
from archo_tui.robot.arrivals import Arrivals
from archo_tui.robot.events import Reporter
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.graph.lifecycle import Lifecycles
from archo_tui.robot.graph.parameters import Parameters
from archo_tui.robot.other_clients import CLIENT, CONSOLE, UnexplainedChanges
from archo_tui.robot.readings.subscriptions import RecordedTopics
from archo_tui.robot.readings.telemetry import Telemetry
from archo_tui.robot.snapshot_sender import SnapshotSender
from archo_tui.robot.stop_sender import StopSender
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import RobotFile

POLL_PERIOD = 1.0  # Seconds between two polls: rclpy has no event for a change of the graph.
_EARLY = 0.05  # Seconds by which a poll may be early.


class GraphPoller:
    """The polling of the graph, and of all that depends on what is there. ROS thread only."""

    def __init__(
        self,
        file: RobotFile,
        clock: Clock,
        graph: Graph,
        checks: InterfaceChecks,
        telemetry: Telemetry,
        recorded_topics: RecordedTopics,
        lifecycles: Lifecycles,
        parameters: Parameters,
        stop: StopSender,
        changes: UnexplainedChanges,
        reporter: Reporter,
        snapshots: SnapshotSender,
        own_nodes: Callable[[], Collection[str]],
    ) -> None:
        self._file, self._clock, self._graph = file, clock, graph
        self._checks, self._parameters, self._lifecycles = checks, parameters, lifecycles
        self._telemetry, self._recorded_topics = telemetry, recorded_topics
        self._stop_sender, self._changes = stop, changes
        self._reporter, self._snapshots, self._own_nodes = reporter, snapshots, own_nodes
        self._next = float("-inf")  # When the next poll is due, in monotonic seconds.
        self._arrivals = Arrivals(clock.monotonic())
        self._consoles: set[str] | None = None  # The other consoles; None before the first poll.
        self._mismatches: frozenset[str] = frozenset()  # Those that were reported.
        # Why a topic, a service or an action is not used, by its name in the robot file.
        self.faults: dict[str, str] = {}

    def poll_if_due(self) -> None:
        """Poll the graph, unless a rest after the last poll is due; call this each second.

        The rest is longer than a second only on a very large graph.
        """
        if self._clock.monotonic() >= self._next:
            self.poll()

    def poll(self) -> None:
        """Poll the graph now, and bring all that depends on it up to date.

        Topics are subscribed to, parameters and states of new nodes requested, a confirmed STOP is
        compared with its nodes, and `faults` is renewed.
        """
        begun = self._clock.monotonic()
        changed = self._graph.poll()
        self._next = begun + self._graph.rest - _EARLY
        self._stop_sender.check_holders()
        self._changes.author = CONSOLE if self._graph.silent_consoles else CLIENT
        self._report_consoles()
        for text in self._arrivals.compare(
            self._graph.names, self._own_nodes(), self._clock.monotonic()
        ):
            self._reporter.warn(text)
        self._telemetry.resubscribe()
        self._recorded_topics.subscribe()
        self._lifecycles.poll(self._graph.served_services)
        for text in self._changes.take_due(self._clock.monotonic()):
            self._reporter.note("PEER", text)
        faults = self._find_faults()
        if changed or faults != self.faults or self._snapshots.is_stale:
            self.faults = faults
            self._snapshots.send_soon()
        self._report_mismatches()
        self._parameters.poll(self._graph.node_counts, self._graph.services)

    def _find_faults(self) -> dict[str, str]:
        faults = {**self._telemetry.faults, **self._checks.misfits()}
        for kind in self._file.goals:
            if kind.action in self._graph.duplicates:
                nodes = self._graph.duplicates[kind.action]
                faults[kind.action] = mismatch.duplicate_servers(kind.action, nodes)
        return faults

    def _report_consoles(self) -> None:
        """Add an event for each console that came or left; none for those of the first poll."""
        now = set(self._graph.consoles)
        if self._consoles is not None:
            for name in sorted(now - self._consoles):
                self._reporter.note("PEER", f"console {name} came")
            for name in sorted(self._consoles - now):
                self._reporter.note("PEER", f"console {name} left")
        self._consoles = now

    def _report_mismatches(self) -> None:
        """Add a warning for each mismatch of a publisher and a subscription that is new."""
        mismatches = [text for resource in self._graph.resources for text in resource.mismatches]
        for text in mismatches:
            if text not in self._mismatches:
                self._reporter.warn(text)
        self._mismatches = frozenset(mismatches)
