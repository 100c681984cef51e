"""The operator's station without a screen: snapshots and the time in, alarms and views out.

The console's app and `--plain` both sit on it; each only shows what it says.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from archo_tui.alarms import Alarm, AlarmBoard, Ringer, conditions
from archo_tui.clock import Clock
from archo_tui.history import History
from archo_tui.parameters.undo import UndoList
from archo_tui.robot.state import Hosted, Outcome, Snapshot
from archo_tui.robot.stops import HELD, NOT_SENT
from archo_tui.targets import Target, Targets

if TYPE_CHECKING:
    from archo_tui.host import Host
    from archo_tui.journal import Journal
    from archo_tui.robot.client import Robot


@dataclass(frozen=True)
class View:
    """One moment, as it is shown."""

    snapshot: Snapshot
    now: float  # monotonic s
    second: float  # the same, at the last tick of the clock: for ages that need not be livelier
    time: float  # Unix time
    engine: str
    namespace: str
    history: History
    alarms: tuple[Alarm, ...] = ()
    hosted: tuple[Hosted, ...] = ()  # the nodes of this process
    watching: bool = False  # nothing is commanded from here
    waiting: tuple[str, ...] = ()  # targets of the queue
    held: str = ""  # why the queue is held
    changing: bool = False  # a parameter is being set from here


class Face(Protocol):
    """What shows the station to its operator, and runs its work: the app, or `--plain`."""

    def carry_out(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Begin it, on the loop."""

    def goal_answered(self, target: Target, outcome: Outcome, *, queued: bool) -> None:
        """How the robot answered a goal that was sent; `queued`: it came from the queue."""

    def restart(self, why: str) -> None:
        """End, and begin again with the same words; called from any thread."""


class Station:
    """Keeps the alarms and what can be undone, whatever shows them."""

    def __init__(
        self,
        robot: Robot,
        host: Host,
        journal: Journal,
        clock: Clock,
        *,
        engine: str,
        namespace: str,
        attached: bool,
        on_disconnect: str,
        quiet: bool = False,
    ) -> None:
        """`attached`: the robot lives on without this process; `on_disconnect`: see shutdown.py.

        `quiet`: new alarms are shown, and neither rung nor told to the desktop.
        """
        self.quiet = quiet
        self.ringer = Ringer()  # here, for a screen that was started anew does not ring again
        self.robot, self.host, self.clock = robot, host, clock
        self.attached, self.on_disconnect = attached, on_disconnect
        self.edits = UndoList()
        self.targets = Targets()
        self._history = History()
        self._face: Face | None = None
        self._journal = journal
        self._engine, self._namespace = engine, namespace
        self._board = AlarmBoard()
        self._snapshot = Snapshot()
        self._second = clock.monotonic()
        self.view = self._view()

    def run_on(self, face: Face) -> None:
        """From now on this face runs what is sent, and hears what comes of it."""
        self._face = face

    def restart(self, why: str) -> None:
        """End, and begin again with the same words, once there is a face; from any thread."""
        if self._face is not None:
            self._face.restart(why)

    def take(self, snapshot: Snapshot) -> list[Alarm]:
        """Something was heard. Returns the alarms that changed."""
        self._snapshot = snapshot
        return self.look()

    def tick(self) -> list[Alarm]:
        """A second has passed. Returns the alarms that changed."""
        self._second = self.clock.monotonic()
        self._history.add(self._snapshot, self._second)
        return self.look()

    def look(self) -> list[Alarm]:
        """Bring alarms and view up to the time it is now. Returns the alarms that changed."""
        now = self.clock.monotonic()
        found = conditions(self._snapshot, now, self.host.states(), self._journal.failure)
        changed = self._board.update(found, now, self.clock.now())
        self._record(changed)
        self._advance()
        self.view = self._view()
        return changed

    def _advance(self) -> None:
        """Send what is due in the queue, and say when it is held."""
        held = self.targets.held
        due = self.targets.next(self._snapshot, self._board.all(), self.robot.stops.count)
        if self.targets.held and not held:
            texts = ", ".join(target.text for target in self.targets.waiting)
            said = f"queue held: {texts} ({self.targets.held})"
            self.robot.note("WARN", "console", said)
        if due is not None:
            self._drive(due, queued=True)

    def submit(self, targets: Sequence[Target]) -> None:
        """Drive these, one after the other; behind what runs or is being sent."""
        stops = self.robot.stops.carried
        targets = [target._replace(stops=stops) for target in targets]
        first = self.targets.submit(targets, self._snapshot)
        if first is not None:
            self._drive(first, queued=False)
        self.look()

    def resume(self) -> Outcome:
        """Continue a held queue."""
        gate = self.robot.stops.gate()
        outcome = Outcome(False, NOT_SENT) if gate.is_shut else Outcome(True, "")
        if outcome.ok:
            self.targets.resume(gate.typed)
        said = f": {outcome.text}" if outcome.text else ""
        self.robot.note("YOU", "console", f"continue the queue{said}")
        self.look()
        return outcome

    def drop(self) -> None:
        """Leave out the next target of the queue."""
        text = self.targets.waiting[0].text
        self.targets.drop()
        self.robot.note("YOU", "console", f"left out of the queue: {text}")
        self.look()

    def _drive(self, target: Target, *, queued: bool) -> None:
        assert self._face is not None  # nothing is due before there is one
        self._face.carry_out(partial(self._send, self._face, target, queued))

    async def _send(self, face: Face, target: Target, queued: bool) -> None:
        """Send a goal; from the queue not behind a STOP."""
        with self.robot.stops.at(target.stops):
            outcome = await self.robot.send(target.kind, target.values, queued=queued)
        if queued and outcome.text in (NOT_SENT, HELD):
            self.targets.not_sent(target)
        else:
            self.targets.answered(ok=outcome.ok)
        face.goal_answered(target, outcome, queued=queued)

    def acknowledge(self, alarms: Iterable[Alarm]) -> None:
        """The operator has seen these alarms."""
        for alarm in alarms:
            self._record(self._board.acknowledge(alarm, self.clock.now()))
        self.view = self._view()

    def shelve(self, alarm: Alarm, reason: str = "") -> None:
        """Silence an alarm for a while and say why, or take it off the shelf."""
        times = self.clock.monotonic(), self.clock.now()
        self._record(self._board.shelve(alarm, *times, reason))
        self.view = self._view()

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none; what was done can be undone."""
        return await self.edits.set_parameters(self.robot, node, values)

    async def undo(self) -> Outcome:
        """Take the last change of a parameter back."""
        return await self.edits.undo(self.robot)

    def _record(self, changed: Iterable[Alarm]) -> None:
        for alarm in changed:
            what = {"name": alarm.name, "state": alarm.state.value, "text": alarm.text}
            if alarm.reason:
                what["reason"] = alarm.reason
            now = self.clock.now()
            self._journal.write(now, "alarm", priority=alarm.priority.name, **what)

    def _view(self) -> View:
        return View(
            self._snapshot,
            self.clock.monotonic(),
            self._second,
            self.clock.now(),
            self._engine,
            self._namespace,
            self._history,
            self._board.all(),
            self.host.states(),
            watching=self.robot.watching,
            waiting=tuple(target.text for target in self.targets.waiting),
            held=self.targets.held,
            changing=self.edits.is_changing,
        )
