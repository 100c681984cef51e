"""The handlers of what is received: readings, log lines, and what other consoles did."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui.clock import Clock
from archo_tui.robot import audit_records
from archo_tui.robot.clocks import ClockOffsets
from archo_tui.robot.consoles import author
from archo_tui.robot.events import ROUTINE, Reporter
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.other_clients import UnexplainedChanges
from archo_tui.robot.outcome import Code
from archo_tui.robot.readings.subscriptions import News
from archo_tui.robot.snapshot_sender import SnapshotSender
from archo_tui.robot.state import Event, Motion, level_word, logger_node
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop_sender import StopSender
from archo_tui.robot_file.model import RobotFile


class MessageHandlers:
    """The handlers of readings, log lines and audit records that are received. ROS thread only."""

    def __init__(
        self,
        file: RobotFile,
        clock: Clock,
        graph: Graph,
        goals: Goals,
        stops: Stops,
        stop: StopSender,
        changes: UnexplainedChanges,
        reporter: Reporter,
        snapshots: SnapshotSender,
        clock_offsets: ClockOffsets,
        own_nodes: Callable[[], Collection[str]],
    ) -> None:
        self._file, self._clock, self._graph, self._goals = file, clock, graph, goals
        self._stops, self._stop_sender = stops, stop
        self._changes, self._reporter, self._snapshots = changes, reporter, snapshots
        self._clock_offsets = clock_offsets
        self._own_nodes = own_nodes

    def on_reading(self, topic: str, news: News, motion: Motion) -> None:
        """Handle a message with a reading, and have a snapshot sent if a value changed.

        The rates of topic and node are updated.
        """
        self._graph.on_topic_message(topic, self._clock.monotonic())
        if self._file.motion is not None and topic == self._file.motion.topic:
            self._on_motion(topic, motion)
        self._snapshots.is_stale = True
        if news is News.WORDS:
            self._snapshots.send_soon()
        elif news is News.NUMBERS:
            self._snapshots.send_later()

    def _on_motion(self, topic: str, motion: Motion) -> None:
        self._goals.on_robot_message()
        if topic in self._graph.publishers:  # The readings of several robots come mixed.
            return
        served = self._file.stop
        # One of several robots tells nothing about the others.
        if served is not None and served.service not in self._graph.duplicates:
            self._stop_sender.on_motion(motion)
        self._changes.on_motion(motion, self._clock.monotonic())

    def on_log(self, message: Log) -> None:
        """Handle a line on /rosout: add an event, unless the line is another robot's.

        A line of another console is added only if that console publishes no audit records. The
        stamp is compared with this computer's clock, and the reason of a refused goal is kept.
        """
        node = logger_node(message.name)
        console = author(node)
        if console:
            # Every other console sends the same line in its audit record.
            if console in self._graph.silent_consoles:
                self._reporter.add(Event(self._clock.now(), "PEER", console, message.msg))
            return
        if not self._graph.is_ours(node):
            return  # It is another robot's.
        if node not in self._own_nodes():
            self._compare_clocks(node, message.stamp)
        for kind in self._file.goals:
            servers = self._graph.servers.get(kind.action, ())
            if kind.refusals and node in servers and message.msg.startswith(kind.refusals):
                self._goals.on_refusal_log(message.msg.removeprefix(kind.refusals))
        self._graph.on_log_line(node, self._clock.monotonic())
        # The robot's clock may differ, and the events are in order: so not by the stamp.
        level, now = level_word(message.level), self._clock.now()
        event = self._reporter.add_log_line(Event(now, level, message.name, message.msg))
        if level in ROUTINE or event.count > 1:
            self._snapshots.send_later()
        else:
            self._snapshots.send_soon()

    def on_stamp(self, topic: str, stamp: Any) -> None:
        """Compare the stamp in a message's header with this computer's clock.

        Nothing is done while this process hosts nodes, or time is simulated.
        """
        # A node of this process shares its clock, and simulated time is no time of day.
        if not (self._own_nodes() or self._graph.has_clock):
            self._compare_clocks(topic, stamp)

    def forget_clocks(self) -> None:
        """Forget the clock offsets of nodes and topics that left; in simulated time of all topics.

        A snapshot is sent soon if one was forgotten.
        """
        gone = [
            source
            for source in self._clock_offsets.large
            if source not in self._graph.names
            and (self._graph.has_clock or not self._graph.is_published(source))
        ]
        if gone:
            self._clock_offsets.forget(gone)
            self._snapshots.send_soon()

    def _compare_clocks(self, source: str, stamp: Any) -> None:
        if self._clock_offsets.add(source, stamp, self._clock.now()):
            self._snapshots.send_soon()

    def on_audit_record(self, message: String) -> None:
        """Handle the record of what another console did, and add it as an event.

        Any report of a STOP voids the goals and requests that were made here before and have not
        left yet, and counts in `Stops.sent_elsewhere`; any other record sets `Stops.superseded`.
        """
        published = audit_records.parse(message.data)
        if published is None or published.console not in self._graph.consoles:
            return
        console, record, text = published
        self._changes.on_audit_record(record, self._clock.monotonic())
        self._stops.sent_elsewhere += record.verb == "stop"
        self._stops.superseded |= record.verb != "stop"
        if record.code is Code.DONE and record.verb == "stop":
            self._stop_sender.on_stopped_elsewhere(console)
        elif record.code is Code.DONE and record.verb == "release":
            self._stop_sender.on_released_elsewhere(console)
        self._reporter.add(Event(self._clock.now(), "PEER", console, text, audit_record=record))
