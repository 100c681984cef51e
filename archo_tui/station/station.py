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

from archo_tui.clock import Clock
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Goal, Latch, Snapshot
from archo_tui.robot.stop.gate import HOLDS, UNCERTAIN, UNCONFIRMED
from archo_tui.station.alarm_bell import AlarmBell
from archo_tui.station.alarm_board import AlarmBoard
from archo_tui.station.alarm_conditions import conditions
from archo_tui.station.alarms import STOPPED, Alarm
from archo_tui.station.approval_requests import ApprovalRequests
from archo_tui.station.approvals import Approvals
from archo_tui.station.goal_driver import GoalDriver
from archo_tui.station.history import History
from archo_tui.station.ledger import RELEASE
from archo_tui.station.protocols import Frontend, Recorder
from archo_tui.station.undo import Edit, UndoList
from archo_tui.station.view import View

if TYPE_CHECKING:
    from archo_tui.robot.client import Robot
    from archo_tui.station.journal import Journal
    from archo_tui.user_code.host import Host


_OFFER_AFTER = 5.0  # Seconds in which ARCHO's nodes may appear.
_OFFER = (
    "this robot is not ARCHO, and no --robot names its file: archo-tui robot, "
    "or Describe this robot in the palette (ctrl+p), writes one"
)


