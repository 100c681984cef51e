"""`archo-tui --plain`: the station line by line, for scripts, screen readers, dumb terminals."""

from __future__ import annotations

import asyncio
import contextlib
import shlex
import sys
from collections.abc import Callable, Coroutine, Mapping
from typing import TYPE_CHECKING

from archo_tui.clock import time_of_day
from archo_tui.errors import ArchoError
from archo_tui.plain.input import Input, Line
from archo_tui.plain.output import Output
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import Event, Goal, Phase, Snapshot
from archo_tui.robot.stops import NOT_SENT, RateLimit, Void
from archo_tui.robot.text import safe
from archo_tui.shutdown import Shutdown
from archo_tui.station.alarms import Alarm, State
from archo_tui.station.queue import QueuedGoal
from archo_tui.station.requests import EXPIRES, READ
from archo_tui.terminal.ascii import ascii_only, in_ascii
from archo_tui.verbs import verbs
from archo_tui.verbs.base import Question, Values, Verb
from archo_tui.verbs.called import choose_verb
from archo_tui.verbs.parse import YES, UnknownVerbError, parse
from archo_tui.verbs.speak import speak
from archo_tui.verbs.tell import Status
from archo_tui.words import line_by_line
from archo_tui.words.event import event_text, is_of_own_file

if TYPE_CHECKING:
    from archo_tui.station.station import Station

_SHOWN_LEVELS = ("YOU", "SHELL", "AI", "PEER", "WARN", "ERROR", "FATAL")
_BEHIND = 0.3  # s that an answer to an assistant comes behind the line before it: no paste's does
_SLOW = 2.0  # s for the reader to catch up before the next line; once, if it does not read at all
_LAST = 0.5  # s after a signal for a STOP to be answered, and for what is not written yet
_AT_ONCE = 0.2  # s in which nearly all lines are answered, before a cancel behind one goes ahead
_SLOW_CALL = 2.0  # s in which a call is answered, before the lines behind it go ahead
_YES, _NO = ("y", "yes"), ("n", "no")


def help_text(spoken: Mapping[str, Verb]) -> str:
    """The verbs, a line each."""
    lines = [verb.explained for verb in spoken.values()]
    return "\n".join((*lines, "help: List these", "quit: End, once the last goal has ended"))


