"""The frontend of `archo-tui --plain`, for scripts, screen readers and simple terminals.

Its operator is a client of the console as a program on the socket is. Lines run one after the
other, by these rules:

- STOP is no line: `Input` counts it as it is read, and hands it over at once.
- A line runs only after every STOP before it was answered (`_next_line`), and what it requests is
  not sent if a STOP was read after it (`robot/stop/gate.py`).
- `cancel` behind a line does not wait for that line's answer once a goal was sent.
- `echo --follow`, and at a terminal every verb that `is_slow`, ends by the next line.
"""

from __future__ import annotations

import asyncio
import contextlib
import shlex
import sys
from collections.abc import Callable, Coroutine, Mapping
from typing import TYPE_CHECKING, Any

from archo_tui.base.clock import Clock
from archo_tui.base.errors import ArchoError
from archo_tui.client.protocol import GOOD, YES_WORDS
from archo_tui.console.printing import Output, Printer
from archo_tui.console.session import RequestHandler, Session
from archo_tui.console.typing import Input, TypedLine
from archo_tui.robot.clients import YOU
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.approvals import READING_TIME
from archo_tui.station.shutdown import Shutdown
from archo_tui.text import line_by_line
from archo_tui.verbs.show import Status
from archo_tui.verbs.topics import FOLLOW
from archo_tui.verbs.verb import YES, Question, Verb

if TYPE_CHECKING:
    from archo_tui.station.station import Station

# All in seconds.
_PAUSE_BEFORE_ANSWER = 0.3  # Since the line before an answer to an assistant; no paste has it.
_READER_PATIENCE = 2.0  # For a slow reader of the output, before the next line is carried out.
_NOT_WAITED_FOR = "not waited for any longer"
_LAST_WRITE = 0.5  # At the end, for STOPs to be answered and the output to be written.
_QUICK_ANSWER = 0.2  # For a line's answer before `cancel` overtakes it; nearly all have one then.

_NO = ("n", "no")


def help_text(all_verbs: Mapping[str, Verb]) -> str:
    """Return what `help` prints: each verb with its values and what it does, one a line."""
    lines = [verb.help_line for verb in all_verbs.values()]
    return "\n".join((*lines, "help: List these", "quit: End, once the last goal has ended"))


