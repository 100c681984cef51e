"""The operator's station without a screen: snapshots and the time in, alarms and views out.

The console's app and `--plain` both sit on it; each only shows what it says.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Coroutine, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from archo_tui.clock import Clock
from archo_tui.robot import forms
from archo_tui.robot.acts import Act
from archo_tui.robot.asker import YOU, Asker, asked_by, asking
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import Goal, Hosted, Snapshot
from archo_tui.robot.stops import NEVER_LEFT, NOT_SENT
from archo_tui.station.alarm_conditions import conditions
from archo_tui.station.alarms import STOPPED, Alarm, AlarmBell, AlarmBoard
from archo_tui.station.history import History
from archo_tui.station.ledger import RELEASE, Ledger
from archo_tui.station.queue import GoalQueue, QueuedGoal
from archo_tui.station.requests import Request, Requests, Stand
from archo_tui.station.undo import Edit, UndoList

if TYPE_CHECKING:
    from archo_tui.hosting.host import Host
    from archo_tui.robot.client import Robot
    from archo_tui.station.journal import Journal


MOST_GOALS = 1000  # that wait in the queue
CALLED_OFF = "called off"
_CANCELS = 3  # times that a goal is asked to end whose sender has left, each waits for its answer


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
    queue: tuple[QueuedGoal, ...] = ()  # what waits, the next one first
    held: str = ""  # why the queue is held
    changing: bool = False  # a parameter is being set from here
    clients: tuple[str, ...] = ()  # the programs that are connected
    requests: tuple[Request, ...] = ()  # of assistants, that wait for a person
    replay: str = ""  # that it is a recording, and of when; empty: it is the robot

    @property
    def waiting(self) -> tuple[str, ...]:
        """The goals of the queue, as they are called."""
        return tuple(wanted.text for wanted in self.queue)


class Frontend(Protocol):
    """What shows the station to its operator, and runs its work: the app, or `--plain`."""

    def carry_out(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Begin it, on the loop."""

    def beside(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Begin it, on the loop; the end does not wait for it."""

    def goal_answered(self, wanted: QueuedGoal, outcome: Outcome) -> None:
        """How the robot answered a goal of the queue: nobody waits for that one's answer."""

    @property
    def has_person(self) -> bool:
        """True where somebody sees what is asked, and can answer."""

    def ask_no_more(self) -> None:
        """A STOP came from elsewhere: what is being asked is not to be answered behind it."""

    def restart(self, why: str) -> None:
        """End, and begin again with the same words; called from any thread."""


class Recorder(Protocol):
    """The black box, as the station sees it."""

    @property
    def trouble(self) -> str:
        """What the operator is to know of it, or an empty string."""

    def look(self, view: View, changed: Sequence[Alarm]) -> None:
        """So it is now; these alarms have changed."""

    @property
    def kept(self) -> str:
        """The name of the last recording on the disk that was begun by hand; empty: none is."""

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Begin to record the last minute by hand; call it on the loop.

        Args:
            written: Is called on the loop when the recording is on the disk, or cannot be written.

        Returns:
            What is recorded, or why nothing is: `written` is called only for the former.
        """


class Station:
    """Keeps the alarms and what can be undone, whatever shows them."""

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
        """`attached`: the robot lives on without this process; `on_disconnect`: see shutdown.py.

        `quiet`: new alarms are shown, and neither rung nor told to the desktop. `unseen`: where
        no node is, when none is found, and what to try; empty: nobody asks. `file_is_default`: no
        robot file was given, so ARCHO's is used, whatever robot is there.
        """
        self.quiet, self.unseen = quiet, unseen
        self.bell = AlarmBell()  # here, for a screen that was started anew does not ring again
        self.robot, self.host, self.clock = robot, host, clock
        self.attached, self.on_disconnect = attached, on_disconnect
        self.file_is_default = file_is_default
        self.earlier_stop: float | None = None  # Unix time of one that may hold; any thread sets it
        self.edits = UndoList()
        self.ledger = Ledger()
        self.queue = GoalQueue(self.ledger)
        self._held = ""  # why it was held at the last look
        self.requests = Requests()
        self.clients: tuple[str, ...] = ()  # the programs that are connected
        self.history = History()
        self._frontend: Frontend | None = None
        self._loop: asyncio.AbstractEventLoop | None = None  # the frontend's
        self._posted: deque[Callable[[], Coroutine[Any, Any, None]]] = deque()  # not begun yet
        # goals that the robot accepted, each with the number of the goal before it
        self._underway: list[tuple[QueuedGoal, int]] = []
        self._journal, self.recorder = journal, recorder
        self._engine, self._namespace = engine, namespace
        self._board = AlarmBoard()
        self._snapshot = Snapshot()
        self._elsewhere = 0  # STOPs of other consoles that were told of
        self._begun = self._second = clock.monotonic()
        self.view = self._view()

    @property
    def age(self) -> float:
        """How long the console, or the node that was started here last, has been there, in s."""
        return self.clock.monotonic() - self._begun

    def node_started(self) -> None:
        """A node was started here: like the robot at the start it may not be found yet."""
        self._begun = self.clock.monotonic()

    @property
    def running_goal(self) -> Goal | None:
        """Our goal on its way to the robot, else the one that runs."""
        return self.ledger.running_goal(self.robot.snapshot)

    def run_on(self, frontend: Frontend) -> None:
        """From now on this frontend runs what is sent, and hears what comes of it."""
        self._frontend, self._loop = frontend, asyncio.get_running_loop()
        self.ledger.drop()  # what a frontend before it did not begin to send is not on its way
        self._begin_posted()

    def run_off(self) -> None:
        """The frontend ends: what is posted from now on waits for the next one."""
        self._loop = None

    def post(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Have the frontend run it beside all else, from any thread; the next one where none is."""
        self._posted.append(work)
        loop = self._loop
        if loop is not None:
            with contextlib.suppress(RuntimeError):  # it is closed
                loop.call_soon_threadsafe(self._begin_posted)

    def _begin_posted(self) -> None:
        while self._posted and self._frontend is not None and self._loop is not None:
            self._frontend.beside(self._posted.popleft())

    def ask_no_more(self) -> None:
        """A STOP came from another program, or another console."""
        if self._frontend is not None:
            self._frontend.ask_no_more()

    def restart(self, why: str) -> None:
        """End, and begin again with the same words, once there is a frontend; from any thread."""
        if self._frontend is not None:
            self._frontend.restart(why)

    def take(self, snapshot: Snapshot) -> list[Alarm]:
        """Something was heard. Returns the alarms that changed."""
        self._snapshot = snapshot
        self.history.take(snapshot, self.clock.monotonic())
        if self.robot.stops.sent_elsewhere > self._elsewhere:
            self._elsewhere = self.robot.stops.sent_elsewhere
            self.ask_no_more()
        return self.look()

    def tick(self) -> list[Alarm]:
        """A second has passed. Returns the alarms that changed."""
        self._second = self.clock.monotonic()
        self.history.add(self._snapshot, self._second)
        return self.look()

    def look(self) -> list[Alarm]:
        """Bring alarms and view up to the time it is now. Returns the alarms that changed."""
        now = self.clock.monotonic()
        troubles = self._journal.failure, self.recorder.trouble, self.unseen, self.earlier_stop
        found = conditions(self._snapshot, now, self.host.states(), *troubles)
        # a release that was confirmed, also of a robot that is not heard, ends what it said
        known_over = () if self._snapshot.is_at_rest else (STOPPED,)
        changed = self._board.update(found, now, self.clock.now(), known_over)
        self._record(changed)
        self._look_at_ends()
        self._advance()
        self._look_at_requests(now)
        self.view = self._view()
        self.recorder.look(self.view, changed)
        return changed

    async def call_off(self, asker: Asker) -> None:
        """Who asked has left: its goals leave the queue, and what is underway is cancelled."""
        for wanted in self.queue.remove_requested_by(asker):
            _end(wanted, Outcome(Code.CANCELLED, f"taken out of the queue: {wanted.text}"))
        self.look()
        for _ in range(_CANCELS):
            if not self._drives(asker):
                return
            with asked_by(asker):
                outcome = await self.cancel()
            if outcome.ok:
                return
        if self._drives(asker):
            said = f"the goal of {asker.source}, which has left, may still run: {outcome.text}"
            self.robot.note("ERROR", "console", said)

    def _drives(self, asker: Asker) -> bool:
        """True when a goal that this one asked for is underway."""
        return any(wanted.asker is asker for wanted, _ in self._underway)

    @property
    def _busy(self) -> str:
        """What the robot does already, or is to do."""
        snapshot = self._snapshot
        if snapshot.is_stopped:
            return "the robot is stopped"
        if snapshot.running_goal is not None or self._underway:
            return "another goal runs"
        if self.queue.waiting:
            return "goals wait in the queue"
        return "another goal is being sent" if self.queue.is_going else ""

    def _look_at_requests(self, now: float) -> None:
        stops = self.robot.stops.count + self.robot.stops.sent_elsewhere
        for one in self.requests.look(now, stops, self._busy):
            said = f"request {one.number} is {one.stand.value}, {one.why}: {one.text}"
            self.robot.note("WARN", "console", said)

    def request(self, goal: QueuedGoal, text: str) -> Request:
        """Have a person decide on what is asked for. Raises ValueError that says why not."""
        if self._frontend is None or not self._frontend.has_person:
            raise ValueError("nobody can allow it: this console has no screen and no terminal")
        if self._busy:
            raise ValueError(f"{self._busy}: wait until it has ended")
        asker, stops = asking(), self.robot.stops.count_when_typed
        if asker.has_left or self.robot.stops.is_void(stops):
            raise ValueError(NOT_SENT)
        stops += self.robot.stops.sent_elsewhere
        one = self.requests.add(asker, goal, text, self.clock.monotonic(), stops)
        act = Act("request", {"request": one.number, "values": goal.values}, Code.ACCEPTED)
        said = f"asks: {text} (request {one.number})"
        self.robot.note(asker.level, asker.source, said, act=act)
        self.look()
        return one

    def withdraw(self, asker: Asker) -> str:
        """End what this one asks for and nobody has answered; returns what it was."""
        own = [one for one in self.requests.waiting if one.asker is asker]
        for one in own:
            self.requests.end(one.number, Stand.VOID, "the assistant has withdrawn it")
        self.look()
        return ", ".join(one.text for one in own)

    def answer(self, number: int, *, allowed: bool) -> Outcome:
        """A person has decided; what is allowed is sent at once, and once."""
        self.look()
        one = self.requests.get(number)
        if one is None:
            return Outcome(Code.REFUSED, f"there is no request {number}")
        if one.stand != Stand.WAITS:
            return Outcome(Code.REFUSED, f"request {number} is {one.stand.value}")
        if allowed and self.robot.stops.gate().is_shut:
            return Outcome(Code.CANCELLED, NOT_SENT)
        refusal = self._snapshot.unavailable(one.goal.kind.action) or self._beyond(one.goal)
        if allowed and refusal:
            return Outcome(Code.REFUSED, refusal)
        if allowed:
            self.requests.end(number, Stand.ALLOWED)
        else:
            self.requests.deny(number, self.clock.monotonic())
        verb, word = ("allow", "allowed") if allowed else ("deny", "denied")
        act = Act(verb, {"request": number}, Code.DONE)
        said = f"{word} request {number} of {one.asker.source}: {one.text}"
        self.robot.note(YOU.level, YOU.source, said, act=act)
        if allowed:
            ends = one.asker.ends = []  # of those before, who waits has them
            with asked_by(one.asker):
                answered = self.drive([one.goal])
            self.requests.drives(number, ends[0] if ends else answered)
        self.look()
        return Outcome(Code.DONE, said)

    def _beyond(self, goal: QueuedGoal) -> str:
        """Which of its values is beyond a limit that the robot holds now; empty: none is."""
        leaves = self._snapshot.forms.get(goal.kind.id) or ()
        try:
            forms.check_ranges(leaves, self._snapshot.form(goal.kind), goal.values)
        except ValueError as error:
            return str(error)
        return ""

    def goal_of(self, asker: Asker) -> Goal | None:
        """Return the state of the goal that is driven for this asker; None: none is."""
        befores = [before for wanted, before in self._underway if wanted.asker is asker]
        return self._goal_after(befores[0]) if befores else None

    def _goal_after(self, before: int) -> Goal | None:
        """Return the first goal of this console whose number is over `before`."""
        snapshot = self._snapshot
        ours = [goal for goal in (snapshot.goal, *snapshot.history) if goal and goal.mine]
        since = [goal for goal in ours if goal.number > before]
        return min(since, key=lambda goal: goal.number, default=None)

    def _look_at_ends(self) -> None:
        """Tell whoever waits for it how a goal has ended."""
        for wanted, before in list(self._underway):
            goal = self._goal_after(before)
            outcome = None if goal is None else goal.outcome_at(self.clock.monotonic())
            if goal is not None and outcome is not None:
                self._underway.remove((wanted, before))
                wanted.asker.goal = goal
                self.requests.goal_ended(wanted.end, goal)
                _end(wanted, outcome)

    def _advance(self) -> None:
        """Send what is due in the queue, and say when it is held."""
        due = self.queue.take_due(self._snapshot, self._board.all(), self.robot.stops.count)
        before, self._held = self._held, self.queue.hold_reason
        if self._held and not before:
            texts = ", ".join(wanted.text for wanted in self.queue.waiting)
            self.robot.note("WARN", "console", f"queue held: {texts} ({self._held})")
        for wanted in self.queue.waiting if self._held else ():
            _end(wanted, Outcome(Code.HELD, f"held: {wanted.text} ({self._held})"))
        if due is not None:
            self._drive(due)

    def drive(self, goals: Sequence[QueuedGoal]) -> asyncio.Future[Outcome]:
        """Drive these, one after the other; behind what runs or is being sent.

        The outcome is how the robot answered the first, or that it waits in the queue.
        """
        answer: asyncio.Future[Outcome] = asyncio.get_running_loop().create_future()
        if asking().has_left:
            answer.set_result(Outcome(Code.CANCELLED, CALLED_OFF))
            return answer
        if len(self.queue.waiting) + len(goals) > MOST_GOALS:
            answer.set_result(Outcome(Code.REFUSED, f"more than {MOST_GOALS} goals would wait"))
            return answer
        stops = self.robot.stops.count_when_typed
        asker, loop = asking(), asyncio.get_running_loop()
        if asker is not YOU:
            goals = [wanted._replace(asker=asker, end=loop.create_future()) for wanted in goals]
            asker.ends += [wanted.end for wanted in goals if wanted.end is not None]
        goals = [wanted._replace(stop_count=stops) for wanted in goals]
        first = self.queue.submit(goals, self._snapshot)
        if first is None:
            held = f", held: {self.queue.hold_reason}" if self.queue.hold_reason else ""
            answer.set_result(Outcome(Code.ACCEPTED, f"queued{held}"))
        else:
            self._drive(first, answer)
        self.look()
        return answer

    def resume(self) -> Outcome:
        """Continue a held queue."""
        gate = self.robot.stops.gate()
        outcome = Outcome(Code.CANCELLED, NOT_SENT) if gate.is_shut else Outcome(Code.DONE, "")
        if outcome.ok:
            self.queue.resume(gate.count_when_typed)
            self.queue.waiting = list(map(_unended, self.queue.waiting))
            self.look()
            if self.queue.hold_reason:  # what is in the way is not over
                outcome = Outcome(Code.REFUSED, f"still held: {self.queue.hold_reason}")
        said = f": {outcome.text}" if outcome.text else ""
        act = Act("continue", {}, outcome.code)
        self.robot.note("YOU", "console", f"continue the queue{said}", act=act)
        return outcome

    def skip(self) -> Outcome:
        """Leave out the next goal of the queue."""
        wanted = self.queue.skip_next()
        text = wanted.text
        _end(wanted, Outcome(Code.CANCELLED, f"left out of the queue: {text}"))
        act = Act("skip", {}, Code.DONE)
        self.robot.note("YOU", "console", f"left out of the queue: {text}", act=act)
        self.look()
        return Outcome(Code.DONE, f"left out: {text}")

    def _drive(self, wanted: QueuedGoal, answer: asyncio.Future[Outcome] | None = None) -> None:
        """Send it; whoever waits for the answer gets it."""
        assert self._frontend is not None  # nothing is due before there is one
        before = self.ledger.before
        self._frontend.carry_out(partial(self._send, self._frontend, wanted, before, answer))

    async def _send(
        self,
        frontend: Frontend,
        wanted: QueuedGoal,
        before: int,
        answer: asyncio.Future[Outcome] | None,
    ) -> None:
        """Send a goal; from the queue not behind a STOP."""
        queued = answer is None
        if self.ledger.is_cancelled:
            outcome = Outcome(Code.CANCELLED, NEVER_LEFT)
        else:
            self.ledger.has_left = True
            try:
                with self.robot.stops.typed_at(wanted.stop_count), asked_by(wanted.asker):
                    outcome = await self.robot.send(wanted.kind, wanted.values, queued=queued)
            except asyncio.CancelledError:  # the screen ends: the next one knows it by its snapshot
                self.ledger.drop()
                raise
        if outcome.code == Code.HELD:
            self.queue.put_back(wanted)
        else:
            cancelled = outcome.code == Code.CANCELLED
            self.queue.on_answer(ok=outcome.ok, reason="cancelled" if cancelled else "refused")
            if outcome.ok:
                self._underway.append((wanted, before))
                self._look_at_ends()
                if wanted.asker.has_left:  # while it was being sent
                    await self.call_off(wanted.asker)
            else:
                _end(wanted, outcome)
        if answer is None:
            frontend.goal_answered(wanted, outcome)
        elif not answer.done():
            answer.set_result(outcome)
        if outcome.code == Code.TIMEOUT and (wanted.asker.waits or wanted.asker.has_left):
            with asked_by(wanted.asker):  # the robot may still take it, and nobody would wait then
                await self.cancel()

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Cancel our goal, wherever it is by now; another client's only when that is meant."""
        if self.ledger.goal is None or self.ledger.has_left:
            return await self.robot.cancel(another=another)
        self.ledger.is_cancelled = True
        outcome = Outcome(Code.ACCEPTED, NEVER_LEFT)
        act = Act("cancel", {}, outcome.code)
        self.robot.note("YOU", "console", f"cancel: {outcome.text}", act=act)
        return outcome

    async def release(self) -> Outcome:
        """Allow moves again after a STOP."""
        with self.ledger.asking(RELEASE):
            return await self.robot.release_emergency_stop()

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

    async def undo(self, asked: Edit | None) -> Outcome:
        """Take the last change of a parameter back, if it is the one `asked` for."""
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
            queue=tuple(self.queue.waiting),
            held=self.queue.hold_reason,
            changing=self.edits.is_changing,
            clients=self.clients,
            requests=self.requests.waiting,
        )


def _unended(wanted: QueuedGoal) -> QueuedGoal:
    """A goal that was held, and goes on: who has not left yet waits for its end again."""
    if wanted.end is None or not wanted.end.done():
        return wanted
    anew = wanted.end.get_loop().create_future()
    ends = wanted.asker.ends
    ends[:] = [anew if end is wanted.end else end for end in ends]
    return wanted._replace(end=anew)


def _end(wanted: QueuedGoal, outcome: Outcome) -> None:
    """Tell whoever waits for this goal."""
    if wanted.end is not None and not wanted.end.done():
        wanted.end.set_result(outcome)
