"""The robot as its front ends see it: snapshots to show, and requests to operate it."""

from __future__ import annotations

# ruff: noqa: E402
import contextlib

from archo_tui import engine

engine.ensure()

from archo_tui.robot.clients import YOU, current_requester
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.parts import Parts
from archo_tui.robot.poller import Poller
from archo_tui.robot.requests import commands
from archo_tui.robot.requests import nodes as node_requests
from archo_tui.robot.requests import publish as publish_requests
from archo_tui.robot.requests import topics as topic_requests
from archo_tui.robot.runtime import Receiver
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.readings import Diagnostic


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
        self.snapshots.mailbox.open(receiver)
        receiver(self.snapshot)

    def close(self) -> None:
        """Deliver no more snapshots, end the ROS thread, and leave the graph."""
        self.snapshots.mailbox.close()
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
