"""What stands for the robot and its station in a replay: it shows, and does nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn, cast

from archo_tui.clock import Clock
from archo_tui.replay.player import Player
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import ACTION, SERVICE, TOPIC, Hosted, Names, NodeInfo, Snapshot
from archo_tui.robot.stops import Stops
from archo_tui.station.alarms import Alarm
from archo_tui.station.station import Station, View

NOTHING_STOPPED = "REPLAY: nothing was stopped"
_NOT_THERE = "not in the recording"


class RecordedRobot:
    """The robot as it was."""

    watching = True

    def __init__(self, player: Player) -> None:
        self._player, self.file, self.stops = player, player.file, Stops()

    @property
    def snapshot(self) -> Snapshot:
        """What was known at the position."""
        return self._player.snapshot()

    def subscribe(self, receiver: Callable[[Snapshot], None]) -> None:
        """It is told once: the time line says when there is something else."""
        receiver(self.snapshot)

    def note(self, *_: Any, **__: Any) -> None:
        """Nothing is added to what was recorded."""

    async def send_no_more(self) -> None:
        """Nothing is sent."""

    async def emergency_stop(self) -> Outcome:
        """Says that there is nothing to stop."""
        return Outcome(Code.REFUSED, NOTHING_STOPPED)

    async def describe(self, node: str) -> NodeInfo | Outcome:
        """What a node published and served, as far as it was recorded."""
        found = self.snapshot.resources

        def having(kind: str) -> Names:
            return tuple(
                (one.name, ", ".join(one.types))
                for one in found
                if one.kind == kind and node in one.nodes
            )

        if not any(node in one.nodes for one in found):
            return Outcome(Code.REFUSED, _NOT_THERE)
        return NodeInfo(
            publishes=having(TOPIC),
            serves=having(SERVICE),
            actions=having(ACTION),
            no_level=_NOT_THERE,
        )

    def __getattr__(self, verb: str) -> NoReturn:
        raise AttributeError(f"a recorded robot does not {verb}")


class RecordedHost:
    """The nodes that the console hosted."""

    def __init__(self, player: Player) -> None:
        self._player = player

    def states(self) -> tuple[Hosted, ...]:
        """As they were."""
        return self._player.view().hosted


class Unwritten:
    """Stands for the journal and the black box."""

    failure = trouble = kept = ""

    def write(self, *_: Any, **__: Any) -> None:
        """Nothing happens in a replay."""

    def look(self, *_: Any) -> None:
        """Nothing happens in a replay."""

    def keep(self, *_: Any) -> Outcome:
        """Refuse: it is kept already."""
        return Outcome(Code.REFUSED, "this is a recording")


class RecordedStation(Station):
    """Shows where the player is."""

    def __init__(self, player: Player, clock: Clock) -> None:
        """`clock` is the machine's: keys are held by it."""
        self.player = player
        nothing: Any = Unwritten()
        super().__init__(
            cast("Any", RecordedRobot(player)),
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

    def take(self, snapshot: Snapshot) -> list[Alarm]:
        """It is so at the position."""
        return self.look()

    def tick(self) -> list[Alarm]:
        """A second has passed."""
        return self.look()

    def look(self) -> list[Alarm]:
        """Show where the player is now; nothing changes by that."""
        self.player.look()
        self.view = self._view()
        return []

    def _view(self) -> View:
        return self.player.view()