class Conditions:
    """The conditions that tasks wait for; whoever changes one calls `check_again`, on the loop."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._changed = asyncio.Event()

    def check_again(self) -> None:
        """Wake every waiting task, which checks its condition when the loop runs it next."""
        self._changed.set()

    async def wait(self, condition: Callable[[], object]) -> None:
        """Wait until `condition()` is true: it is called at once, and after each `check_again`."""
        while not condition():
            self._changed.clear()
            await self._changed.wait()

    async def wait_at_most(self, condition: Callable[[], object], timeout: float) -> None:
        """Wait until `condition()` is true or the time in seconds has passed."""
        with contextlib.suppress(TimeoutError):
            await self._clock.wait_for(self.wait(condition), timeout)


class Plain:
    """The frontend that reads commands and prints what happens, one line each.

    All methods are called on the running loop, except `restart` and `_send_stop`: on any thread.
    """

    pid, requester = 0, YOU

    def __init__(self, station: Station, read: int | None, write: int) -> None:
        """Create the frontend; `run` reads and writes, and the descriptors stay open."""
        self._station, self._robot, self._clock = station, station.robot, station.clock
        self._conditions = Conditions(self._clock)
        self._handler = RequestHandler(station)
        self._verbs = self._handler.verbs
        self._input = Input(read, self._robot.stops, self._clock, self._on_input, self._send_stop)
        self._output = Output(write, self._on_output)
        status = self._verbs["status"]
        assert isinstance(status, Status)
        self._printer = Printer(
            station, self._output, status, is_ending=lambda: self._shutdown.has_begun
        )
        self._put_back: TypedLine | None = None  # Taken, and still to be carried out.
        self._is_asking = False  # The next line is an answer.
        self._stop_results: list[dict[str, Any]] = []  # Not yet told.
        self._stopped_up_to = 0  # The number of the last confirmed STOP, by `Stops.count`.
        self._patience = _READER_PATIENCE
        self._reported_overflows = 0
        self._tasks: set[asyncio.Future[None]] = set()
        self._shutdown = Shutdown(self._robot, self._clock, station.on_disconnect, self._finish)
        self._exit_code: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def run(self) -> int:
        """Operate the station until `quit`, the end of the input, a signal, or a failed write.

        After `quit` and the end of the input, requested goals and STOPs are waited for; otherwise
        `Shutdown` decides about a running goal. Returns 0, or 1 if something failed or goals are
        left in the queue, or 128 + a signal's number. Raises the error of any task.
        """
        self._station.attach(self)
        self._output.start()
        self._robot.subscribe(self._on_snapshot)
        self._shutdown.begin_on_signals()
        self._input.start()
        for work in (self._serve, self._tick):
            self._start(work())
        try:
            code = await self._exit_code
            await self._conditions.wait_at_most(
                lambda: not self._input.unanswered and self._output.is_done, _LAST_WRITE
            )
            return code
        finally:
            self._station.detach()
            self._input.close()
            self._output.close()
            for task in self._tasks:
                task.cancel()

    def _start(self, work: Coroutine[None, None, None]) -> None:
        """Run a coroutine as a task beside the others; `run` raises an error in it, and ends."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)

        def on_end(task: asyncio.Future[None]) -> None:
            self._tasks.discard(task)
            error = None if task.cancelled() else task.exception()
            if error is not None and not self._exit_code.done():
                self._exit_code.set_exception(error)

        task.add_done_callback(on_end)

    def _finish(self, code: int) -> None:
        """End `run` with an exit code; an earlier code or error stays."""
        if not self._exit_code.done():
            self._exit_code.set_result(code)

    def _on_input(self) -> None:
        if self._input.overflows > self._reported_overflows:
            self._reported_overflows = self._input.overflows
            self._printer.print_failure(
                "too many lines wait: further ones are refused, stop is not"
            )
        self._conditions.check_again()

    def _on_output(self) -> None:
        if self._output.is_broken and not self._exit_code.done():
            self._shutdown.begin(1)
        self._conditions.check_again()

    def _on_snapshot(self, snapshot: Snapshot) -> None:
        self._printer.print_news(snapshot)
        self._printer.print_alarms(self._station.on_snapshot(snapshot))
        self._printer.print_requests()
        self._conditions.check_again()

    async def _tick(self) -> None:
        """Tick the station each second for ever, and print changed alarms and new requests."""
        while True:
            await self._clock.sleep(1.0)
            self._printer.print_alarms(self._station.tick())
            self._printer.print_requests()
            self._conditions.check_again()

    # The lines, one after the other.

    async def _serve(self) -> None:
        """Carry out all lines up to `quit` or the end of the input, and end `run` with a code."""
        while (line := await self._next_line()) is not None and line.text.split() != ["quit"]:
            if line.fault or line.text.split():
                await self._execute(line)
        await self._wait_for_the_end()
        if not self._shutdown.has_begun:  # Otherwise the shutdown decides about the exit code.
            is_well = not self._printer.has_failed and not self._station.queue.waiting
            self._finish(0 if is_well and not self._output.is_broken else 1)

    async def _next_line(self) -> TypedLine | None:
        """Wait for the answers to all STOPs before the next line, and return it; None at the end.

        A command that was typed in place of an answer is the next one. A slow reader of the output
        is waited for, 2 s at most.
        """
        if self._put_back is None:
            await self._take_line()
        if (line := self._put_back) is not None:  # Kept if this is cancelled: `run_when_ready`.
            up_to = line.stops_before
            await self._conditions.wait(lambda: self._are_answered(up_to))
        self._put_back = None
        return line

    async def _take_line(self) -> None:
        # This wait also lets all other tasks run between two lines, however many are typed. A
        # reader that does not read at all delays one line, not each.
        await self._conditions.wait_at_most(lambda: self._output.has_room, self._patience)
        self._patience = _READER_PATIENCE if self._output.has_room else 0.0
        await self._conditions.wait(lambda: self._input.has_line_or_end)
        self._put_back = self._input.take()

    def _are_answered(self, up_to: int) -> bool:
        """Return True if every typed STOP up to a number was answered, or has timed out."""
        return not self._input.unanswered or self._input.unanswered[0] > up_to

    async def _execute(self, line: TypedLine) -> None:
        if line.fault:
            self._printer.print_failure(line.fault)
            return
        try:
            word, *rest = shlex.split(line.text)
        except ValueError:
            fault = "a quote is not closed, or nothing follows the last \\"
            self._printer.print_failure(f"{line.text.split()[0]}: {fault}")
            return
        if word in ("help", "quit") and rest:
            self._printer.print_failure(f"{word}: takes no values")
        elif word == "help":
            self._printer.print_text(help_text(self._verbs))
        elif word in ("allow", "deny"):
            await self._answer_request(word, rest)
        else:
            await self._carry_out([word, *rest], line.stops_before)

    async def _carry_out(self, words: list[str], stops: int) -> None:
        """Carry out a verb, wait for its result, and print what was asked for or why it failed."""
        request: dict[str, Any] = {"words": words}
        follows = words[0] == "echo" and FOLLOW in words
        verb = self._verbs.get(words[0])
        is_slow = verb is not None and verb.is_slow
        if follows:
            words = [word for word in words if word != FOLLOW]
            request = {"words": words, "follow": True, "as_text": True}
            self._printer.print_text(f"following {' '.join(words[1:2])}; the next line ends it")
        elif verb is not None and verb.started_text:
            self._printer.print_text(verb.started_text)
        session = Session(self._handler, self)
        work = asyncio.ensure_future(session.carry_out(request, stops))
        work.add_done_callback(lambda _: self._conditions.check_again())
        try:
            if follows or (is_slow and self._input.is_terminal):
                await asyncio.sleep(0)  # It has begun when the next line ends it.
                await self._conditions.wait(lambda: work.done() or self._input.has_line_or_end)
                if await session.give_up():
                    if not follows:
                        ends = "ended" if verb is not None and verb.lasts else _NOT_WAITED_FOR
                        self._printer.print_text(f"{words[0]}: {ends}")
                    return
            elif words[:2] != ["wait", "left"]:  # A cancel behind that is meant for then.
                await self._let_cancels_overtake(work)
            result = await work
        finally:
            work.cancel()
        # The snapshot may not have been delivered yet, and `_goals_have_ended` needs its goal.
        self._on_snapshot(self._robot.snapshot)
        self._print_result(words[0], result)

    async def _let_cancels_overtake(self, work: asyncio.Future[Any]) -> None:
        """Wait until a line is done; once a goal runs, carry out each `cancel` behind it."""
        await self._conditions.wait_at_most(work.done, _QUICK_ANSWER)
        while True:
            await self._conditions.wait(lambda: work.done() or self._is_cancel_next)
            if work.done() or (cancel := self._input.take()) is None:
                return
            result = await Session(self._handler, self).carry_out(
                {"words": ["cancel"]}, cancel.stops_before
            )
            self._print_result("cancel", result)

    @property
    def _is_cancel_next(self) -> bool:
        publishes = bool(self._robot.publications.active)
        is_sent = self._robot.snapshot.running_goal is not None or publishes
        return is_sent and self._input.is_cancel_next and not self._is_asking

    def _print_result(self, word: str, result: dict[str, Any]) -> None:
        code, text = result["code"], result["text"]
        if code not in GOOD:
            named = "" if text.startswith("no command ") else f"{word}: "  # Its text names it.
            self._printer.print_failure(f"{named}{text}")
        elif result.get("tells"):
            self._printer.print_text(text)
        queue = self._station.queue
        verb = self._verbs.get(word)
        if code == Code.ACCEPTED.value and queue.waiting and verb is not None and verb.has_goals:
            waiting = [goal.text for goal in queue.waiting]
            shown = line_by_line.queue_text(waiting, queue.hold_reason)
            self._printer.print_timed(f"queue: {shown}")
        # A skipped goal will not arrive, so not all that was requested has succeeded.
        self._printer.has_failed = self._printer.has_failed or word == "skip"

    # The client of the sessions.

    def _send_stop(self, number: int) -> None:
        """Have the STOP sent that was counted as `number`; called as it is read, on any thread."""
        self._handler.serve(self, {"id": number, "words": ["stop"]}, number)

    def reply(self, reply: dict[str, Any]) -> None:
        """Print what comes of a followed topic; keep the result of a STOP for the next callback."""
        if "code" in reply:
            if not self._stop_results:
                asyncio.get_running_loop().call_soon(self._on_stops_answered)
            self._stop_results.append(reply)
        elif "said" in reply:
            self._printer.print_timed(reply["said"])
        else:
            text = reply["text"]
            self._printer.print_text(f"{text}\n---" if "\n" in text else text)
            if reply["left_out"]:
                self._printer.print_text(f"{reply['left_out']} left out")

    def _on_stops_answered(self) -> None:
        """Print that STOPs were not confirmed, once for all that one request to the robot covers.

        Nothing is printed if the robot has confirmed a later one.
        """
        results, self._stop_results = self._stop_results, []
        unanswered, answered = self._input.unanswered, max(result["id"] for result in results)
        while unanswered and unanswered[0] <= answered:
            unanswered.popleft()
        confirmed = [result["id"] for result in results if result["code"] == "done"]
        self._stopped_up_to = max(self._stopped_up_to, *confirmed, 0)
        failed = [result for result in results if result["id"] > self._stopped_up_to]
        if failed:
            self._printer.print_failure(f"stop: {failed[-1]['text']}")
        self._conditions.check_again()

    def on_request_ended(self) -> None:
        """Do nothing: each line is waited for."""

    @property
    def is_behind(self) -> bool:
        """True while the output is not written."""
        return not self._output.is_done

    # The end.

    async def _wait_for_the_end(self) -> None:
        """Wait for the STOPs and goals that were requested, and print what is left."""
        wait = self._conditions.wait
        await wait(lambda: self._input.is_quiet)  # A STOP may have come with the last line.
        await wait(lambda: self._goals_have_ended() or self._is_goal_silent)
        if self._goal is not None and not self._goals_have_ended():
            self._printer.print_timed(
                f"waiting for the end of {self._goal.name}; ctrl+c cancels it"
            )
        await wait(self._goals_have_ended)
        lost = self._lost_goal_outcome
        if lost is not None:
            self._printer.has_failed = True
            self._printer.print_timed(lost.text)
        last_stop = self._robot.stops.count
        await wait(lambda: self._are_answered(last_stop))
        await self._robot.wait_for_events()
        self._on_snapshot(self._robot.snapshot)
        reason = self._station.queue.hold_reason
        if reason:
            waiting = ", ".join(goal.text for goal in self._station.queue.waiting)
            self._printer.print_timed(f"not driven: {waiting} ({reason})")
        await wait(lambda: self._output.is_done)

    def _goals_have_ended(self) -> bool:
        """Return True if no goal of this console runs or is about to be sent, or one is lost."""
        is_running = self._goal is not None and self._goal.is_running and self._goal.mine
        is_due = is_running or self._station.queue.is_going
        return self._lost_goal_outcome is not None or not is_due

    @property
    def _goal(self) -> Goal | None:
        return self._printer.goal

    @property
    def _lost_goal_outcome(self) -> Outcome | None:
        """The outcome of this console's running goal if it counts as lost by now; or None."""
        goal = self._goal
        if goal is None or not (goal.is_running and goal.mine):
            return None
        return goal.outcome_at(self._clock.monotonic())

    @property
    def _is_goal_silent(self) -> bool:
        """True while the goal's phase is UNKNOWN or LOST: its end may never be reported."""
        return self._goal is not None and self._goal.phase in (Phase.UNKNOWN, Phase.LOST)

    # Questions and requests, which a person answers.

    async def ask(self, question: Question) -> None:
        """Ask the person at the terminal: ArchoError unless the next line is yes, Void at a STOP.

        A line that is neither yes nor no means no, too, and is carried out as a command.
        """
        first, *more = (" ".join(line.split()) for line in question.text.splitlines() if line)
        if more:
            self._printer.print_text("\n".join((first, *more)))
        text = f"{question.go}?" if more else first
        if not self._input.is_terminal:
            raise ArchoError(f"{text} (add {YES} to do it)")
        gate = self._robot.stops.gate()
        self._printer.print_timed(f"{text} [y/N]")
        self._is_asking = True
        try:
            await self._conditions.wait(lambda: gate.is_shut or self._input.has_line_or_end)
            line = await self._next_line() if self._input.has_line_or_end else None
            self._put_back = line
        finally:
            self._is_asking = False
        # A terminal hands over one line a read: a STOP may be right behind the answer.
        await self._conditions.wait(lambda: self._input.is_quiet)
        answer = "" if line is None else line.text.strip().lower()
        if line is None or (not line.fault and answer in ("", *YES_WORDS, *_NO)):
            self._put_back = None
        gate()
        if answer not in YES_WORDS:
            raise ArchoError("not done: the answer was not yes")

    async def _answer_request(self, word: str, rest: list[str]) -> None:
        """Allow or deny what an assistant requested, if a person has read the request.

        An answer counts only if it was typed alone, 0.3 s or more after the line before, a second
        or more after the request was printed, and if all output is written.
        """
        fault = ""
        if not self._input.is_terminal:
            fault = "only a person at a terminal answers an assistant"
        elif len(rest) != 1 or not (rest[0].isascii() and rest[0].isdecimal()) or len(rest[0]) > 9:
            fault = "needs the number of a request"
        else:
            # The rest of a paste, or a STOP, may be right behind this line.
            await self._conditions.wait(lambda: self._input.is_quiet)
            number, (read_at, pause) = int(rest[0]), self._input.last_line_timing
            shown_at = self._printer.requests_shown_at.get(number)
            # Whoever types an answer ahead, or pastes it with other lines, has not read it.
            is_alone = pause >= _PAUSE_BEFORE_ANSWER and not self._input.has_line_or_end
            is_read = shown_at is not None and read_at - shown_at >= READING_TIME
            if shown_at is None and self._station.approvals.get(number) is None:
                fault = f"there is no request {number}"
            elif not (is_read and is_alone and self._output.is_done):
                fault = "read the request first, then answer it in a line of its own"
            else:
                outcome = self._station.approvals.answer(number, allowed=word == "allow")
                fault = "" if outcome.ok else outcome.text
        if fault:
            self._printer.print_failure(f"{word}: {fault}")
        self._conditions.check_again()

    # What the station calls (`station.Frontend`).

    def carry_out(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        """Run work as a task beside the others; the end of the input does not wait for it."""
        self._start(work())

    run_in_background = carry_out

    def on_goal_answered(self, wanted: QueuedGoal, outcome: Outcome) -> None:
        """Print why the robot did not accept a goal of the queue; an accepted one comes as news."""
        if not outcome.ok:
            self._printer.print_failure(f"{wanted.text}: {outcome.text}")
        self._station.refresh()
        self._conditions.check_again()

    @property
    def has_person(self) -> bool:
        """True at a terminal; a script cannot answer an assistant's request."""
        return self._input.is_terminal

    def close_questions(self) -> None:
        """Have `ask` see the STOP, by which it ends without an answer."""
        self._conditions.check_again()

    def restart(self, why: str) -> None:
        """Log a warning only: restarting would lose lines that were read already."""
        self._robot.note("WARN", "console", f"{why}: they count from the next start on")


def run(station: Station, read: int | None) -> int:
    """Operate a station until the end, with the process's signals; return the exit code."""

    async def operate() -> int:
        return await Plain(station, read, sys.stdout.fileno()).run()

    return asyncio.run(operate())
