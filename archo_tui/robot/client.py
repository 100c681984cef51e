"""The robot as its front ends see it: snapshots to show, and verbs to operate it.

Verbs are coroutines for the asyncio loop. Each ends within a deadline: done, refused with the
reason, or without an answer. They are in `stop_verbs.py`, `goal_verbs.py`, `service_verbs.py` and
`node_verbs.py`; what is done on the ROS thread is in the other files of this folder.
"""

from __future__ import annotations

# ruff: noqa: E402
import contextlib
from collections.abc import AsyncIterator, Callable, Collection, Mapping, Sequence
from typing import Any, NoReturn

from archo_tui import engine

engine.ensure()

from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.context import Context
from std_msgs.msg import String

from archo_tui.clock import Clock
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot import audit_records, calls
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.calls import QUESTION_TIMEOUT, Services
from archo_tui.robot.clocks import ClockOffsets, SimClock
from archo_tui.robot.consoles import new_node_name
from archo_tui.robot.events import MAX_UNREAD, Reporter
from archo_tui.robot.goal_guard import GoalGuard
from archo_tui.robot.goal_verbs import GoalVerbs, verb_of
from archo_tui.robot.goal_watcher import GoalWatcher
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.graph.lifecycle import Lifecycles
from archo_tui.robot.graph.nodes import Nodes
from archo_tui.robot.graph.parameters import Parameters, is_secret, masked, without_secrets
from archo_tui.robot.graph.resources import SEND
from archo_tui.robot.graph_poller import POLL_PERIOD, GraphPoller
from archo_tui.robot.message_handlers import MessageHandlers
from archo_tui.robot.messages.text import flat_fields
from archo_tui.robot.messages.types import TypedField, load_all, load_class
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.node import Listener, MessageCallback
from archo_tui.robot.node_verbs import NodeVerbs
from archo_tui.robot.other_clients import UnexplainedChanges
from archo_tui.robot.outcome import CALL_WAIT, Code, Outcome
from archo_tui.robot.readings.subscriptions import News, RecordedTopics
from archo_tui.robot.readings.telemetry import Telemetry
from archo_tui.robot.requester import YOU, current_requester
from archo_tui.robot.ros_thread import RosThread
from archo_tui.robot.service_caller import ServiceCaller
from archo_tui.robot.service_verbs import ServiceVerbs
from archo_tui.robot.snapshot_sender import Receiver, SnapshotSender
from archo_tui.robot.state import (
    MASK,
    Diagnostic,
    Event,
    Goal,
    NodeInfo,
    Snapshot,
    TopicInfo,
    TopicRequest,
    TopicView,
)
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop_sender import StopSender
from archo_tui.robot.stop_verbs import StopVerbs
from archo_tui.robot.topics.follow import TopicFollower
from archo_tui.robot.topics.inspect import Inspection
from archo_tui.robot.verb_runner import VerbRunner
from archo_tui.robot_file import model


