"""The operator's station without a screen: snapshots and the time come in, alarms and views go out.

The app with its screen, `--plain`, and a verb that a shell runs without a console sit on it. Each
of them only shows what the station knows, and runs what it sends.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Coroutine, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from archo_tui.clock import Clock
from archo_tui.robot import forms
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.requester import YOU, Requester, current_requester, on_behalf_of
from archo_tui.robot.state import Goal, Snapshot
from archo_tui.robot.stops import NEVER_LEFT, NOT_SENT
from archo_tui.station.alarm_bell import AlarmBell
from archo_tui.station.alarm_board import AlarmBoard
from archo_tui.station.alarm_conditions import conditions
from archo_tui.station.alarms import STOPPED, Alarm
from archo_tui.station.approvals import ApprovalRequest, ApprovalRequests, ApprovalStatus
from archo_tui.station.history import History
from archo_tui.station.ledger import RELEASE, Ledger
from archo_tui.station.protocols import Frontend, Recorder
from archo_tui.station.queue import GoalQueue, QueuedGoal
from archo_tui.station.undo import Edit, UndoList
from archo_tui.station.view import View

if TYPE_CHECKING:
    from archo_tui.hosting.host import Host
    from archo_tui.robot.client import Robot
    from archo_tui.station.journal import Journal


MAX_QUEUED_GOALS = 1000
CALLED_OFF = "called off"
# Attempts to cancel the goal of a requester that has left. Each waits for its answer.
_CANCEL_ATTEMPTS = 3
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
        robot: The robot's side of the ROS graph.
        host: What runs nodes in this process.
        clock: What every decision about time asks.
        recorder: The black box.
        attached: True if the robot lives on without this process.
        on_disconnect: What happens to a running goal at the end: see shutdown.py.
        quiet: True if new alarms ring no bell and send no notification.
        unseen: Where no node was found and what to try; "" if that is no alarm.
        file_is_default: True if no robot file was given, so that ARCHO's is used for any robot.
        bell: What has rung. It is kept here, so that a restarted screen does not ring again.
        earlier_stop: Unix time of a STOP from before the start that may still hold; None if there
            is none.
        next_namespace: The namespace of the robot to operate after a restart; "" for the same one.
        edits: The parameter changes that can be undone.
        ledger: The requests without an answer.
        queue: The goals that wait.
        requests: The approval requests of assistants.
        clients: The programs that are connected, by their names for people.
        history: The curves of the last hour.
        view: What is to be shown now.
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
            robot: The robot's side of the ROS graph.
            host: What runs nodes in this process.
            journal: Gets each change of an alarm.
            recorder: Gets each view.
            clock: What every decision about time asks.
            engine: The engine in words, to be shown.
            namespace: The robot's, to be shown.
            attached: True if the robot lives on without this process.
            on_disconnect: What happens to a running goal at the end: see shutdown.py.
            quiet: True if new alarms ring no bell and send no notification.
            unseen: Where no node was found and what to try, as the alarm's text; "" for no alarm.
            file_is_default: True if no robot file was given.
        """
        self.quiet, self.unseen = quiet, unseen
        self.bell = AlarmBell()
        self.robot, self.host, self.clock = robot, host, clock
        self.attached, self.on_disconnect = attached, on_disconnect
        self.file_is_default = file_is_default
        self._may_offer = attached and file_is_default
        self.next_namespace = ""
        self.earlier_stop: float | None = None
        self.edits = UndoList()
        self.ledger = Ledger()
        self.queue = GoalQueue(self.ledger)
        self._last_hold_reason = ""
        self.requests = ApprovalRequests()
        self.clients: tuple[str, ...] = ()
        self.history = History()
        self._frontend: Frontend | None = None
        self._loop: asyncio.AbstractEventLoop | None = None  # The frontend's.
        self._posted: deque[Callable[[], Coroutine[Any, Any, None]]] = deque()  # Not yet started.
        # The goals that the robot accepted, each with the number of the newest goal before it.
        self._underway: list[tuple[QueuedGoal, int]] = []
        self._journal, self.recorder = journal, recorder
        self._engine, self._namespace = engine, namespace
        self._board = AlarmBoard()
        self._snapshot = Snapshot()
        self._elsewhere = 0  # STOPs of other consoles that closed questions here.
        self._begun = self._second = clock.monotonic()
        self.view = self._view()

    @property
    def age(self) -> float:
        """Seconds since the start of the console, or of the node that was started here last."""
        return self.clock.monotonic() - self._begun

    def node_started(self) -> None:
        """Count `age` anew, since a node that was just started may not be found yet."""
        self._begun = self.clock.monotonic()

    @property
    def running_goal(self) -> Goal | None:
        """Our goal on its way to the robot, else the running goal; None if there is neither."""
        return self.ledger.running_goal(self.robot.snapshot)

    def attach(self, frontend: Frontend) -> None:
        """Let a frontend run what is sent and posted from now on; call it on its event loop."""
        self._frontend, self._loop = frontend, asyncio.get_running_loop()
        self.ledger.remove_goal()  # A goal that an earlier frontend did not begin to send.
        self._begin_posted()

    def detach(self) -> None:
        """Let what is posted from now on wait for the next frontend, as this one ends."""
        self._loop = None

    def post(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Let the frontend start work beside all else; without a frontend, let the next one do so.

        May be called on any thread.
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
        """Close what the operator is being asked: a STOP from elsewhere came in between."""
        if self._frontend is not None:
            self._frontend.close_questions()

    def restart(self, why: str) -> None:
        """End the process and start it again with the same arguments, if there is a frontend.

        May be called on any thread.

        Args:
            why: The reason in words, for the operator.
        """
        if self._frontend is not None:
            self._frontend.restart(why)

    def operate(self, namespace: str) -> None:
        """Start the console again for the robot of another namespace."""
        self.next_namespace = namespace
        self.restart(f"operate the robot in {namespace}")

    def on_snapshot(self, snapshot: Snapshot) -> list[Alarm]:
        """Take in a new snapshot of the robot.

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
        """Take a sample for the history; called once a second.

        Returns:
            The alarms whose state has changed.
        """
        self._second = self.clock.monotonic()
        self.history.add_sample(self._snapshot, self._second)
        self._offer_description()
        return self.refresh()

    def _offer_description(self) -> None:
        """Say once how a robot file is written, if none was given and the robot is not ARCHO."""
        snapshot = self._snapshot
        is_other = snapshot.nodes and not snapshot.offered
        if is_other and self._may_offer and self.age >= _OFFER_AFTER:
            self._may_offer = False
            self.robot.note("WARN", "console", _OFFER)

    def refresh(self) -> list[Alarm]:
        """Bring alarms, queue, requests and view up to date, and send the goal that is due.

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
        self._settle_ended_goals()
        self._send_due_goal()
        self._close_outdated_requests(now)
        self.view = self._view()
        self.recorder.on_view(self.view, changed)
        return changed

    async def call_off(self, requester: Requester) -> None:
        """Remove the goals of a requester that has left from the queue, and cancel its running one.

        If the goal cannot be cancelled, an event says that it may still run.
        """
        for goal in self.queue.remove_requested_by(requester):
            _set_outcome(goal, Outcome(Code.CANCELLED, f"taken out of the queue: {goal.text}"))
        self.refresh()
        for _ in range(_CANCEL_ATTEMPTS):
            if not self._has_goal_underway(requester):
                return
            with on_behalf_of(requester):
                outcome = await self.cancel()
            if outcome.ok:
                return
        if self._has_goal_underway(requester):
            text = f"the goal of {requester.source}, which has left, may still run: {outcome.text}"
            self.robot.note("ERROR", "console", text)

    def _has_goal_underway(self, requester: Requester) -> bool:
        return any(goal.requester is requester for goal, _ in self._underway)

    @property
    def _busy_reason(self) -> str:
        """The reason why an assistant cannot ask for a goal now; "" if it can."""
        snapshot = self._snapshot
        if snapshot.is_stopped:
            return "the robot is stopped"
        if snapshot.running_goal is not None or self._underway:
            return "another goal runs"
        if self.queue.waiting:
            return "goals wait in the queue"
        return "another goal is being sent" if self.queue.is_going else ""

    def _close_outdated_requests(self, now: float) -> None:
        stop_count = self.robot.stops.count + self.robot.stops.sent_elsewhere
        for request in self.requests.close_outdated(now, stop_count, self._busy_reason):
            text = f"request {request.number} is {request.status.value}, {request.reason}"
            self.robot.note("WARN", "console", f"{text}: {request.text}")

    def request_approval(self, goal: QueuedGoal, text: str) -> ApprovalRequest:
        """Ask a person at this console to allow a goal of the assistant that asks now.

        Args:
            goal: What is sent if the person allows it.
            text: The goal in words, as `go to shelf 12`.

        Raises:
            ValueError: The goal cannot be asked for now; the text says why.
        """
        if self._frontend is None or not self._frontend.has_person:
            raise ValueError("nobody can allow it: this console has no screen and no terminal")
        if self.robot.snapshot.is_stopped:
            raise ValueError("the robot is stopped: a person has to release it first")
        if self._busy_reason:
            raise ValueError(f"{self._busy_reason}: wait until it has ended")
        requester, stop_count = current_requester(), self.robot.stops.count_when_typed
        if requester.has_left or self.robot.stops.is_void(stop_count):
            raise ValueError(NOT_SENT)
        stop_count += self.robot.stops.sent_elsewhere
        request = self.requests.add(requester, goal, text, self.clock.monotonic(), stop_count)
        record = AuditRecord(
            "request", {"request": request.number, "values": goal.values}, Code.ACCEPTED
        )
        asked = f"asks: {text} (request {request.number})"
        self.robot.note(requester.level, requester.source, asked, audit_record=record)
        self.refresh()
        return request

    def withdraw_requests(self, requester: Requester) -> str:
        """Close the requests of an assistant that wait for a person.

        Returns:
            Their goals in words; "" if there was none.
        """
        withdrawn = [request for request in self.requests.waiting if request.requester is requester]
        for request in withdrawn:
            reason = "the assistant has withdrawn it"
            self.requests.close(request.number, ApprovalStatus.VOID, reason)
        self.refresh()
        return ", ".join(request.text for request in withdrawn)

    def answer_request(self, number: int, *, allowed: bool) -> Outcome:
        """Carry out what a person has decided: an allowed goal is sent at once, and only once.

        Args:
            number: The request's.
            allowed: False if the person denied it.

        Returns:
            DONE with the decision in words; else why the request can no longer be answered so.
        """
        self.refresh()
        request = self.requests.get(number)
        if request is None:
            return Outcome(Code.REFUSED, f"there is no request {number}")
        if request.status != ApprovalStatus.WAITING:
            return Outcome(Code.REFUSED, f"request {number} is {request.status.value}")
        if allowed and self.robot.stops.gate().is_shut:
            return Outcome(Code.CANCELLED, NOT_SENT)
        action = request.goal.kind.action
        refusal = self._snapshot.unavailable(action) or self._range_error(request.goal)
        if allowed and refusal:
            return Outcome(Code.REFUSED, refusal)
        if allowed:
            self.requests.close(number, ApprovalStatus.ALLOWED)
        else:
            self.requests.deny(number, self.clock.monotonic())
        verb, word = ("allow", "allowed") if allowed else ("deny", "denied")
        record = AuditRecord(verb, {"request": number}, Code.DONE)
        text = f"{word} request {number} of {request.requester.source}: {request.text}"
        self.robot.note(YOU.level, YOU.source, text, audit_record=record)
        if allowed:
            # The ends of its earlier goals are in the hands of those that wait for them.
            ends = request.requester.ends = []
            with on_behalf_of(request.requester):
                answer = self.drive([request.goal])
            self.requests.on_sent(number, ends[0] if ends else answer)
        self.refresh()
        return Outcome(Code.DONE, text)

    def _range_error(self, goal: QueuedGoal) -> str:
        """Return which value of a goal is beyond a limit of the robot; "" if none is."""
        fields = self._snapshot.forms.get(goal.kind.id) or ()
        try:
            forms.check_ranges(fields, self._snapshot.form(goal.kind), goal.values)
        except ValueError as error:
            return str(error)
        return ""

    def goal_of(self, requester: Requester) -> Goal | None:
        """Return the present state of the goal underway of a requester; None if it has none."""
        befores = [before for goal, before in self._underway if goal.requester is requester]
        return self._goal_after(befores[0]) if befores else None

    def _goal_after(self, before: int) -> Goal | None:
        """Return the first goal of this console whose number is over `before`."""
        snapshot = self._snapshot
        ours = [goal for goal in (snapshot.goal, *snapshot.history) if goal and goal.mine]
        since = [goal for goal in ours if goal.number > before]
        return min(since, key=lambda goal: goal.number, default=None)

    def _settle_ended_goals(self) -> None:
        """Give those that wait for a goal its outcome, for each goal that has ended."""
        for queued, before in list(self._underway):
            goal = self._goal_after(before)
            outcome = None if goal is None else goal.outcome_at(self.clock.monotonic())
            if goal is not None and outcome is not None:
                self._underway.remove((queued, before))
                queued.requester.goal = goal
                self.requests.on_goal_ended(queued.end, goal)
                _set_outcome(queued, outcome)

    def _send_due_goal(self) -> None:
        """Send the goal of the queue that is due, and write an event when the queue is held."""
        due = self.queue.take_due(self._snapshot, self._board.all(), self.robot.stops.count)
        before, self._last_hold_reason = self._last_hold_reason, self.queue.hold_reason
        reason = self.queue.hold_reason
        if reason and not before:
            texts = ", ".join(goal.text for goal in self.queue.waiting)
            self.robot.note("WARN", "console", f"queue held: {texts} ({reason})")
        for goal in self.queue.waiting if reason else ():
            _set_outcome(goal, Outcome(Code.HELD, f"held: {goal.text} ({reason})"))
        if due is not None:
            self._drive(due)

    def drive(self, goals: Sequence[QueuedGoal]) -> asyncio.Future[Outcome]:
        """Send goals one after the other, behind a goal that runs or is being sent.

        They belong to whoever asks now (see robot/requester.py). Call it on the event loop.

        Args:
            goals: At least one.

        Returns:
            A future of the robot's answer to the first goal; ACCEPTED at once if that waits in
            the queue, CANCELLED or REFUSED if nothing is sent.
        """
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Outcome] = loop.create_future()
        if current_requester().has_left:
            answer.set_result(Outcome(Code.CANCELLED, CALLED_OFF))
            return answer
        if len(self.queue.waiting) + len(goals) > MAX_QUEUED_GOALS:
            text = f"more than {MAX_QUEUED_GOALS} goals would wait"
            answer.set_result(Outcome(Code.REFUSED, text))
            return answer
        stop_count, requester = self.robot.stops.count_when_typed, current_requester()
        if requester is not YOU:
            goals = [goal._replace(requester=requester, end=loop.create_future()) for goal in goals]
            requester.ends += [goal.end for goal in goals if goal.end is not None]
        goals = [goal._replace(stop_count=stop_count) for goal in goals]
        first = self.queue.submit(goals, self._snapshot)
        if first is None:
            held = f", held: {self.queue.hold_reason}" if self.queue.hold_reason else ""
            answer.set_result(Outcome(Code.ACCEPTED, f"queued{held}"))
        else:
            self._drive(first, answer)
        self.refresh()
        return answer

    def resume(self) -> Outcome:
        """Resume a held queue, unless a STOP came in between.

        Returns:
            DONE; REFUSED if the queue is held again at once, because the cause is not over.
        """
        gate = self.robot.stops.gate()
        outcome = Outcome(Code.CANCELLED, NOT_SENT) if gate.is_shut else Outcome(Code.DONE, "")
        if outcome.ok:
            self.queue.resume(gate.count_when_typed)
            self.queue.waiting = list(map(_with_pending_end, self.queue.waiting))
            self.refresh()
            if self.queue.hold_reason:
                outcome = Outcome(Code.REFUSED, f"still held: {self.queue.hold_reason}")
        more = f": {outcome.text}" if outcome.text else ""
        record = AuditRecord("continue", {}, outcome.code)
        self.robot.note("YOU", "console", f"continue the queue{more}", audit_record=record)
        return outcome

    def skip(self) -> Outcome:
        """Remove the next goal of the queue, which must not be empty."""
        goal = self.queue.skip_next()
        text = f"left out of the queue: {goal.text}"
        _set_outcome(goal, Outcome(Code.CANCELLED, text))
        self.robot.note("YOU", "console", text, audit_record=AuditRecord("skip", {}, Code.DONE))
        self.refresh()
        return Outcome(Code.DONE, f"left out: {goal.text}")

    def _drive(self, goal: QueuedGoal, answer: asyncio.Future[Outcome] | None = None) -> None:
        """Let the frontend send a goal.

        Args:
            goal: The goal, which the ledger has.
            answer: Gets the robot's answer; None for a goal of the queue, which nobody waits for.
        """
        assert self._frontend is not None  # Nothing is due without a frontend.
        before = self.ledger.newest_before
        self._frontend.carry_out(partial(self._send, self._frontend, goal, before, answer))

    async def _send(
        self,
        frontend: Frontend,
        goal: QueuedGoal,
        before: int,
        answer: asyncio.Future[Outcome] | None,
    ) -> None:
        """Send a goal and take in the robot's answer; a STOP puts it back into the queue.

        Args:
            frontend: Shows the answer to a goal of the queue.
            goal: The goal.
            before: The number of the newest goal before it.
            answer: As for `_drive`.
        """
        is_queued = answer is None
        if self.ledger.is_cancelled:
            outcome = Outcome(Code.CANCELLED, NEVER_LEFT)
        else:
            self.ledger.is_handed_over = True
            try:
                with self.robot.stops.typed_at(goal.stop_count), on_behalf_of(goal.requester):
                    outcome = await self.robot.send(goal.kind, goal.values, queued=is_queued)
            except asyncio.CancelledError:
                # The screen ends. The next one learns of the goal by its snapshot.
                self.ledger.remove_goal()
                raise
        if outcome.code == Code.HELD:
            self.queue.put_back(goal)
        else:
            is_cancelled = outcome.code == Code.CANCELLED
            self.queue.on_answer(ok=outcome.ok, reason="cancelled" if is_cancelled else "refused")
            if outcome.ok:
                self._underway.append((goal, before))
                self._settle_ended_goals()
                if goal.requester.has_left:  # While the goal was being sent.
                    await self.call_off(goal.requester)
            else:
                _set_outcome(goal, outcome)
        if answer is None:
            frontend.on_goal_answered(goal, outcome)
        elif not answer.done():
            answer.set_result(outcome)
        if outcome.code == Code.TIMEOUT and (goal.requester.waits or goal.requester.has_left):
            # The robot may still accept the goal, and nobody would wait for its end then.
            with on_behalf_of(goal.requester):
                await self.cancel()

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Cancel the goal of this console, on its way or running.

        Args:
            another: True to cancel the running goal of another client, not one of this console.
        """
        if self.ledger.goal is None or self.ledger.is_handed_over:
            return await self.robot.cancel(another=another)
        self.ledger.is_cancelled = True
        outcome = Outcome(Code.ACCEPTED, NEVER_LEFT)
        record = AuditRecord("cancel", {}, outcome.code)
        self.robot.note("YOU", "console", f"cancel: {outcome.text}", audit_record=record)
        return outcome

    async def release(self) -> Outcome:
        """Release the robot after a STOP, so that it accepts moves again."""
        with self.ledger.pending(RELEASE):
            return await self.robot.release_emergency_stop()

    def acknowledge(self, alarms: Iterable[Alarm]) -> None:
        """Acknowledge alarms: the operator has seen them."""
        for alarm in alarms:
            self._record(self._board.acknowledge(alarm, self.clock.now()))
        self.view = self._view()

    def shelve(self, alarm: Alarm, reason: str = "") -> None:
        """Shelve an alarm for SHELF_TIME, or take it off the shelf if it is there.

        Args:
            alarm: The alarm.
            reason: Why it is shelved, for the list and the journal.
        """
        times = self.clock.monotonic(), self.clock.now()
        self._record(self._board.shelve(alarm, *times, reason))
        self.view = self._view()

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none, in a way that can be undone.

        Args:
            node: The fully qualified name of the node.
            values: The new values, by name.
        """
        return await self.edits.set_parameters(self.robot, node, values)

    async def undo(self, asked: Edit | None) -> Outcome:
        """Undo the last change of parameters.

        Args:
            asked: The change that the operator agreed to undo; None for whichever is the last.
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
        )


def _with_pending_end(goal: QueuedGoal) -> QueuedGoal:
    """Return a resumed goal with a new future of its end, if holding it has set the old one.

    In the list of its requester the new future takes the old one's place.
    """
    if goal.end is None or not goal.end.done():
        return goal
    pending = goal.end.get_loop().create_future()
    ends = goal.requester.ends
    ends[:] = [pending if end is goal.end else end for end in ends]
    return goal._replace(end=pending)


def _set_outcome(goal: QueuedGoal, outcome: Outcome) -> None:
    """Give those that wait for a goal its outcome."""
    if goal.end is not None and not goal.end.done():
        goal.end.set_result(outcome)
