"""The work that nobody requests: the handling of what is received, and the poll each second.

All of it runs on the ROS thread.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui.robot.clients.changes import CLIENT, CONSOLE
from archo_tui.robot.clients.consoles import author
from archo_tui.robot.graph.parameter_values import is_secret
from archo_tui.robot.outcome import Code
from archo_tui.robot.parts import Parts
from archo_tui.robot.readings.subscriptions import News
from archo_tui.robot.requests.goals import verb_of, way_length
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import ROUTINE, Event
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.graph import MASK, level_word, logger_node
from archo_tui.robot_file import check


def on_reading(robot: Parts, topic: str, news: News) -> None:
    """Count a message with a reading, and have a snapshot sent if a value changed."""
    robot.graph.on_topic_message(topic, robot.clock.monotonic())
    if robot.file.motion is not None and topic == robot.file.motion.topic:
        _on_motion(robot, topic)
    robot.snapshots.is_stale = True
    if news is News.WORDS:
        robot.snapshots.send_soon()
    elif news is News.NUMBERS:
        robot.snapshots.send_later()


def _on_motion(robot: Parts, topic: str) -> None:
    robot.goals.on_robot_message()
    if topic in robot.graph.publishers:  # The readings of several robots come mixed.
        return
    stop, motion = robot.file.stop, robot.telemetry.motion
    # One of several robots tells nothing about the others.
    if stop is not None and stop.service not in robot.graph.duplicates:
        robot.stop_sender.on_motion(motion)
    robot.changes.on_motion(motion, robot.clock.monotonic())


def on_transforms(robot: Parts) -> None:
    """Have the transforms shown that were received, in the snapshot of each second."""
    robot.snapshots.is_stale = True


def on_log(robot: Parts, message: Log) -> None:
    """Add a line on /rosout to the events, unless it is another robot's, or comes as a record."""
    node = logger_node(message.name)
    console, now = author(node), robot.clock.now()
    if console:
        # Every other console sends the same line in its audit record.
        if console in robot.graph.silent_consoles:
            robot.reporter.add(Event(now, "PEER", console, message.msg))
        return
    if not robot.graph.is_ours(node):
        return  # It is another robot's.
    if node not in robot.own_nodes():
        _compare_clocks(robot, node, message.stamp)
    for kind in robot.file.goals:
        servers = robot.graph.servers.get(kind.action, ())
        if kind.refusals and node in servers and message.msg.startswith(kind.refusals):
            robot.goals.on_refusal_log(message.msg.removeprefix(kind.refusals))
    robot.graph.on_log_line(node, robot.clock.monotonic())
    # The robot's clock may differ, and the events are in order: so not by the stamp.
    level = level_word(message.level)
    event = robot.reporter.add_log_line(Event(now, level, message.name, message.msg))
    if level in ROUTINE or event.count > 1:
        robot.snapshots.send_later()
    else:
        robot.snapshots.send_soon()


def on_stamp(robot: Parts, topic: str, stamp: Any) -> None:
    """Compare the stamp in a header of a topic (full name) with this computer's clock."""
    # A node of this process shares its clock, and simulated time is no time of day.
    if not (robot.own_nodes() or robot.graph.has_clock):
        _compare_clocks(robot, topic, stamp)


def _compare_clocks(robot: Parts, source: str, stamp: Any) -> None:
    if robot.clock_offsets.add(source, stamp, robot.clock.now()):
        robot.snapshots.send_soon()


def on_audit_record(robot: Parts, message: String) -> None:
    """Add the record of what another console did to the events.

    Any report of a STOP voids what was requested here before and has not left yet.
    """
    published = audit_records.parse(message.data)
    if published is None:
        return
    console, record, text = published
    is_known = console in robot.graph.consoles
    if not is_known and not (record.verb == "stop" and robot.graph.knows_console(console)):
        return
    robot.changes.on_audit_record(record, robot.clock.monotonic())
    robot.stops.sent_elsewhere += record.verb == "stop"
    robot.stops.superseded |= record.verb != "stop"
    if record.code is Code.DONE and record.verb == "stop":
        robot.stop_sender.on_stopped_elsewhere(console)
    elif record.code is Code.DONE and record.verb == "release":
        robot.stop_sender.on_released_elsewhere(console)
    robot.reporter.add(Event(robot.clock.now(), "PEER", console, text, audit_record=record))