class Station:
    """The operator's desk: alarms, queue, history, undo and approvals, whatever shows them.

    It is used on the event loop of its frontend only, but for `post` and `restart`, which may be
    called on any thread, and `earlier_stop`, which any thread may set.

    Attributes:
        robot: The robot, through the console's node.
        host: The host of the nodes in this process.
        clock: The clock of every decision about time.
        recorder: The black box.
        attached: True if the robot lives on without this process.
        on_disconnect: The policy for a running goal at the end: see shutdown.py.
        quiet: True if new alarms ring no bell and send no notification.
        unseen: The rest of the text of the alarm `NO NODES`; "" to raise no such alarm.
        file_is_default: True if no robot file was given, so that ARCHO's is used for any robot.
        bell: The alarms that have rung, kept here so that a restarted screen does not ring again.
        earlier_stop: Unix time of a STOP from before the start that may still hold; None if there
            is none.
        next_namespace: The namespace of the robot to operate after a restart; "" for the same one.
        waiting_restart: Why a restart waits for the release of a STOP and then for a key; "" if
            none does.
        is_restarting: True once the process is about to start again.
        stops_before_restart: STOPs that had been read when the screen began to end for a restart.
        edits: The parameter changes that can be undone.
        goals: Sends goals, one after the other, and cancels them.
        ledger: The requests without an answer.
        queue: The goals that wait.
        requests: The approval requests of assistants.
        approvals: Asks the operator about these requests, and carries out the answers.
        clients: The programs that are connected, by their names for people.
        history: The curves of the last hour, and the goals that ended.
        view: The view to show, as of the last `refresh` or the last change of an alarm here.
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
        attached: bool,
        on_disconnect: str,
        quiet: bool = False,
        unseen: str = "",
        file_is_default: bool = False,
    ) -> None:
        """Create a station without a frontend.

        Args:
            robot: The robot, through the console's node.
            host: The host of the nodes in this process.
            journal: Gets each change of an alarm.
            recorder: Gets each view.
            clock: The clock of every decision about time.
            engine: The engine in words, to be shown.
            namespace: The robot's, to be shown.
            attached: True if the robot lives on without this process.
            on_disconnect: The policy for a running goal at the end: see shutdown.py.
            quiet: True if new alarms ring no bell and send no notification.
            unseen: The rest of the text of the alarm `NO NODES`; "" to raise no such alarm.
            file_is_default: True if no robot file was given.
        """
        self.quiet, self.unseen = quiet, unseen
        self.bell = AlarmBell()
        self.robot, self.host, self.clock = robot, host, clock
        self.attached, self.on_disconnect = attached, on_disconnect
        self.file_is_default = file_is_default
        self._may_offer = attached and file_is_default
        self.next_namespace = self.waiting_restart = ""
        self.is_restarting, self.stops_before_restart = False, 0
        self.earlier_stop: float | None = None
        self.edits = UndoList()
        self.requests = requests = ApprovalRequests()
        self.goals = GoalDriver(
            robot,
            clock,
            self.refresh,
            lambda queued, goal: requests.on_goal_ended(queued.end, goal),
        )
        self.ledger, self.queue = self.goals.ledger, self.goals.queue
        self.approvals = Approvals(requests, robot, clock, self.goals, self.refresh)
        self.clients: tuple[str, ...] = ()
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
        return self.ledger.running_goal(self.robot.snapshot)

    def attach(self, frontend: Frontend) -> None:
        """Let a frontend send goals and run posted work from now on; call it on its event loop.

        Work that was posted before is started. A goal that an earlier frontend did not begin to
        send is dropped.
        """
        self._frontend, self._loop = frontend, asyncio.get_running_loop()
        self.goals.frontend = frontend
        self.ledger.remove_goal()  # A goal that an earlier frontend did not begin to send.
        self._begin_posted()

    def detach(self) -> None:
        """Let posted work wait for the next frontend from now on, since this one ends.

        `close_questions` and `restart` still reach the frontend that ends.
        """
        self._loop = None

    def post(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Let the frontend start work in the background, or the next frontend if none is attached.

        Work is started on the frontend's event loop, in the order of the calls. May be called on
        any thread.
        """
        self._posted.append(work)
        loop = self._loop
        if loop is not None:
            with contextlib.suppress(RuntimeError):  # The loop is closed.
                loop.call_soon_threadsafe(self._begin_posted)

    def _begin_posted(self) -> None:
        while self._posted and self._frontend is not None and self._loop is not None:
            self._frontend.run_in_background(self._posted.popleft())

    def close_questions(self) -> None:
        """Close the questions to the operator, because another console sent a STOP.

        Do nothing without a frontend.
        """
        if self._frontend is not None:
            self._frontend.close_questions()

    def restart(self, why: str) -> None:
        """Have the frontend, if there is one, start the process again with the same arguments.

        The screen does, or lets it wait while there is a `restart_blocker`; `--plain` only logs
        that the changes count from the next start on. May be called on any thread.

        Args:
            why: The reason in words, for the operator.
        """
        if self._frontend is not None:
            self._frontend.restart(why)

    @property
    def restart_blocker(self) -> str:
        """The reason not to start the process again: a STOP would be lost; "" if there is none."""
        snapshot = self.robot.snapshot
        if snapshot.open_stop is not None or not self.robot.stops.are_answered:
            return UNCONFIRMED
        if snapshot.latch is Latch.UNCERTAIN:
            return UNCERTAIN
        return HOLDS if snapshot.is_stopped else ""

    def operate(self, namespace: str) -> None:
        """Set `next_namespace`, and have the frontend, if there is one, start the process again.

        `--plain` does not start again, as told at `restart`.
        """
        self.next_namespace = namespace
        self.restart(f"operate the robot in {namespace}")

    def on_snapshot(self, snapshot: Snapshot) -> list[Alarm]:
        """Take in a new snapshot of the robot, and refresh.

        Questions are closed if another console has sent a STOP since the last snapshot.

        Returns:
            The alarms whose state has changed.
        """
        self._snapshot = snapshot
        self.history.observe(snapshot, self.clock.monotonic())
        if self.robot.stops.sent_elsewhere > self._elsewhere:
            self._elsewhere = self.robot.stops.sent_elsewhere
            self.close_questions()
        return self.refresh()

    def tick(self) -> list[Alarm]:
        """Add a sample to the history, and refresh; called once a second.

        If the robot is not ARCHO and has no robot file, an event offers, once, how to make one.

        Returns:
            The alarms whose state has changed.
        """
        self._second = self.clock.monotonic()
        self.history.add_sample(self._snapshot, self._second)
        self._offer_description()
        return self.refresh()

    def _offer_description(self) -> None:
        """Write an event, once, on how to make a robot file, if that of ARCHO does not fit.

        That is so if no file was given, the robot lives on without this process, and five seconds
        after the start or later its nodes offer none of what ARCHO's offer.
        """
        snapshot = self._snapshot
        is_other = snapshot.nodes and not snapshot.offered
        if is_other and self._may_offer and self.age >= _OFFER_AFTER:
            self._may_offer = False
            self.robot.note("WARN", "console", _OFFER)

    def refresh(self) -> list[Alarm]:
        """Bring alarms, queue, requests and view up to date, and send the goal that is due.

        Changed alarms are written to the journal; the recorder gets the view.

        Returns:
            The alarms whose state has changed.
        """
        now = self.clock.monotonic()
        troubles = self._journal.failure, self.recorder.trouble, self.unseen, self.earlier_stop
        found = conditions(self._snapshot, now, self.host.states(), *troubles)
        # A confirmed release ends the alarm also while the robot reports nothing.
        known_over = () if self._snapshot.is_at_rest else (STOPPED,)
        changed = self._board.update(found, now, self.clock.now(), known_over)
        self._record(changed)
        self.goals.update(self._snapshot, self._board.all())
        self.approvals.close_outdated()
        self.view = self._view()
        self.recorder.on_view(self.view, changed)
        return changed

    async def release(self) -> Outcome:
        """Release the robot after a STOP, so that it accepts moves again; return its answer."""
        with self.ledger.pending(RELEASE):
            return await self.robot.release_emergency_stop()

    def acknowledge(self, alarms: Iterable[Alarm]) -> None:
        """Acknowledge alarms: the operator has seen them. Update the view and the journal.

        An alarm that is acknowledged, shelved or gone already stays as it is.
        """
        for alarm in alarms:
            self._record(self._board.acknowledge(alarm, self.clock.now()))
        self.view = self._view()

    def shelve(self, alarm: Alarm, reason: str = "") -> None:
        """Shelve an alarm for SHELF_TIME, or take it off the shelf if it is there.

        The view and the journal are updated.

        Args:
            alarm: The alarm.
            reason: The reason for shelving it, for the list and the journal.
        """
        times = self.clock.monotonic(), self.clock.now()
        self._record(self._board.shelve(alarm, *times, reason))
        self.view = self._view()

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none, in a way that can be undone.

        Args:
            node: The fully qualified name of the node.
            values: The new values, by name.

        Returns:
            The outcome; NOT_OFFERED if the node does not report one of the parameters.
        """
        return await self.edits.set_parameters(self.robot, node, values)

    async def undo(self, asked: Edit | None) -> Outcome:
        """Undo the last change of parameters.

        Args:
            asked: The change that the operator agreed to undo; None for whichever is the last.

        Returns:
            The outcome; REFUSED if there is no change, or `asked` is not the last one any more.
        """
        return await self.edits.undo(self.robot, asked)

    def _record(self, changed: Iterable[Alarm]) -> None:
        """Write alarms whose state has changed to the journal."""
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
            queue=tuple(self.queue.waiting),
            held=self.queue.hold_reason,
            changing=self.edits.is_changing,
            clients=self.clients,
            requests=self.requests.waiting,
            restart_waits=bool(self.waiting_restart) and not self.is_restarting,
            is_restarting=self.is_restarting,
        )
