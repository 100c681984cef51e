"""The operator's station without a screen: snapshots and the time come in, alarms and views go out.

The app with its screen, `--plain`, and a verb that a shell runs without a console sit on it. Each
of them only shows what the station knows, and runs what it sends.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Coroutine, Iterable
from typing import TYPE_CHECKING, Any

from archo_tui.base.clock import Clock
from archo_tui.robot.goals.queue import GoalQueue
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.robot.stop.gate import HOLDS, OPEN_STOP, UNCERTAIN
from archo_tui.station.alarms import Alarm, AlarmBell, AlarmBoard, holding
from archo_tui.station.approvals import Approvals
from archo_tui.station.conditions import STOPPED, Situation, conditions
from archo_tui.station.goal_driver import Frontend, GoalDriver
from archo_tui.station.history import History
from archo_tui.station.places import Places
from archo_tui.station.undo import Edit, UndoList
from archo_tui.station.view import Recorder, View

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot
    from archo_tui.station.journal import Journal
    from archo_tui.user_code.host import Host


_OFFER_AFTER = 5.0  # Seconds in which ARCHO's nodes may appear.
_OFFER = (
    "this robot is not ARCHO, and no --robot names its file: archo-tui robot, "
    "or Describe this robot in the palette (ctrl+p), writes one"
)


class Station:
    """The operator's desk, used on the event loop of its frontend.

    Only `post`, `restart` and `earlier_stop` are for any thread.
    """

    def __init__(
        self,
        robot: Robot,
        host: Host,
        journal: Journal,
        recorder: Recorder,
        clock: Clock,
        *,
        engine: str,
        namespace: str,
        attached: bool,  # The robot lives on without this process.
        on_disconnect: str,  # The policy for a running goal: see shutdown.py.
        quiet: bool = False,  # New alarms ring no bell.
        unseen: str = "",  # The rest of the text of the alarm `NO NODES`; "" for no such alarm.
        file_is_default: bool = False,  # ARCHO's file is used for any robot.
        places: Places | None = None,  # None: those of the robot file.
    ) -> None:
        self.quiet, self.unseen = quiet, unseen
        self.bell = AlarmBell()  # Here, so that a restarted screen does not ring again.
        self.robot, self.host, self.clock = robot, host, clock
        self.attached, self.on_disconnect = attached, on_disconnect
        self.file_is_default = file_is_default
        self._may_offer = attached and file_is_default
        # Why a restart waits for a release and then a key; "" if none does.
        self.waiting_restart = ""
        # STOPs read when the screen began to end for a restart.
        self.is_restarting, self.stops_before_restart = False, 0
        # Unix time of one from before the start that may still hold.
        self.earlier_stop: float | None = None
        self.edits = UndoList()
        self.goals = GoalDriver(
            robot,
            clock,
            self.refresh,
            lambda end, goal: self.approvals.on_goal_ended(end, goal),
        )
        self.places = places or Places(robot.file)
        self._releases = 0
        self.approvals = Approvals(robot, clock, self.goals, self.refresh)
        self.clients: tuple[str, ...] = ()  # The connected programs.
        self.history = History()
        self._frontend: Frontend | None = None
        self._loop: asyncio.AbstractEventLoop | None = None  # The frontend's.
        self._posted: deque[Callable[[], Coroutine[Any, Any, None]]] = deque()  # Not yet started.
        self._journal, self.recorder = journal, recorder
        self._engine, self._namespace = engine, namespace
        self._board = AlarmBoard()
        self._snapshot = Snapshot()
        self._elsewhere = 0  # STOPs of other consoles that closed questions here.
        self._begun = self._second = clock.monotonic()
        self.view = self._view()

    @property
    def age(self) -> float:
        """Seconds since the start of the console, or since `node_started` was last called."""
        return self.clock.monotonic() - self._begun

    def node_started(self) -> None:
        """Restart the `age` of the station from 0: a node just started may not be found yet."""
        self._begun = self.clock.monotonic()

    @property
    def running_goal(self) -> Goal | None:
        """Our goal on its way to the robot, else the running goal; None if there is neither."""
        return self.queue.running_goal(self.robot.snapshot)

    @property
    def queue(self) -> GoalQueue:
        """The goals that are wanted and not settled yet."""
        return self.goals.queue

    @property
    def is_releasing(self) -> bool:
        """True while a release of the robot has no answer yet."""
        return self._releases > 0

    def attach(self, frontend: Frontend) -> None:
        """Let a frontend send goals and run posted work from now on; call it on its event loop."""
        self._frontend, self._loop = frontend, asyncio.get_running_loop()
        self.goals.attach(frontend)
        self._begin_posted()

    def detach(self) -> None:
        """Let posted work wait for the next frontend from now on, since this one ends."""
        self._loop = None

    def post(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Let the present or next frontend start work in the background. Any thread."""
        self._posted.append(work)
        loop = self._loop
        if loop is not None:
            with contextlib.suppress(RuntimeError):  # The loop is closed.
                loop.call_soon_threadsafe(self._begin_posted)

    def _begin_posted(self) -> None:
        while self._posted and self._frontend is not None and self._loop is not None:
            self._frontend.run_in_background(self._posted.popleft())

    def close_questions(self) -> None:
        """Close the questions to the operator, because another console sent a STOP."""
        if self._frontend is not None:
            self._frontend.close_questions()

    def restart(self, why: str) -> None:
        """Have the frontend, if there is one, start the process again. Any thread."""
        if self._frontend is not None:
            self._frontend.restart(why)

    @property
    def restart_blocker(self) -> str:
        """The reason not to start the process again: a STOP would be lost; "" if there is none."""
        snapshot = self.robot.snapshot
        if snapshot.open_stop is not None or not self.robot.stops.are_answered:
            return OPEN_STOP
        if snapshot.latch is Latch.UNCERTAIN:
            return UNCERTAIN
        return HOLDS if snapshot.is_stopped else ""

    def on_snapshot(self, snapshot: Snapshot) -> list[Alarm]:
        """Take in a new snapshot, and refresh; return the alarms whose state has changed."""
        self._snapshot = snapshot
        self.history.observe(snapshot, self.clock.monotonic())
        if self.robot.stops.sent_elsewhere > self._elsewhere:
            self._elsewhere = self.robot.stops.sent_elsewhere
            self.close_questions()
        return self.refresh()

    def tick(self) -> list[Alarm]:
        """Go on with the history, and refresh, once a second; return the changed alarms."""
        self._second = self.clock.monotonic()
        self.history.observe(self._snapshot, self._second)
        self._offer_description()
        return self.refresh()

    def _offer_description(self) -> None:
        """Write an event, once, on how to make a robot file, if that of ARCHO does not fit."""
        snapshot = self._snapshot
        is_other = snapshot.nodes and not snapshot.offered
        if is_other and self._may_offer and self.age >= _OFFER_AFTER:
            self._may_offer = False
            self.robot.note("WARN", "console", _OFFER)

    def refresh(self) -> list[Alarm]:
        """Update alarms, queue, requests and view, and send the goal that is due."""
        now = self.clock.monotonic()
        troubles = self._journal.failure, self.recorder.trouble, self.unseen, self.earlier_stop
        found = conditions(Situation(self._snapshot, now, self.host.states(), *troubles))
        # A confirmed release ends the alarm also while the robot reports nothing.
        is_stopped = self._snapshot.is_at_rest or self._snapshot.runs_on
        known_over = () if is_stopped else (STOPPED,)
        changed = self._board.update(found.texts, now, self.clock.now(), known_over, found.unknown)
        self._record(changed)
        self.goals.update(self._snapshot, holding(self._board.all()))
        self.approvals.close_outdated()
        self.view = self._view()
        self.recorder.on_view(self.view, changed)
        return changed

    async def release(self) -> Outcome:
        """Release the robot after a STOP, so that it accepts moves again; return its answer."""
        self._releases += 1
        try:
            return await self.robot.release_emergency_stop()
        finally:
            self._releases -= 1

    def acknowledge(self, alarms: Iterable[Alarm]) -> None:
        """Acknowledge alarms: the operator has seen them. Update the view and the journal."""
        for alarm in alarms:
            self._record(self._board.acknowledge(alarm, self.clock.now()))
        self.view = self._view()

    def shelve(self, alarm: Alarm, reason: str = "") -> None:
        """Shelve an alarm, or take it off the shelf; update the view and the journal."""
        times = self.clock.monotonic(), self.clock.now()
        self._record(self._board.shelve(alarm, *times, reason))
        self.view = self._view()

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none, in a way that can be undone."""
        return await self.edits.set_parameters(self.robot, node, values)

    async def undo(self, asked: Edit | None) -> Outcome:
        """Undo the last change of parameters; REFUSED if that is not the one `asked`, if given."""
        return await self.edits.undo(self.robot, asked)

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
            self.history,
            self._board.all(),
            self.host.states(),
            watching=self.robot.watching,
            queue=self.queue.waiting,
            held=self.queue.hold_reason,
            clients=self.clients,
            requests=self.approvals.waiting,
            restart_waits=bool(self.waiting_restart) and not self.is_restarting,
            is_restarting=self.is_restarting,
            publishes=tuple(each.text for each in self.robot.publications.active),
        )
