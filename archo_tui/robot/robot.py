"""The robot as its front ends see it: snapshots to show, and requests to operate it."""

from __future__ import annotations

# ruff: noqa: E402
import contextlib
from collections.abc import Callable
from functools import partial

from archo_tui import engine

engine.ensure()

from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.context import Context
from std_msgs.msg import String

from archo_tui.clock import Clock
from archo_tui.robot import calls, updates
from archo_tui.robot.calls import Services
from archo_tui.robot.clients.changes import UnexplainedChanges
from archo_tui.robot.clients.consoles import new_node_name
from archo_tui.robot.clients.requester import YOU, current_requester
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.graph.lifecycle import Lifecycles
from archo_tui.robot.graph.nodes import Nodes
from archo_tui.robot.graph.parameters import Parameters, without_secrets
from archo_tui.robot.messages.types import load_all
from archo_tui.robot.node import Listener, MessageCallback
from archo_tui.robot.parts import Parts
from archo_tui.robot.readings.clocks import ClockOffsets, SimClock
from archo_tui.robot.readings.telemetry import Telemetry
from archo_tui.robot.reporter import MAX_UNREAD, Reporter
from archo_tui.robot.requests import goals as goal_requests
from archo_tui.robot.requests import nodes as node_requests
from archo_tui.robot.requests import publish as publish_requests
from archo_tui.robot.requests import services as service_requests
from archo_tui.robot.requests import stop as stop_requests
from archo_tui.robot.requests import topics as topic_requests
from archo_tui.robot.ros_thread import RosThread
from archo_tui.robot.snapshot_sender import Receiver, SnapshotSender
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.readings import Diagnostic
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.sender import StopSender
from archo_tui.robot.topics.frames import FrameListener
from archo_tui.robot.topics.publications import Publications
from archo_tui.robot.updates import POLL_PERIOD, WATCH_PERIOD, Poller, check_goals
from archo_tui.robot_file.model import RobotFile