class Robot:
    """The robot as front ends see it: its newest snapshot, and the verbs that operate it.

    The end of each verb that sends or changes something is reported: as an event, in the ROS log,
    and to the robot's other consoles.
    """

    def __init__(
        self,
        context: Context,
        file: model.RobotFile,
        clock: Clock,
        on_event: Callable[[Event], None] = lambda _: None,
        on_message: MessageCallback = lambda *_: None,
        *,
        watching: bool = False,
    ) -> None:
        # True if every verb is refused, and no service is called but those that only read.
        self.watching = watching
        self.file = file
        self._clock = clock
        # Returns the full names of the nodes that this process hosts.
        self.own_nodes: Callable[[], Collection[str]] = tuple
        # Returns those of the own nodes whose code may still run.
        self.unended_nodes: Callable[[], Collection[str]] = tuple
        self.stops = stops = Stops()
        load_all(file)
        masks = {ParameterEvent: without_secrets}
        node = self._node = Listener(
            new_node_name(), on_message, masks, context=context, start_parameter_services=False
        )
        # The robot's time may stand still, or jump.
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self._snapshots = SnapshotSender(node, steady, self._build_snapshot)
        self._services = Services(node, clock)
        self._graph = Graph(node, file)
        self._interface_checks = checks = InterfaceChecks(node, file, self._graph)
        self._unexplained_changes = UnexplainedChanges(file, self._motion_publishers)
        self._reporter = Reporter(
            node, clock, self._unexplained_changes, on_event, self._snapshots.send_soon
        )
        self._clock_offsets = ClockOffsets()
        self._sim_clock = SimClock(node, clock, self._snapshots.send_soon)
        self._telemetry = Telemetry(
            node,
            file,
            clock,
            self._on_reading,
            self._reporter.warn,
            lambda topic, stamp: self._handlers.on_stamp(topic, stamp),
        )
        recorded_topics = RecordedTopics(node, file.record, self._reporter.warn)
        self._goals = Goals(
            node,
            clock,
            self._services,
            self._on_goal_change,
            self._reporter.note,
            self._goal_ended,
            lambda: self._graph.consoles,
            frozenset(kind.action for kind in file.goals if not kind.stop_cancels),
            watching,
        )
        self._parameters = Parameters(
            node,
            clock,
            self._services,
            self._snapshots.send_soon,
            self._forget_periods,
            self._on_parameter_change,
        )
        caller = ServiceCaller(node, steady, self._services, self._graph, checks)
        self._services.on_answered = self._on_answer
        if file.stop is not None:
            stops.set_service(file.stop, checks.full(file.stop.service))
        self._stop_sender = StopSender(
            node,
            steady,
            file.stop,
            clock,
            self._services,
            self._graph,
            checks,
            self._goals,
            self._telemetry,
            self._reporter,
            self._snapshots,
            lambda: self._thread,
            lambda: self.unended_nodes(),
        )
        lifecycles = self._lifecycles = Lifecycles(
            node,
            clock,
            self._services,
            lambda work: self._thread.submit(work),
            self._snapshots.send_soon,
        )
        self._poller = GraphPoller(
            file,
            clock,
            self._graph,
            checks,
            self._telemetry,
            recorded_topics,
            lifecycles,
            self._parameters,
            self._stop_sender,
            self._unexplained_changes,
            self._reporter,
            self._snapshots,
            lambda: self.own_nodes(),
        )
        self._handlers = MessageHandlers(
            file,
            clock,
            self._graph,
            self._goals,
            stops,
            self._stop_sender,
            self._unexplained_changes,
            self._reporter,
            self._snapshots,
            self._clock_offsets,
            lambda: self.own_nodes(),
        )
        node.listen_quietly(Log, "/rosout", self._handlers.on_log, 1000)
        node.listen_quietly(String, audit_records.TOPIC, self._handlers.on_audit_record, MAX_UNREAD)
        node.create_timer(POLL_PERIOD, self._poll, clock=steady)
        self._goal_watcher = GoalWatcher(
            node,
            steady,
            clock,
            self._goals,
            self._graph,
            self._parameters,
            self._telemetry,
            self._snapshots,
        )
        goal_guard = GoalGuard(
            file, self._graph, self._stop_sender, self._telemetry, lambda: self._poller.faults
        )
        for kind in file.goals:
            self._goals.actions.track(kind)
        self._thread = RosThread(node, context, clock, self._reporter.error)
        self._runner = VerbRunner(
            self._thread, clock, stops, self._reporter, self._snapshots, watching=watching
        )
        self._stop_verbs = StopVerbs(
            file,
            clock,
            self._runner,
            caller,
            self._services,
            self._graph,
            checks,
            self._goals,
            stops,
            self._stop_sender,
        )
        self._goal_verbs = GoalVerbs(
            file,
            self._runner,
            self._services,
            self._graph,
            checks,
            self._goals,
            goal_guard,
            self._goal_watcher,
            self._stop_sender,
            lifecycles,
        )
        self._service_verbs = ServiceVerbs(clock, self._runner, caller, checks, self._reporter)
        self._node_verbs = NodeVerbs(
            self._thread,
            self._runner,
            Nodes(node, self._services),
            self._parameters,
            lifecycles,
        )
        for text in checks.unfit.values():
            self._reporter.warn(text)
        self._snapshots.send()  # What the robot file says is known before any message comes.

    def start(self) -> None:
        """Start the ROS thread: poll the graph at once, and receive messages from now on."""
        self._thread.submit(self._poller.poll)
        self._thread.start()

    def subscribe(self, receiver: Receiver) -> None:
        """Call a function with the newest snapshot now, and with each later one on this loop.

        If several come before the loop gets to them, only the newest is delivered.
        """
        self._snapshots.mailbox.open(receiver)
        receiver(self._snapshots.mailbox.latest)

    def stop(self) -> None:
        """Deliver no more snapshots, end the ROS thread, and leave the graph. No STOP is sent.

        Waits up to 3 s for a callback that is running; if that does not end, nothing is destroyed.
        """
        self._snapshots.mailbox.close()
        if self._thread.stop():
            self._goals.actions.close()

    @property
    def snapshot(self) -> Snapshot:
        """The newest snapshot, also if it was not delivered yet. Any thread."""
        return self._snapshots.mailbox.latest

    async def emergency_stop(self) -> Outcome:
        """Send STOP; return when every server has answered, or has not in time: see `StopVerbs`.

        A robot whose file names no STOP has every goal cancelled instead; the code is NOT_OFFERED
        then.
        """
        return await self._stop_verbs.emergency_stop()

    async def release_emergency_stop(self) -> Outcome:
        """Request the release of the STOP; return when the robot has answered, or has not in 2 s.

        The robot may move then, but continues no goal by itself. See `StopVerbs`.
        """
        return await self._stop_verbs.release_emergency_stop()

    async def give_up_stop(self) -> Outcome:
        """Give up a STOP that the robot has not confirmed: send it no more.

        Nothing is sent to the robot.
        """
        return await self._stop_verbs.give_up_stop()

    def early_stop_request(self) -> tuple[str, Mapping[str, Any]]:
        """Return the call that a starting hosted node must carry out before it spins."""
        return self._stop_verbs.early_stop_request()

    def on_early_stop(self, node: str) -> None:
        """Record that a starting hosted node has carried out the STOP. Any thread.

        The node then counts as one of those that hold the STOP.
        """
        self._thread.submit(lambda: self._stop_sender.on_early_stop(node))

    def on_parameters_restored(self, node: str, values: Mapping[str, Any]) -> None:
        """Report that a hosted node was restarted, and given these parameters. Any thread."""
        shown = masked(values)
        texts = ", ".join(f"{name} {text_of(value)}" for name, value in shown.items())
        text = f"set {node.lstrip('/')} {texts} again: it was restarted"
        record = AuditRecord("set", {"node": node, "values": shown}, Code.DONE)
        self._thread.submit(lambda: self._reporter.report_done(text, record))

    async def send(
        self, kind: model.GoalKind, values: Mapping[str, Any], *, queued: bool = False
    ) -> Outcome:
        """Send a goal; return when it was accepted, refused, or not answered: see `GoalVerbs`."""
        return await self._goal_verbs.send(kind, values, queued=queued)

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Request the cancel of the goal of this console that runs; see `GoalVerbs`."""
        return await self._goal_verbs.cancel(another=another)

    async def cancel_all(self) -> Outcome:
        """Request the cancel of every goal of the actions known here, whoever sent it."""
        return await self._goal_verbs.cancel_all()

    async def stop_sending_goals(self) -> None:
        """Refuse to send any goal from now on, also one that was typed before: the console ends.

        Running goals go on, and are not cancelled.

        Raises:
            TimeoutError: The ROS thread does not answer.
        """

        async def there() -> None:
            self._goals.sending_has_ended = True

        await self._thread.run(there, calls.DEADLINE)

    def allow_sending_goals(self) -> None:
        """Undo `stop_sending_goals`: the console does not end after all."""
        self._goals.sending_has_ended = False

    async def command(self, command: model.CommandService, on: bool = True) -> Outcome:
        """Call the service of a command in the robot file: see `ServiceVerbs`."""
        return await self._service_verbs.command(command, on)

    async def call(
        self, service: str, type_name: str, values: Mapping[str, Any], wait: float = CALL_WAIT
    ) -> Outcome:
        """Call any service; return an outcome that holds the answer; see `ServiceVerbs`."""
        return await self._service_verbs.call(service, type_name, values, wait)

    async def set_parameters(self, node: str, values: Mapping[str, Any]) -> Outcome:
        """Set parameters of a node, all of them or none.

        The text of the outcome tells the values that the node reports then, or why it refused.
        """
        return await self._node_verbs.set_parameters(node, values)

    async def describe(self, node: str) -> NodeInfo | Outcome:
        """Ask for what a node publishes, serves and uses, and for its log level."""
        return await self._node_verbs.describe(node)

    async def topic_info(self, topic: str) -> TopicInfo | Outcome:
        """Return the publishers and subscriptions of a topic, by its full name, with their QoS.

        Raises:
            ValueError: The name is not valid.
        """
        return await self._node_verbs.topic_info(topic)

    async def log_level(self, node: str) -> Outcome:
        """Ask a node for the level of its log, which the text of the outcome tells."""
        return await self._node_verbs.log_level(node)

    async def set_log_level(self, node: str, level: str) -> Outcome:
        """Set the level of a node's log, and report what it is then; see `NodeVerbs`."""
        return await self._node_verbs.set_log_level(node, level)

    async def change_lifecycle(self, node: str, transition: str) -> Outcome:
        """Request a transition of a managed node, and wait for its end: see `NodeVerbs`."""
        return await self._node_verbs.change_lifecycle(node, transition)

    async def lifecycle_transitions(self, node: str) -> tuple[str, ...]:
        """Ask a managed node for the transitions that it can make now, as words: `activate`."""
        return await self._node_verbs.lifecycle_transitions(node)

    def form(self, type_name: str) -> tuple[TypedField, ...] | None:
        """Return the fields of a goal or a request for a form, with their default values."""
        found = load_class(type_name)
        if found is None:
            return None
        return tuple(flat_fields(found.Goal() if "/action/" in type_name else found.Request()))

    async def types_anywhere(self, name: str, *, is_action: bool = False) -> tuple[str, ...]:
        """Return the types with which nodes serve a service or an action, in any namespace."""

        async def there() -> tuple[str, ...]:
            served = self._graph.served_types(name + SEND if is_action else name)
            return tuple(kind.removesuffix("_SendGoal") for kind in served)

        try:
            return await self._thread.run(there, QUESTION_TIMEOUT)
        except TimeoutError:
            return ()

    @contextlib.asynccontextmanager
    async def inspect(
        self,
        topic: str,
        message_class: Any,
        on_data: Callable[[float, bytes, bool], None] = lambda *_: None,
    ) -> AsyncIterator[Inspection]:
        """Count the messages of a topic while the context is entered; its value is the inspection.

        The subscription is made with a QoS that fits the publishers, and ends with the context.

        Raises:
            TimeoutError: The ROS thread does not answer.
            ArchoError: rclpy refuses the subscription, as Fast DDS does for a second type.
        """
        inspection = Inspection(self._node, self._clock, topic, message_class, on_data)

        async def begin() -> None:
            try:
                inspection.subscribe()
            except Exception as error:  # As Fast DDS refuses a second type of a topic.
                raise ArchoError(f"{topic}: no subscription: {in_one_line(error)}") from None

        try:
            await self._thread.run(begin, QUESTION_TIMEOUT)
            yield inspection
        finally:
            self._thread.submit(inspection.unsubscribe)  # Runs after `begin`, however late that is.

    def resubscribe_if_needed(self, inspection: Inspection) -> None:
        """Have an inspection subscribe again if its QoS no longer fits the publishers.

        Returns at once: the ROS thread does it later.
        """
        self._thread.submit(inspection.resubscribe_if_needed)

    async def follow_topic(
        self,
        topic: str,
        request: Callable[[], TopicRequest],
        show: Callable[[TopicView], None],
    ) -> NoReturn:
        """Show the messages of a topic, up to five times a second, until the task is cancelled."""
        await TopicFollower(self, self._clock, topic, request, show).run()

    def end_goals_of_node(self, served: Sequence[str]) -> None:
        """End the running goals of a hosted node that has gone, as GONE. Any thread.

        Returns at once: the ROS thread does it later.
        """

        def end() -> None:
            self._goals.end_goals_of_node(
                lambda kind: self._interface_checks.full(kind.action) in served
            )

        self._thread.submit(end)

    def forget_diagnostic(self, part: Diagnostic) -> None:
        """Drop a part of the diagnostics, which is there again once it reports. Any thread.

        Returns at once: the ROS thread does it later, and adds an event.
        """

        def forget() -> None:
            if self._telemetry.diagnostics.forget(part.key):
                self._snapshots.send_soon()

        self._thread.submit(forget)
        self.note(YOU.level, YOU.source, f"diagnostics: {part.part} was forgotten")

    def note(
        self,
        level: str,
        source: str,
        text: str,
        command: str = "",
        audit_record: AuditRecord | None = None,
    ) -> None:
        """Add an event to the log of this console; other consoles and /rosout get none. Any thread.

        Returns at once: the ROS thread adds it, with the present time.
        """
        if (level, source) == (YOU.level, YOU.source):
            level, source = current_requester().level, current_requester().source
        event = Event(self._clock.now(), level, source, text, command, audit_record=audit_record)
        self._thread.submit(lambda: self._reporter.add(event))

    async def wait_for_events(self) -> None:
        """Wait until a snapshot with all events that were noted before has been sent.

        Return after 2 s without it if the ROS thread is busy.
        """

        async def there() -> None:
            self._snapshots.send()

        with contextlib.suppress(TimeoutError):  # The thread is busy: go on without them.
            await self._thread.run(there, calls.DEADLINE)

    # All below runs on the ROS thread.

    def _poll(self) -> None:
        self._poller.poll_if_due()
        self._handlers.forget_clocks()
        is_needed = self._graph.has_clock and bool(self.snapshot.simulated_nodes)
        self._sim_clock.poll(is_needed=is_needed)

    def _motion_publishers(self) -> frozenset[bytes]:
        motion = self.file.motion
        return frozenset() if motion is None else self._graph.publisher_ids(motion.topic)

    def _on_goal_change(self, is_new_phase: bool) -> None:
        self._stop_sender.begin_ticking()
        self._goal_watcher.on_change(is_new_phase)

    def _on_answer(self, turn: int) -> None:
        """Send STOP again if the robot may have obeyed an answered request after the STOP."""
        if self._stop_sender.stop.must_follow(turn):
            self._thread.submit(self._stop_sender.send_after_late_answer)

    def _forget_periods(self, node: str, old: object, new: object) -> None:
        """Measure the periods of topics and feedback again, because a parameter has changed."""
        self._telemetry.forget_periods(node, old, new)
        servers = self._graph.servers
        self._goals.forget_periods(old, new, lambda kind: node in servers.get(kind.action, ()))

    def _on_reading(self, topic: str, news: News) -> None:
        self._handlers.on_reading(topic, news, self._telemetry.motion)

    def _on_parameter_change(self, node: str, name: str, old: Any, new: Any) -> None:
        if is_secret(name):
            old = new = MASK
        self._unexplained_changes.on_parameter(node, name, old, new, self._clock.monotonic())

    def _goal_ended(self, goal: Goal, text: str) -> None:
        """Add an event with an audit record about how a goal ended, and have it shown."""
        assert goal.code is not None  # It has ended.
        verb = verb_of(self.file, self._interface_checks, goal.kind, goal.fields)
        record = AuditRecord(*verb, goal.code)
        self._reporter.add(
            Event(self._clock.now(), "GOAL", goal.kind.action, text, audit_record=record)
        )

    def _build_snapshot(self) -> Snapshot:
        """Return a snapshot of all that is known now; nothing is sent."""
        return Snapshot(
            file=self.file,
            battery=self._telemetry.battery,
            motion=self._telemetry.motion,
            pose=self._telemetry.pose,
            gauges=self._telemetry.gauges,
            diagnostics=self._telemetry.diagnostics.all,
            goal=self._goals.goal,
            running=self._goals.running,
            history=tuple(self._goals.history),
            parameters=self._parameters.all(),
            unreported=self._parameters.unreported,
            nodes=self._lifecycles.with_states(self._graph.node_states()),
            offered=self._graph.offered,
            events=self._reporter.log.all(),
            charge=self._telemetry.charge,
            open_stop=self._stop_sender.stop.open,
            latch=self._stop_sender.stop.latch,
            latch_doubt=self._stop_sender.stop.doubt,
            latch_time=self._stop_sender.time,
            released=self._stop_sender.stop.released,
            stop_held_by_nobody=self._stop_sender.stop.is_held_by_nobody
            or self._stop_sender.stop.has_reached_nobody,
            stop_not_obeyed=self._stop_sender.stop.is_not_obeyed,
            still_running_after_stop=self._stop_sender.still_running,
            namespace=self._graph.namespace,
            faults=self._poller.faults,
            publishers=self._graph.publishers,
            duplicate_nodes=self._graph.duplicate_nodes,
            duplicate_servers=self._graph.duplicates,
            has_clock=self._graph.has_clock,
            clock_still_since=self._sim_clock.still_since,
            clock_offsets=self._clock_offsets.large,
            other_namespaces=self._graph.other_namespaces,
            consoles=self._graph.consoles,
            forms=self._interface_checks.forms,
            actions=self._graph.actions,
            services=self._graph.served_services,
            resources=self._graph.resources,
            message_rates=self._graph.message_rates(),
        )