def on_answered(robot: Parts, turn: int) -> None:
    """Send STOP again if the robot may have obeyed an answered request, by its turn, after it."""
    if robot.stop_sender.stop.must_follow(turn):
        robot.thread.submit(robot.stop_sender.send_after_late_answer)


def on_goal_change(robot: Parts, is_new_phase: bool) -> None:
    """Begin to check the goals, and show the change: at once if a goal has a new phase."""
    robot.stop_sender.begin_ticking()
    if robot.goal_timer.is_canceled():
        robot.goal_timer.reset()
    if is_new_phase:
        robot.snapshots.send()
    else:  # After feedback, so that the motion which is reported beside it is shown with it.
        robot.snapshots.send_soon()


def on_goal_end(robot: Parts, goal: Goal, text: str) -> None:
    """Add an event with an audit record about how a goal ended."""
    assert goal.code is not None  # It has ended.
    record = AuditRecord(*verb_of(robot, goal.kind, goal.fields), goal.code)
    event = Event(robot.clock.now(), "GOAL", goal.kind.action, text, audit_record=record)
    robot.reporter.add(event)


def on_new_value(robot: Parts, node: str, old: object, new: object) -> None:
    """Measure the periods of topics and feedback again, because a parameter has changed."""
    robot.telemetry.forget_periods(node, old, new)
    servers = robot.graph.servers
    robot.goals.forget_periods(old, new, lambda kind: node in servers.get(kind.action, ()))


def on_parameter_event(robot: Parts, node: str, name: str, old: Any, new: Any) -> None:
    """Record a change of a parameter, which nobody may report."""
    if is_secret(name):
        old = new = MASK
    robot.changes.on_parameter(node, name, old, new, robot.clock.monotonic())


POLL_PERIOD = 1.0  # Seconds between two polls: rclpy has no event for a change of the graph.
WATCH_PERIOD = 0.2  # Seconds between two checks of the goals that run.
_EARLY = 0.05  # Seconds by which a poll may be early.

SETTLED = 5.0  # Seconds without a new node after which the graph counts as discovered.
NAMED = 3  # Nodes that one line names; it counts the others.


def check_goals(robot: Parts) -> None:
    """Check the goals that run, for silence and known lengths; stop the timer if none does."""
    if not robot.goals.running:
        robot.goal_timer.cancel()
        return
    now, motion = robot.clock.monotonic(), robot.telemetry.motion
    robot.goals.check(now, motion, lambda kind: way_length(robot, kind))


class Poller:
    """The polling of the graph, and of all that depends on what is there."""

    def __init__(self, robot: Parts) -> None:
        self._robot = robot
        self._next = float("-inf")  # When the next poll is due, in monotonic seconds.
        self._arrivals = Arrivals(robot.clock.monotonic())
        self._consoles: set[str] | None = None  # The other consoles; None before the first poll.
        self._mismatches: frozenset[str] = frozenset()  # Those that were reported.

    def poll_if_due(self) -> None:
        """Poll the graph, unless a rest after the last poll is due; call this each second.

        The rest is longer than a second only on a very large graph.
        """
        robot = self._robot
        if robot.clock.monotonic() >= self._next:
            self.poll()
        self._forget_clocks()
        is_needed = robot.graph.has_clock and bool(robot.snapshot.simulated_nodes)
        robot.sim_clock.poll(is_needed=is_needed)

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
        robot.lifecycles.poll(graph.served_services)
        for text in robot.changes.take_due(robot.clock.monotonic()):
            reporter.note("PEER", text)
        faults = self._find_faults()
        if changed or faults != robot.faults or robot.snapshots.is_stale:
            robot.faults = faults
            robot.snapshots.send_soon()
        self._report_mismatches()
        robot.parameters.poll(graph.node_counts, graph.services)

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
        if self._consoles is not None:
            for name in sorted(now - self._consoles):
                self._robot.reporter.note("PEER", f"console {name} came")
            for name in sorted(self._consoles - now):
                self._robot.reporter.note("PEER", f"console {name} left")
        self._consoles = now

    def _report_mismatches(self) -> None:
        mismatches = [text for found in self._robot.graph.resources for text in found.mismatches]
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
