"""The stand-ins for robot, host, recorder and station in a replay: they show, and do nothing."""

from __future__ import annotations

import contextlib
import math
import os
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn, cast

from archo_tui.base.clock import Clock
from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.handover import CONSOLE_SOCKET, STOP
from archo_tui.recordings.replay.bag import Encoded
from archo_tui.recordings.replay.player import Player
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import ACTION, SERVICE, TOPIC, Names, NodeInfo, TopicEnd, TopicInfo
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.topics.inspect import PERIOD, SHARE, MessageIntake, TopicWatch
from archo_tui.robot.topics.rows import SPAN, TopicRequest, TopicView
from archo_tui.robot_file.model import field_units
from archo_tui.station.alarms import Alarm
from archo_tui.station.station import Station
from archo_tui.station.view import View

# Seconds of messages that are read before the position, fewer where they are too many or too large.
_SPANS = (SPAN, 6.0, 1.0)


class RecordedTopicFollower:
    """A follower of one topic of a recording that passes on views of it until it is cancelled."""

    def __init__(
        self,
        player: Player,
        clock: Clock,
        topic: str,
        request: Callable[[], TopicRequest],  # Called before each view.
        show: Callable[[TopicView], None],
    ) -> None:
        self._player, self._clock, self._topic = player, clock, topic
        self._request, self._show = request, show
        self._kind = player.bag.types.get(topic, "")
        self._fault = ""  # What of the messages is left out.
        self._shown = 0.0  # The position of the last view.
        self._intake = MessageIntake()
        self._watch: TopicWatch | None = None  # None before the first view.

    async def run(self) -> NoReturn:
        """Show a view five times a second, less often if decoding takes long; never return."""
        spent = 0.0
        while True:
            now, snapshot = self._player.position, self._player.snapshot()
            if self._kind:
                view, spent = await in_daemon(self._update, self._request(), now, snapshot)
            else:
                view = TopicView(self._topic, fault=self._unreadable_reason())
            self._show(view._replace(ends=_recorded_ends(snapshot, self._topic)))
            await self._clock.sleep(max(PERIOD, spent / SHARE))

    def _unreadable_reason(self) -> str:
        begin = f"{self._topic}: "
        faults = (fault.removeprefix(begin) for fault in self._player.bag.faults if begin in fault)
        return next(faults, "it was not recorded")

    def _update(
        self, request: TopicRequest, now: float, snapshot: Snapshot
    ) -> tuple[TopicView, float]:
        """Return the view, and the processor time in seconds that it took. It may read the bag."""
        begun, watch, bag = time.thread_time(), self._watch, self._player.bag
        messages: list[Encoded] = []
        if watch is None or not 0 <= now - self._shown <= SPAN:
            self._intake, self._fault = MessageIntake(), ""
            units = field_units(snapshot.file, snapshot.full, self._topic, self._kind)
            watch = self._watch = TopicWatch(
                self._topic, self._kind, units, self._intake, partial(bag.decode, self._topic)
            )
            starts = [now - span for span in _SPANS]
        else:
            starts = [math.nextafter(self._shown, now)] if now > self._shown else []
        for start in starts:
            messages, is_cut, faults = bag.encoded_messages(start, now, self._topic)
            self._fault = next(iter(faults), self._fault)
            if not is_cut:
                break
        for message_time, _, data in messages:
            self._intake.add(message_time / 1e9, data)
        self._shown = now
        view = watch.update(now, request)
        view = view._replace(fault=view.fault or self._fault)
        return view, time.thread_time() - begun


def _recorded_ends(snapshot: Snapshot, topic: str) -> TopicInfo | None:
    resource = next((r for r in snapshot.resources if r.name == topic), None)
    if resource is None:
        return None
    types = ", ".join(resource.types)
    ends = tuple(TopicEnd(node, types, "QoS not recorded") for node in resource.nodes)
    return TopicInfo(ends, (), resource.mismatches)


NOTHING_STOPPED = "REPLAY: nothing was stopped"
_NOT_RECORDED = "not in the recording"