class Robot(Parts):
    """The robot: its parts, its newest snapshot, and the requests that operate it.

    The end of each request that sends or changes something is reported: as an event, in the ROS
    log, and to the robot's other consoles. Nothing is received before `start`.
    """

    def __init__(
        self,
        context: Context,
        file: RobotFile,
        clock: Clock,
        on_event: Callable[[Event], None] = lambda _: None,
        on_message: MessageCallback = lambda *_: None,
        *,
        watching: bool = False,
    ) -> None:
        """Create the console's node, which joins the graph; importing its messages may take long.

        `on_event` and `on_message` are called on the ROS thread: with each event, also with one
        that repeats another, and with topic, class and bytes of each message, secrets masked.
        """
        self.file, self.clock, self.watching = file, clock, watching
        self.own_nodes = self.unended_nodes = tuple  # The session sets them.
        self.faults = {}
        load_all(file)
        node = self.node = Listener(
            *(new_node_name(), on_message, {ParameterEvent: without_secrets}),
            context=context,
            start_parameter_services=False,
        )
        steady = self.timer_clock = RosClock(clock_type=ClockType.STEADY_TIME)
        send_soon = lambda: self.snapshots.send_soon()  # noqa: E731
        submit = lambda work: self.thread.submit(work)  # noqa: E731
        self.snapshots = SnapshotSender(node, steady, self._build_snapshot)
        self.services = Services(node, clock)
        self.services.on_answered = partial(updates.on_answered, self)
        self.graph = Graph(node, file)
        self.checks = InterfaceChecks(node, file, self.graph)
        self.nodes = Nodes(node, self.services)
        self.changes = UnexplainedChanges(file, self._motion_publishers)
        self.reporter = Reporter(node, clock, self.changes, on_event, send_soon)
        self.clock_offsets, self.sim_clock = ClockOffsets(), SimClock(node, clock, send_soon)
        self.telemetry = Telemetry(
            *(node, file, clock, partial(updates.on_reading, self)),
            *(self.reporter.warn, partial(updates.on_stamp, self), file.unshown_topics),
        )
        self.frames = FrameListener(
            *(node, clock, lambda: self.graph.has_clock, partial(updates.on_transforms, self))
        )
        self.parameters = Parameters(
            *(node, clock, self.services, submit, send_soon),
            *(partial(updates.on_new_value, self), partial(updates.on_parameter_event, self)),
        )
        self.goals = Goals(
            *(node, clock, self.services, partial(updates.on_goal_change, self)),
            *(self.reporter.note, partial(updates.on_goal_end, self)),
            lambda: self.graph.consoles,
            frozenset(kind.action for kind in file.goals if not kind.stop_cancels),
            watching,
        )
        self.publications = Publications(node, clock, self.services, steady)
        self.goal_timer = node.create_timer(WATCH_PERIOD, partial(check_goals, self), clock=steady)
        self.goal_timer.cancel()
        self.stops = Stops()
        if file.stop is not None:
            self.stops.set_service(file.stop, self.checks.full(file.stop.service))
        self.stop_sender = StopSender(
            *(node, steady, file.stop, clock, self.services, self.graph, self.checks, self.goals),
            *(self.telemetry, self.reporter, self.snapshots),
            lambda: self.thread,
            lambda: self.unended_nodes(),
        )
        self.lifecycles = Lifecycles(node, clock, self.services, submit, send_soon)
        self._poller = Poller(self)
        node.listen_quietly(Log, "/rosout", partial(updates.on_log, self), 1000)
        on_record = partial(updates.on_audit_record, self)
        node.listen_quietly(String, audit_records.TOPIC, on_record, MAX_UNREAD)
        node.create_timer(POLL_PERIOD, self._poller.poll_if_due, clock=steady)
        for kind in file.goals:
            self.goals.actions.track(kind)
        if file.frames:
            self.frames.begin()
        self.thread = RosThread(node, context, clock, self.reporter.error)
        self.begun = clock.monotonic()
        for text in self.checks.unfit.values():
            self.reporter.warn(text)
        self.snapshots.send()  # What the robot file says is known before any message comes.

    emergency_stop = stop_requests.emergency_stop
    release_emergency_stop = stop_requests.release_emergency_stop
    give_up_stop = stop_requests.give_up_stop
    early_stop_request = stop_requests.early_stop_request
    on_early_stop = stop_requests.on_early_stop

    send = goal_requests.send
    cancel = goal_requests.cancel
    cancel_all = goal_requests.cancel_all
    stop_sending_goals = goal_requests.stop_sending_goals
    allow_sending_goals = goal_requests.allow_sending_goals
    end_goals_of_node = goal_requests.end_goals_of_node

    command = service_requests.command
    call = service_requests.call

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
        self.look_at_graph()
        self.thread.start()

    def look_at_graph(self) -> None:
        """Poll the graph at once, since nodes have just been made here. Any thread."""
        self.thread.submit(self._poller.poll)

    def subscribe(self, receiver: Receiver) -> None:
        """Call a function with the newest snapshot now, and with each later one on this loop.

        If several come before the loop gets to them, only the newest is delivered.
        """
        self.snapshots.mailbox.open(receiver)
        receiver(self.snapshot)

    def close(self) -> None:
        """Deliver no more snapshots, end the ROS thread, and leave the graph.

        Waits up to 3 s for a callback that is running; if that does not end, nothing is destroyed.
        """
        self.snapshots.mailbox.close()
        if self.thread.stop():
            self.goals.actions.close()

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
            if self.telemetry.diagnostics.forget(part.key):
                self.snapshots.send_soon()

        self.thread.submit(forget)
        self.note(YOU.level, YOU.source, f"diagnostics: {part.part} was forgotten")

    async def wait_for_events(self) -> None:
        """Wait, at most 2 s, until a snapshot with all events that were noted before is sent."""

        async def there() -> None:
            self.snapshots.send()

        with contextlib.suppress(TimeoutError):  # The thread is busy: go on without them.
            await self.thread.run(there, calls.DEADLINE)

    def _motion_publishers(self) -> frozenset[bytes]:
        motion = self.file.motion
        return frozenset() if motion is None else self.graph.publisher_ids(motion.topic)

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
            offered=graph.offered,
            namespace=graph.namespace,
            publishers=graph.publishers,
            duplicate_nodes=graph.duplicate_nodes,
            duplicate_servers=graph.duplicates,
            has_clock=graph.has_clock,
            other_namespaces=graph.other_namespaces,
            consoles=graph.consoles,
            actions=graph.actions,
            services=graph.served_services,
            resources=graph.resources,
            message_rates=graph.message_rates(),
            transforms=self.frames.transforms,
            faults=self.faults,
            forms=self.checks.forms,
            clock_still_since=self.sim_clock.still_since,
            clock_offsets=self.clock_offsets.large,
        )
        return self.telemetry.in_snapshot(snapshot)
