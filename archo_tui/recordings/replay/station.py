"""The stand-ins for robot, host, recorder and station in a replay: they show, and do nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn, cast

from archo_tui.clock import Clock
from archo_tui.recordings.replay.player import Player
from archo_tui.recordings.replay.topic import RecordedTopicFollower
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import (
    ACTION,
    SERVICE,
    TOPIC,
    Hosted,
    Names,
    NodeInfo,
    Snapshot,
    TopicRequest,
    TopicView,
)
from archo_tui.robot.stop.gate import Stops
from archo_tui.station.alarms import Alarm
from archo_tui.station.station import Station
from archo_tui.station.view import View

NOTHING_STOPPED = "REPLAY: nothing was stopped"
_NOT_RECORDED = "not in the recording"


class RecordedRobot:
    """A stand-in for `Robot` that shows the recorded robot and cannot command it.

    A verb that is not defined here raises AttributeError.
    """

    watching = True

    def __init__(self, player: Player, clock: Clock) -> None:
        self._player, self.file, self.stops = player, player.file, Stops()
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
        """Return the topics, services and actions that a node offered at the position.

        What it subscribed to and called, and its log level, are not recorded.
        """
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

    def __getattr__(self, verb: str) -> NoReturn:
        raise AttributeError(f"a recorded robot does not {verb}")


class RecordedHost:
    """A stand-in for the host: the nodes that ran in the process of the recorded console."""

    def __init__(self, player: Player) -> None:
        self._player = player

    def states(self) -> tuple[Hosted, ...]:
        """Return the states of these nodes at the position."""
        return self._player.view().hosted


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