class Plain:
    """Reads commands, prints what happens, one line each."""

    def __init__(self, station: Station, read: int | None, write: int) -> None:
        """Reads from and writes to file descriptors; `read` is None where there is no input."""
        self._station, self._robot, self._clock = station, station.robot, station.clock
        self._changed = asyncio.Event()
        self._input = Input(read, self._robot.stops, self._heard, self._clock)
        self._output = Output(write, self._written)
        self._ascii = ascii_only()
        snapshot = self._robot.snapshot
        self._verbs = verbs(snapshot.file, snapshot.forms)
        status = self._verbs["status"]
        assert isinstance(status, Status)
        self._status = status  # knows how goals and commands are given here
        self._put_back: Line | None = None  # no answer to what was asked
        self._printed: set[int] = set()  # the numbers of events that were printed
        self._asked: dict[int, float] = {}  # when requests of assistants were told, monotonic s
        self._goal: Goal | None = None
        self._failed = False  # a line, or a goal
        self._stopped = self._confirmed = 0  # the last STOPs that were sent, and confirmed
        self._is_asking = False
        self._slow = 0  # lines whose outcome takes seconds, and has not come
        self._patience = _SLOW
        self._overflows = 0  # of the input, that were said
        self._tasks: set[asyncio.Future[None]] = set()
        self._shutdown = Shutdown(self._robot, self._clock, station.on_disconnect, self._finish)
        self._end: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def run(self) -> int:
        """Until `quit`, the end of the input, or a signal; returns the exit code."""
        self._station.run_on(self)
        self._output.start()
        self._robot.subscribe(self._take)
        self._shutdown.on_signals()
        self._input.start()
        for work in (self._serve, self._obey, self._tick):
            self._start(work())
        try:
            code = await self._end
            await self._until(lambda: self._are_answered() and self._output.is_done, _LAST)
            return code
        finally:
            self._station.run_off()
            self._input.close()
            self._output.close()
            for task in self._tasks:
                task.cancel()

    def _start(self, work: Coroutine[None, None, None]) -> None:
        """Do it beside the rest; what it raises ends everything."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)

        def ended(task: asyncio.Future[None]) -> None:
            self._tasks.discard(task)
            error = None if task.cancelled() else task.exception()
            if error is not None and not self._end.done():
                self._end.set_exception(error)

        task.add_done_callback(ended)

    def _heard(self) -> None:
        """Something was typed."""
        if self._input.overflows > self._overflows:
            self._overflows = self._input.overflows
            self._fail("more than 1 MB of lines wait: further ones are refused, stop is not")
        self._changed.set()

    def _written(self) -> None:
        """All that was said is written, or cannot be."""
        if self._output.is_broken and not self._end.done():
            self._shutdown.begin(1)
        self._changed.set()

    async def _obey(self) -> None:
        """Send the STOPs, none behind the answer to another: one covers all that were read."""
        typed, stops = self._input.unanswered, self._robot.stops
        limit = RateLimit()
        while True:
            await self._hold(lambda: typed and typed[-1] > self._stopped)
            delay = limit.delay(self._clock.monotonic())
            if delay > 0:
                await self._until(lambda: stops.superseded, delay)
            limit.record(self._clock.monotonic())
            self._stopped = stops.count
            self._start(self._stop(self._stopped))

    async def _stop(self, covered: int) -> None:
        """Send one, for all up to that one."""
        typed = self._input.unanswered
        outcome = await self._verbs["stop"].run(self._station, {})
        while typed and typed[0] <= covered:
            typed.popleft()
        if outcome.ok:
            self._confirmed = max(self._confirmed, covered)
        elif covered > self._confirmed:  # else a later one has stopped the robot
            self._fail(f"stop: {outcome.text}")
        self._changed.set()

    def _are_answered(self, last: int | None = None) -> bool:
        """True when the robot has answered every STOP that was typed, or did not in time.

        Or those up to the `last` one.
        """
        typed = self._input.unanswered
        return not typed or (last is not None and typed[0] > last)

    async def _serve(self) -> None:
        while (line := await self._line()) is not None and line.text.split() != ["quit"]:
            if line.fault or line.text.split():  # else blanks of some other script
                await self._run_until_cancel(line)
        await self._hold(lambda: self._input.is_quiet)  # a stop may have come with the last line
        await self._hold(lambda: not self._slow)
        await self._hold(lambda: self._is_over() or self._is_in_doubt)
        if self._goal is not None and not self._is_over():
            self._say(f"waiting for the end of {self._goal.name}; ctrl+c cancels it")
        await self._hold(self._is_over)
        if self._given_up is not None:
            self._failed = True
            self._say(self._given_up.text)
        last = self._robot.stops.count
        await self._hold(lambda: self._are_answered(last))
        await self._robot.catch_up()
        self._take(self._robot.snapshot)
        held = self._station.queue.hold_reason
        if held:
            self._say(f"not driven: {self._waiting} ({held})")
        await self._hold(lambda: self._output.is_done)
        if not self._shutdown.has_begun:
            well = not self._failed and not self._station.queue.waiting
            well = well and not self._output.is_broken
            self._finish(0 if well else 1)

    async def _line(self) -> Line | None:
        """The next one, once every STOP before it is answered; None at the end of the input."""
        if self._put_back is not None:
            back, self._put_back = self._put_back, None
            return back
        # this also gives everything else its turn, however much is typed
        await self._until(lambda: self._output.has_room, self._patience)
        self._patience = _SLOW if self._output.has_room else 0.0
        await self._hold(lambda: self._input.has_news)
        line = self._input.take()
        if line is not None:
            await self._hold(lambda: self._are_answered(line.stops))
        return line

    @property
    def _waiting(self) -> str:
        """What waits in the queue: `7, 3`."""
        return ", ".join(wanted.text for wanted in self._station.queue.waiting)

    def _is_over(self) -> bool:
        """No goal of ours runs, and none is to be sent."""
        runs = self._goal is not None and self._goal.is_running and self._goal.mine
        return self._given_up is not None or not (runs or self._station.queue.is_going)

    @property
    def _given_up(self) -> Outcome | None:
        """What is said of our goal when its end is not waited for any more: it is lost."""
        goal = self._goal
        if goal is None or not (goal.is_running and goal.mine):
            return None
        return goal.outcome_at(self._clock.monotonic())

    @property
    def _is_in_doubt(self) -> bool:
        """True while nothing is heard of the goal: its end may never come."""
        return self._goal is not None and self._goal.phase in (Phase.UNKNOWN, Phase.LOST)

    async def _tick(self) -> None:
        while True:
            await self._clock.sleep(1.0)
            self._tell_alarms(self._station.tick())
            self._tell_requests()
            self._changed.set()

    def _finish(self, code: int) -> None:
        if not self._end.done():
            self._end.set_result(code)

    def _out(self, text: str) -> None:
        lines = [safe(line) for line in text.splitlines()]
        self._output.put(
            "".join(f"{in_ascii(line) if self._ascii else line}\n" for line in lines).encode()
        )

    @property
    def _has_cancel(self) -> bool:
        """True when the next line is `cancel`, no answer to a question, and there is a goal."""
        has_goal = self._station.running_goal is not None
        return has_goal and self._input.is_cancel_next and not self._is_asking

    async def _run_until_cancel(self, line: Line) -> None:
        """Carry out a line; a `cancel` directly behind it does not wait for its answer.

        Nor does any line wait for a service that takes its time: the end does.
        """
        with self._robot.stops.typed_at(line.stops):
            running = asyncio.ensure_future(self._run(line))
        running.add_done_callback(lambda _: self._changed.set())
        is_call = line.text.split()[:1] == ["call"]
        try:
            await self._until(running.done, _AT_ONCE)
            slow_at = self._clock.monotonic() + _SLOW_CALL

            def is_slow() -> bool:
                return is_call and not self._is_asking and self._clock.monotonic() >= slow_at

            while True:
                await self._hold(lambda: running.done() or self._has_cancel or is_slow())
                if is_slow() and not running.done():
                    self._run_on(running)
                    return
                if running.done() or (cancel := self._input.take()) is None:
                    break
                with self._robot.stops.typed_at(cancel.stops):
                    await self._run(cancel)
            await running
        finally:
            if running not in self._tasks:
                running.cancel()

    def _run_on(self, running: asyncio.Future[None]) -> None:
        """Let a line run on beside those behind it; the end waits for it."""
        self._slow += 1
        self._tasks.add(running)

        def ended(_: object) -> None:
            self._slow -= 1
            self._tasks.discard(running)
            self._changed.set()

        running.add_done_callback(ended)

    async def _run(self, line: Line) -> None:
        if line.fault:
            self._fail(line.fault)
            return
        try:
            verb, *rest = shlex.split(line.text)
        except ValueError:
            verb, *rest = line.text.split()
            self._fail(f"{verb}: a quote is not closed, or nothing follows the last \\")
            return
        try:
            outcome = await self._do(verb, rest)
        except Void:
            outcome = Outcome(Code.CANCELLED, NOT_SENT)
        except UnknownVerbError as error:  # whose text names the word
            self._fail(str(error))
            return
        except (ArchoError, ValueError) as error:
            outcome = Outcome(Code.MISUSE, str(error))
        if not outcome.ok:
            self._fail(f"{verb}: {outcome.text}")

    async def _do(self, word: str, rest: list[str]) -> Outcome:
        """Raises ArchoError and ValueError with one line for what is typed wrong, and Void."""
        if word in ("help", "quit") and rest:
            raise ValueError("takes no values")
        if word == "help":
            self._out(help_text(self._verbs))
            return Outcome(Code.DONE, "")
        if word in ("allow", "deny"):
            return await self._answer(word, rest)
        station = self._station
        verb, rest = choose_verb(self._verbs, station, word, rest)
        values, yes = parse(verb, station, rest)
        if verb.begun:
            self._out(verb.begun)
            self._slow += 1
            self._start(self._speak_slowly(verb, values))
            return Outcome(Code.DONE, "")
        outcome = await speak(station, verb, values, self._until, None if yes else self._ask)
        self._take(self._robot.snapshot)  # a goal is known before the end is looked for
        if verb.tells_with(values) and outcome.ok:
            self._out(outcome.text)
        waiting = [wanted.text for wanted in station.queue.waiting]
        if verb.moves and outcome.code == Code.ACCEPTED and waiting:
            self._say(f"queue: {line_by_line.queue_text(waiting, station.queue.hold_reason)}")
        self._failed = self._failed or verb.id == "skip"  # one goal less that arrives
        return outcome

    async def _speak_slowly(self, verb: Verb, values: Values) -> None:
        """Carry out a verb whose outcome takes seconds: the lines behind it do not wait."""
        try:
            outcome = await speak(self._station, verb, values, self._until, None)
        finally:
            self._slow -= 1
        if outcome.ok:
            self._out(outcome.text)
        else:
            self._fail(f"{verb.id}: {outcome.text}")
        self._changed.set()

    async def _answer(self, word: str, rest: list[str]) -> Outcome:
        """What an assistant asked for is decided, by a person. Raises ValueError."""
        if not self._input.is_terminal:
            raise ValueError("only a person at a terminal answers an assistant")
        if len(rest) != 1 or not rest[0].isascii() or not rest[0].isdecimal() or len(rest[0]) > 9:
            raise ValueError("needs the number of a request")
        await self._hold(lambda: self._input.is_quiet)  # the rest of a paste, or STOP, is behind it
        number, (read, pause) = int(rest[0]), self._input.last
        told = self._asked.get(number)
        if told is None and self._station.requests.get(number) is None:
            return Outcome(Code.REFUSED, f"there is no request {number}")
        # of what was typed ahead, or pasted with more, nobody has read what it answers
        alone = pause >= _BEHIND and not self._input.has_news
        if told is None or read - told < READ or not alone or not self._output.is_done:
            return Outcome(Code.REFUSED, "read it first, then answer, by a line alone")
        outcome = self._station.answer(number, allowed=word == "allow")
        self._changed.set()
        return outcome

    def _tell_requests(self) -> None:
        """What an assistant asks for, once, and how it is answered."""
        for one in self._station.view.requests:
            if one.number not in self._asked:
                self._asked[one.number] = self._clock.monotonic()
                ways = f"allow {one.number} or deny {one.number}, within {EXPIRES:g} s"
                self._say(f"{one.asker.source} wants: {one.text} ({ways})")

    async def _ask(self, question: Question) -> None:
        """Put a question to the person at the terminal; returns when it is answered by yes.

        Raises ArchoError when it is not, or nobody is there, and Void at a STOP. The next line is
        the answer; one that is neither yes nor no is a command like any other.
        """
        first, *more = (" ".join(line.split()) for line in question.text.splitlines() if line)
        if more:
            self._out("\n".join((first, *more)))
        text = f"{question.go}?" if more else first
        if not self._input.is_terminal:
            raise ArchoError(f"{text} (add {YES} to do it)")
        gate = self._robot.stops.gate()
        self._say(f"{text} [y/N]")
        self._is_asking = True
        try:
            await self._hold(lambda: gate.is_shut or self._input.has_news)
            line = await self._line() if self._input.has_news else None
        finally:
            self._is_asking = False
        await self._hold(lambda: self._input.is_quiet)  # a terminal gives line by line: STOP behind
        answer = "" if line is None else line.text.strip().lower()
        if line is not None and (line.fault or answer not in ("", *_YES, *_NO)):
            self._put_back = line
        gate()
        if answer not in _YES:
            raise ArchoError("not done: the answer was not yes")

    def carry_out(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        """Beside the rest."""
        self._start(work())

    def beside(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        """As everything here."""
        self._start(work())

    def goal_answered(self, wanted: QueuedGoal, outcome: Outcome) -> None:
        """One from the queue: no line waits for it."""
        if not outcome.ok:
            self._fail(f"{wanted.text}: {outcome.text}")
        self._station.look()
        self._changed.set()

    @property
    def has_person(self) -> bool:
        """Not where a program types."""
        return self._input.is_terminal

    def ask_no_more(self) -> None:
        """An answer that is read behind a STOP does not count."""

    def restart(self, why: str) -> None:
        """Not here, and said: lines that are read already would be lost."""
        self._robot.note("WARN", "console", f"{why}: they count from the next start on")

    # what happens

    def _take(self, snapshot: Snapshot) -> None:
        for event in snapshot.events:
            if event.number not in self._printed and self._is_news(event, snapshot.goal):
                self._say(event_text(event), event.time)
        self._printed = {event.number for event in snapshot.events}
        self._tell_goal(snapshot)
        self._tell_alarms(self._station.take(snapshot))
        self._tell_requests()
        self._changed.set()

    def _is_news(self, event: Event, goal: Goal | None) -> bool:
        """False for an event that no line is printed for, or whose words another line has."""
        if event.level not in _SHOWN_LEVELS:
            return event.level == "INFO" and is_of_own_file(event, self._station.view.hosted)
        act = event.act
        if event.level == "YOU" and act is not None and not Outcome(act.code, "").ok:
            # else `failed: ...` says it; of what comes later no line was typed
            return self._shutdown.has_begun or "later" in act.arguments
        if goal is None or not goal.mine or not goal.kind.refusals:
            return True
        # the log of a refusal is where its reason comes from
        refusal = event.text.startswith(goal.kind.refusals)
        said = event.text.removeprefix(goal.kind.refusals) == goal.message
        its = goal.phase == Phase.SENT or (goal.phase == Phase.REFUSED and said)
        return not (refusal and its)

    def _tell_goal(self, snapshot: Snapshot) -> None:
        goal, before = snapshot.goal, self._goal
        self._goal = goal
        if any(ended.mine and ended.phase != Phase.ARRIVED for ended in snapshot.history):
            self._failed = True
        if goal is None:
            return
        if before is not None and before.number != goal.number:
            before = None
        if (before is None or _said_of(before) != _said_of(goal)) and not _is_said(before, goal):
            said = line_by_line.goal_text(snapshot, self._clock.monotonic(), self._status.ask)
            self._say(f"goal {said}")

    def _tell_alarms(self, changed: list[Alarm]) -> None:
        for alarm in changed:
            is_new = alarm.state == State.UNACKNOWLEDGED
            what = self._status.advice(alarm, self._robot.snapshot) if is_new else alarm.name
            self._say(f"alarm {alarm.state.value}: {what}")

    def _fail(self, said: str) -> None:
        """Say what did not succeed; the exit code will."""
        self._say(f"failed: {said}")
        self._failed = True

    def _say(self, text: str, at: float | None = None) -> None:
        self._out(f"{time_of_day(self._clock.now() if at is None else at)} {text}")

    async def _until(self, condition: Callable[[], object], timeout: float | None = None) -> None:
        """Wait until the condition holds after a snapshot, or the time (s) has passed."""
        with contextlib.suppress(TimeoutError):
            await self._clock.wait_for(self._hold(condition), timeout)

    async def _hold(self, condition: Callable[[], object]) -> None:
        while not condition():
            self._changed.clear()
            await self._changed.wait()


def _said_of(goal: Goal) -> tuple[Phase, bool, bool, int]:
    """What of a goal is worth a line when it changes: on its way, each quarter of that."""
    return goal.phase, bool(goal.unreadable), _is_heard(goal), min(int(goal.fraction() * 4), 3)


def _is_said(before: Goal | None, goal: Goal) -> bool:
    """True when the robot's answer to what was typed says the same, and has a line."""
    if before is None or before.phase == Phase.SENT:  # else the answer came late
        begins = goal.phase == Phase.MOVING and not _is_heard(goal)
        return goal.mine and (begins or goal.phase in (Phase.SENT, Phase.REFUSED))
    return goal.mine and goal.phase == Phase.CANCELLING and goal.cancel_asked is not None


def _is_heard(goal: Goal) -> bool:
    """True when it has given feedback."""
    return bool(goal.unreadable or goal.feedback) or goal.remaining is not None


def run(station: Station, read: int | None) -> int:
    """Operate through a descriptor and standard output; returns the exit code."""

    async def operate() -> int:
        return await Plain(station, read, sys.stdout.fileno()).run()

    return asyncio.run(operate())