class ConsoleStops(Stops):
    """The STOPs that are read by a replay, each of which goes to the console that plays it."""

    def register(self) -> int:
        """Send a STOP to the console as it is read, whatever keeps the screen from its turn."""
        with contextlib.suppress(OSError):  # The console has ended.
            os.write(int(os.environ[CONSOLE_SOCKET]), STOP)
        return super().register()


class RecordedRobot:
    """A stand-in for `Robot` that shows the recorded robot; it has no verbs."""

    watching = True

    def __init__(self, player: Player, clock: Clock) -> None:
        self._player, self.file = player, player.file
        self.stops = ConsoleStops() if CONSOLE_SOCKET in os.environ else Stops()
        self._clock = clock

    @property
    def snapshot(self) -> Snapshot:
        """The state of the robot at the position."""
        return self._player.snapshot()

    def subscribe(self, receiver: Callable[[Snapshot], None]) -> None:
        """Call `receiver` with the snapshot at once, and never again."""
        receiver(self.snapshot)

    def note(self, *_: Any, **__: Any) -> None:
        """Do nothing: no event is added to a recording."""

    async def stop_sending_goals(self) -> None:
        """Do nothing: a recorded robot is sent no goals."""

    def end_publications_now(self) -> None:
        """Do nothing: a recorded robot is sent no messages."""

    async def emergency_stop(self) -> Outcome:
        """Refuse: a recording cannot be stopped."""
        return Outcome(Code.REFUSED, NOTHING_STOPPED)

    async def follow_topic(
        self,
        topic: str,
        request: Callable[[], TopicRequest],
        show: Callable[[TopicView], None],
    ) -> NoReturn:
        """Call `show` with views of a topic at the position, until cancelled."""
        await RecordedTopicFollower(self._player, self._clock, topic, request, show).run()

    async def describe(self, node: str) -> NodeInfo | Outcome:
        """Return the topics, services and actions that a node offered at the position."""
        found = [resource for resource in self.snapshot.resources if node in resource.nodes]
        if not found:
            return Outcome(Code.REFUSED, _NOT_RECORDED)

        def of_kind(kind: str) -> Names:
            return tuple((each.name, ", ".join(each.types)) for each in found if each.kind == kind)

        return NodeInfo(
            publishes=of_kind(TOPIC),
            serves=of_kind(SERVICE),
            actions=of_kind(ACTION),
            no_level=_NOT_RECORDED,
        )


class RecordedHost:
    """A stand-in for the host: the nodes that ran in the process of the recorded console."""

    def __init__(self, player: Player) -> None:
        self._player = player

    def states(self) -> tuple[Hosted, ...]:
        """Return the states of these nodes at the position."""
        return self._player.view().hosted

    def usage(self, _name: str) -> None:
        """Return None: nothing of a recording runs here."""


class NullRecorder:
    """A stand-in for the journal and the recorder of a console in a replay: it records nothing."""

    failure = trouble = kept = ""

    def write(self, *_: Any, **__: Any) -> None:
        """Do nothing."""

    def on_view(self, *_: Any) -> None:
        """Do nothing."""

    def keep(self, *_: Any) -> Outcome:
        """Refuse: this is a recording already."""
        return Outcome(Code.REFUSED, "this is a recording")


class RecordedStation(Station):
    """A station whose view is that of the player's position."""

    def __init__(self, player: Player, clock: Clock) -> None:
        """Show a player; the machine's clock decides how long a key is held."""
        self.player = player
        nothing: Any = NullRecorder()
        super().__init__(
            cast("Any", RecordedRobot(player, clock)),
            cast("Any", RecordedHost(player)),
            nothing,
            nothing,
            clock,
            engine="",
            namespace="/",
            attached=True,
            on_disconnect="leave",
            quiet=True,
        )

    def on_snapshot(self, snapshot: Snapshot) -> list[Alarm]:
        return self.refresh()

    def tick(self) -> list[Alarm]:
        return self.refresh()

    def refresh(self) -> list[Alarm]:
        """Refresh the player and the view; no alarm counts as changed, so a replay never rings."""
        self.player.refresh()
        self.view = self._view()
        return []

    def _view(self) -> View:
        return self.player.view()
