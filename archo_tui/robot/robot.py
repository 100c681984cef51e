"""The robot as its front ends see it: snapshots to show, and requests to operate it."""

from __future__ import annotations

# ruff: noqa: E402
import contextlib
from collections.abc import Collection, Iterable

from archo_tui.ros import engine

engine.ensure()

from archo_tui.robot.clients import CLIENT, CONSOLE, YOU, current_requester
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests import commands
from archo_tui.robot.requests import nodes as node_requests
from archo_tui.robot.requests import publish as publish_requests
from archo_tui.robot.requests import topics as topic_requests
from archo_tui.robot.runtime import Receiver
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.readings import Diagnostic
from archo_tui.robot_file import check

POLL_PERIOD = 1.0  # Seconds between two polls: rclpy has no event for a change of the graph.
_EARLY = 0.05  # Seconds by which a poll may be early.

SETTLED = 5.0  # Seconds without a new node after which the graph counts as discovered.
NAMED = 3  # Nodes that one line names; it counts the others.


class Robot(Parts):
    """The robot: its parts, its newest snapshot, and the requests that operate it.

    The end of each request that sends or changes something is reported: as an event, in the ROS
    log, and to the robot's other consoles. Nothing is received before `start`.
    """

    _poller: Poller

    emergency_stop = commands.emergency_stop
    release_emergency_stop = commands.release_emergency_stop
    give_up_stop = commands.give_up_stop
    early_stop_request = commands.early_stop_request
    on_early_stop = commands.on_early_stop

    send = commands.send
    cancel = commands.cancel
    cancel_all = commands.cancel_all
    stop_sending_goals = commands.stop_sending_goals
    allow_sending_goals = commands.allow_sending_goals
    end_goals_of_node = commands.end_goals_of_node

    command = commands.command
    call = commands.call

    set_parameters = node_requests.set_parameters
    on_parameters_restored = node_requests.on_parameters_restored
    describe = node_requests.describe
    topic_info = node_requests.topic_info
    types_anywhere = node_requests.types_anywhere
    log_level = node_requests.log_level
    set_log_level = node_requests.set_log_level
    change_lifecycle = node_requests.change_lifecycle
    lifecycle_transitions = node_requests.lifecycle_transitions

    publish = publish_requests.publish
    end_publications = publish_requests.end_publications
    end_publications_now = publish_requests.end_publications_now

    form = topic_requests.form
    inspect = topic_requests.inspect
    resubscribe_if_needed = topic_requests.resubscribe_if_needed
    follow_topic = topic_requests.follow_topic
    take_sightings = topic_requests.take_sightings
    listen_to_frames = topic_requests.listen_to_frames

    def start(self) -> None:
        """Start the ROS thread: poll the graph at once, and receive messages from now on."""
        self._poller = Poller(self)
        self.look_at_graph()
        self.thread.start()

    def look_at_graph(self) -> None:
        """Poll the graph at once, since nodes have just been made here. Any thread."""
        self.thread.submit(self._poller.poll)

    def subscribe(self, receiver: Receiver) -> None:
        """Call a function with the newest snapshot now, and with each later one on this loop."""
        self.snapshots.open(receiver)
        receiver(self.snapshot)

    def close(self) -> None:
        """Deliver no more snapshots, end the ROS thread, and leave the graph."""
        self.snapshots.close()
        if self.thread.stop():
            self.goals.close()

    def note(
        self,
        level: str,
        source: str,
        text: str,
        command: str = "",
        audit_record: AuditRecord | None = None,
    ) -> None:
        """Add an event to the log of this console; nobody else gets it. Any thread.

        In place of the level and source of `YOU`, those of the present requester are taken.
        """
        if (level, source) == (YOU.level, YOU.source):
            level, source = current_requester().level, current_requester().source
        event = Event(self.clock.now(), level, source, text, command, audit_record=audit_record)
        self.thread.submit(lambda: self.reporter.add(event))

    def forget_diagnostic(self, part: Diagnostic) -> None:
        """Drop a part of the diagnostics, which is there again once it reports. Any thread."""

        def forget() -> None:
            self.telemetry.diagnostics.forget(part.key)
            self.snapshots.send_soon()

        self.thread.submit(forget)
        self.note(YOU.level, YOU.source, f"diagnostics: {part.part} was forgotten")

    async def wait_for_events(self) -> None:
        """Wait, at most 2 s, until a snapshot with all events that were noted before is sent."""

        async def there() -> None:
            self.snapshots.send()

        with contextlib.suppress(TimeoutError):  # The thread is busy: go on without them.
            await self.thread.run(there, DEADLINE)


# What is done each second. ROS thread only.


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
        for text in self._arrivals.compare(graph.nodes, robot.own_nodes(), now):
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
        robot.parameters.poll(graph.nodes, graph.services)
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
            if source not in graph.nodes and (graph.has_clock or not graph.is_published(source))
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
