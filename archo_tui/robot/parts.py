"""The parts of the robot's side, and what they tell each other; requests go over them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.context import Context
from std_msgs.msg import String

from archo_tui.base.clock import Clock
from archo_tui.robot.clients import author
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.goals.machine import FARTHEST
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.graph.lifecycle import Lifecycles
from archo_tui.robot.graph.parameter_values import is_secret
from archo_tui.robot.graph.parameters import Parameters, without_secrets
from archo_tui.robot.messages.types import load_all
from archo_tui.robot.node import MessageCallback
from archo_tui.robot.outcome import Code
from archo_tui.robot.runtime import MAX_UNREAD, Runtime
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.graph import MASK, level_word, linked_number, logger_node
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.sender import StopSender
from archo_tui.robot.telemetry import ClockOffsets, Telemetry
from archo_tui.robot.topics.frames import FrameListener
from archo_tui.robot.topics.publications import Publications
from archo_tui.robot_file.model import GoalKind, ParameterRef, RobotFile

WATCH_PERIOD = 0.2  # Seconds between two checks of the goals that run.


class Parts(Runtime):
    """The parts of the robot's side, which the ROS thread changes.

    Requests read some of them on the event loop: names, parameters, the goal, the open STOP.
    """

    def __init__(
        self,
        context: Context,
        file: RobotFile,
        clock: Clock,
        on_event: Callable[[Event], None] = lambda _: None,
        on_message: MessageCallback = lambda *_: None,
        *,
        watching: bool = False,  # Every request that changes something is refused.
    ) -> None:
        """Create the console's node, which joins the graph; importing its messages may take long.

        `on_event` and `on_message` are called on the ROS thread: with each event, also with one
        that repeats another, and with topic, class and bytes of each message, secrets masked.
        """
        load_all(file)
        super().__init__(context, clock, on_event, on_message, {ParameterEvent: without_secrets})
        self.file, self.watching = file, watching
        # The full names of the nodes that run here, and of those whose code may still run. The
        # session sets both.
        self.own_nodes: Callable[[], Collection[str]] = tuple
        self.unended_nodes: Callable[[], Collection[str]] = tuple
        self.faults: dict[str, str] = {}  # Why a name of the robot file is not used, by that name.
        node = self.node
        node.on_answered = self._on_answered
        self.graph = Graph(node, file)
        self.checks = InterfaceChecks(node, file, self.graph)
        self.clock_offsets = ClockOffsets()
        self.telemetry = Telemetry(
            *(node, file, clock, self._on_reading, self.reporter.warn, self._on_stamp),
            file.further_topics,
        )
        self.frames = FrameListener(self, self.graph, self._on_transforms)
        self.parameters = Parameters(self, self._on_new_value, self._on_parameter_event)
        self.lifecycles = Lifecycles(self)
        exempt = frozenset(kind.action for kind in file.goals if not kind.stop_cancels)
        self.goals = Goals(self, self._on_goal_change, self._on_goal_end, exempt, watching)
        self.publications = Publications()
        self.goal_timer = node.create_steady_timer(WATCH_PERIOD, self.check_goals)
        self.goal_timer.cancel()
        self.stops = Stops()  # For any thread.
        if file.stop is not None:
            self.stops.set_service(file.stop, self.checks.full(file.stop.service))
        self.stop_sender = StopSender(
            *(self, file.stop, self.graph, self.checks, self.goals, self.telemetry),
            lambda: self.unended_nodes(),
        )
        node.listen_quietly(Log, "/rosout", self._on_log, 1000)
        node.listen_quietly(String, audit_records.TOPIC, self._on_audit_record, MAX_UNREAD)
        for kind in file.goals:
            self.goals.track(kind)
        if file.frames:
            self.frames.begin()
        self.begun = clock.monotonic()  # When this console started.
        for text in self.checks.unfit.values():
            self.reporter.warn(text)
        self.snapshots.send()  # What the robot file says is known before any message comes.

    @property
    def snapshot(self) -> Snapshot:
        """The newest snapshot, also if it was not delivered yet. Any thread."""
        return self.snapshots.latest

    def way_length(self, kind: GoalKind) -> float | None:
        """Return the length of the whole way for a kind of goal, by the robot file, or None."""
        length = None if kind.remaining is None else kind.remaining.length
        if isinstance(length, ParameterRef):
            parameters, namespace = self.parameters.all(), self.graph.namespace
            return linked_number(parameters, namespace, length, 0.0, FARTHEST)
        return length

    def verb_of(self, kind: GoalKind, values: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
        """Return the id of the verb that sends a goal, and its arguments, for the audit record."""
        if kind not in self.file.goals:
            return "send_goal", {"action": self.checks.full(kind.action), "values": values}
        return "go" if kind == self.file.goals[0] else kind.id, values

    # What is received. All of it runs on the ROS thread.

    def _on_reading(self, topic: str, has_changed: bool) -> None:
        """Count a message with a reading, and have a snapshot sent if a value changed."""
        self.graph.on_topic_message(topic, self.clock.monotonic())
        if self.file.motion is not None and topic == self.file.motion.topic:
            self._on_motion(topic)
        self.snapshots.is_stale = True
        if has_changed:
            self.snapshots.send_soon()

    def _on_motion(self, topic: str) -> None:
        self.goals.on_robot_message()
        if len(self.graph.publishers.get(topic, ())) > 1:
            return  # The readings of several robots come mixed.
        stop, motion = self.file.stop, self.telemetry.motion
        # One of several robots tells nothing about the others.
        if stop is not None and stop.service not in self.graph.duplicates:
            self.stop_sender.on_motion(motion)
        # A node that was restarted reports what nobody has done.
        if self.stop_sender.stop.latch is not Latch.UNCERTAIN:
            self.changes.on_motion(motion, self.clock.monotonic())

    def _on_transforms(self) -> None:
        self.snapshots.is_stale = True  # They are shown in the snapshot of each second.

    def _on_log(self, message: Log) -> None:
        """Add a line on /rosout to the events; goals and clock offsets learn from it."""
        node = logger_node(message.name)
        console, now = author(node), self.clock.now()
        if console:
            # Every other console sends the same line in its audit record.
            if console in self.graph.silent_consoles:
                self.reporter.add(Event(now, "PEER", console, message.msg))
            return
        if not self.graph.is_ours(node):
            return  # It is another robot's.
        if node not in self.own_nodes():
            self._compare_clocks(node, message.stamp)
        for kind in self.file.goals:
            servers = self.graph.servers.get(kind.action, ())
            if kind.refusals and node in servers and message.msg.startswith(kind.refusals):
                self.goals.on_refusal_log(message.msg.removeprefix(kind.refusals))
        self.graph.on_log_line(node, self.clock.monotonic())
        # The robot's clock may differ, and the events are in order: so not by the stamp.
        level = level_word(message.level)
        self.reporter.add(Event(now, level, message.name, message.msg))

    def _on_stamp(self, topic: str, stamp: Any) -> None:
        """Compare the stamp in a header of a topic (full name) with this computer's clock."""
        # A node of this process shares its clock, and simulated time is no time of day.
        if not (self.own_nodes() or self.graph.has_clock):
            self._compare_clocks(topic, stamp)

    def _compare_clocks(self, source: str, stamp: Any) -> None:
        if self.clock_offsets.add(source, stamp, self.clock.now()):
            self.snapshots.send_soon()

    def _on_audit_record(self, message: String) -> None:
        """Add the record of what another console did to the events.

        Any report of a STOP voids what was requested here before and has not left yet.
        """
        published = audit_records.parse(message.data)
        if published is None:
            return
        console, record, text = published
        is_known = console in self.graph.consoles
        if not is_known and not (record.verb == "stop" and self.graph.knows_console(console)):
            return
        self.changes.on_audit_record(record, self.clock.monotonic())
        self.stops.sent_elsewhere += record.verb == "stop"
        self.stops.superseded |= record.verb != "stop"
        if record.code is Code.DONE and record.verb == "stop":
            self.stop_sender.on_stopped_elsewhere(console)
        elif record.code is Code.DONE and record.verb == "release":
            self.stop_sender.on_released_elsewhere(console)
        self.reporter.add(Event(self.clock.now(), "PEER", console, text, audit_record=record))

    def _on_answered(self, turn: int) -> None:
        """Send STOP again if the robot may have obeyed an answered request, by its turn, after."""
        if self.stop_sender.stop.must_follow(turn):
            self.thread.submit(self.stop_sender.send_after_late_answer)

    def _on_goal_change(self, is_new_phase: bool) -> None:
        """Begin to check the goals, and show the change: at once if a goal has a new phase."""
        self.stop_sender.begin_ticking()
        if self.goal_timer.is_canceled():
            self.goal_timer.reset()
        if is_new_phase:
            self.snapshots.send()
        else:  # After feedback, so that the motion which is reported beside it is shown with it.
            self.snapshots.send_soon()

    def check_goals(self) -> None:
        """Check the goals that run, for silence and known lengths; stop the timer if none does."""
        if self.goals.running:
            self.goals.check(self.clock.monotonic(), self.telemetry.motion, self.way_length)
        else:
            self.goal_timer.cancel()

    def _on_goal_end(self, goal: Goal, text: str) -> None:
        """Add an event with an audit record about how a goal ended."""
        assert goal.code is not None  # It has ended.
        record = AuditRecord(*self.verb_of(goal.kind, goal.fields), goal.code)
        event = Event(self.clock.now(), "GOAL", goal.kind.action, text, audit_record=record)
        self.reporter.add(event)

    def _on_new_value(self, node: str, old: object, new: object) -> None:
        """Measure the periods of topics and feedback again, because a parameter has changed."""
        self.telemetry.forget_periods(node, old, new)
        servers = self.graph.servers
        self.goals.forget_periods(old, new, lambda kind: node in servers.get(kind.action, ()))

    def _on_parameter_event(self, node: str, name: str, old: Any, new: Any) -> None:
        """Record a change of a parameter, which nobody may report."""
        if is_secret(name):
            old = new = MASK
        self.changes.on_parameter(node, name, old, new, self.clock.monotonic())

    def _build_snapshot(self) -> Snapshot:
        graph, stop = self.graph, self.stop_sender.stop
        snapshot = Snapshot(
            file=self.file,
            goal=self.goals.goal,
            running=self.goals.running,
            history=tuple(self.goals.history),
            parameters=self.parameters.all(),
            unreported=self.parameters.unreported,
            events=self.reporter.log.all(),
            open_stop=stop.open,
            latch=stop.latch,
            latch_doubt=stop.doubt,
            latch_time=self.stop_sender.time,
            released=stop.released,
            stop_held_by_nobody=stop.is_held_by_nobody or stop.has_reached_nobody,
            stop_not_obeyed=stop.is_not_obeyed,
            still_running_after_stop=self.stop_sender.still_running,
            nodes=self.lifecycles.with_states(graph.node_states()),
            namespace=graph.namespace,
            **graph.shown(),
            message_rates=graph.message_rates(),
            transforms=self.frames.transforms,
            faults=self.faults,
            forms=self.checks.forms,
            clock_offsets=self.clock_offsets.large,
        )
        return self.telemetry.in_snapshot(snapshot)
