"""The frontend of `archo-tui --plain`, for scripts, screen readers and simple terminals.

Lines are carried out one after the other, by these rules:

- STOP is no line: `Input` counts it as it is read, and `StopSender` sends it at once.
- A line runs only after every STOP before it was answered (`_next_line`), and what it requests is
  not sent if a STOP was read after it (`robot/stop/gate.py`; `_carry_out` sets the line's count).
- `cancel` directly behind a line does not wait for that line's answer (`_carry_out`).
- The end waits for each STOP, each slow line and the last goal (`_wait_for_the_end`).
"""

from __future__ import annotations

import asyncio
import shlex
import sys
from collections.abc import Callable, Coroutine, Mapping
from typing import TYPE_CHECKING

from archo_tui.errors import ArchoError
from archo_tui.plain.conditions import Conditions
from archo_tui.plain.input import Input, TypedLine
from archo_tui.plain.output import Output
from archo_tui.plain.printer import Printer
from archo_tui.plain.stop_sender import StopSender
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import SLOW_CALL, Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import NOT_SENT, Void
from archo_tui.shutdown import Shutdown
from archo_tui.station.approvals import READING_TIME
from archo_tui.verbs import verbs
from archo_tui.verbs.base import ROBOT_TIMEOUT, Question, Values, Verb
from archo_tui.verbs.called import choose_verb
from archo_tui.verbs.inspect import FOLLOW, Echo, FollowedMessage
from archo_tui.verbs.parse import YES, UnknownVerbError, parse
from archo_tui.verbs.run_when_ready import run_when_ready
from archo_tui.verbs.status import Status
from archo_tui.words import line_by_line

if TYPE_CHECKING:
    from archo_tui.station.station import Station

# All in seconds.
_PAUSE_BEFORE_ANSWER = 0.3  # Since the line before an answer to an assistant; no paste has it.
_READER_PATIENCE = 2.0  # For a slow reader of the output, before the next line is carried out.
_LAST_WRITE = 0.5  # At the end, for STOPs to be answered and the output to be written.
_QUICK_ANSWER = 0.2  # For a line's answer before `cancel` overtakes it; nearly all have one then.

_YES, _NO = ("y", "yes"), ("n", "no")


def help_text(all_verbs: Mapping[str, Verb]) -> str:
    """Return what `help` prints: each verb with its values and what it does, one a line."""
    lines = [verb.help_line for verb in all_verbs.values()]
    return "\n".join((*lines, "help: List these", "quit: End, once the last goal has ended"))


class Plain:
    """The frontend that reads commands and prints what happens, one line each.

    All methods are called on the running loop, except `restart`: on any thread.
    """

    def __init__(self, station: Station, read: int | None, write: int) -> None:
        """Create the frontend; `run` reads and writes, and the descriptors stay open."""
        self._station, self._robot, self._clock = station, station.robot, station.clock
        self._conditions = Conditions(self._clock)
        self._input = Input(read, self._robot.stops, self._on_input, self._clock)
        self._output = Output(write, self._on_output)
        snapshot = self._robot.snapshot
        self._verbs = verbs(snapshot.file, snapshot.forms)
        status = self._verbs["status"]
        assert isinstance(status, Status)
        self._printer = Printer(
            station, self._output, status, is_ending=lambda: self._shutdown.has_begun
        )
        self._stop_sender = StopSender(
            station,
            self._verbs["stop"],
            self._input,
            self._conditions,
            self._start,
            self._printer.print_failure,
        )
        self._put_back: TypedLine | None = None  # Read as an answer, but it is a command.
        self._is_asking = False  # The next line is an answer.
        self._following: asyncio.Task[None] | None = None  # Prints the messages of a topic.
        self._running_beside = 0  # Slow lines that still run while later lines are carried out.
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
        for work in (self._serve, self._stop_sender.run, self._tick):
            self._start(work())
        try:
            code = await self._exit_code
            await self._conditions.wait_at_most(
                lambda: self._stop_sender.are_answered() and self._output.is_done, _LAST_WRITE
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
        self._start_task(work)

    def _start_task(self, work: Coroutine[None, None, None]) -> asyncio.Task[None]:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)

        def on_end(task: asyncio.Future[None]) -> None:
            self._tasks.discard(task)
            error = None if task.cancelled() else task.exception()
            if error is not None and not self._exit_code.done():
                self._exit_code.set_exception(error)

        task.add_done_callback(on_end)
        return task

    def _finish(self, code: int) -> None:
        """End `run` with an exit code; an earlier code or error stays."""
        if not self._exit_code.done():
            self._exit_code.set_result(code)

    def _on_input(self) -> None:
        if self._input.overflows > self._reported_overflows:
            self._reported_overflows = self._input.overflows
            self._printer.print_failure(
                "more than 1 MB of lines wait: further ones are refused, stop is not"
            )
        self._conditions.check_again()

    def _on_output(self) -> None:
        if self._output.is_broken and not self._exit_code.done():
            self._shutdown.begin(1)
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
                await self._carry_out(line)
            else:
                self._end_following()
        self._end_following()
        await self._wait_for_the_end()
        if not self._shutdown.has_begun:  # Otherwise the shutdown decides about the exit code.
            is_well = not self._printer.has_failed and not self._station.queue.waiting
            self._finish(0 if is_well and not self._output.is_broken else 1)

    async def _next_line(self) -> TypedLine | None:
        """Wait for the answers to all STOPs before the next line, and return it; None at the end.

        A command that was typed in place of an answer is returned at once. A slow reader of the
        output is waited for, 2 s at most.
        """
        if self._put_back is not None:
            line, self._put_back = self._put_back, None
            return line
        # This wait also lets all other tasks run between two lines, however many are typed. A
        # reader that does not read at all delays one line, not each.
        await self._conditions.wait_at_most(lambda: self._output.has_room, self._patience)
        self._patience = _READER_PATIENCE if self._output.has_room else 0.0
        await self._conditions.wait(lambda: self._input.has_line_or_end)
        next_line = self._input.take()
        if next_line is not None:
            up_to = next_line.stops_before
            await self._conditions.wait(lambda: self._stop_sender.are_answered(up_to))
        return next_line

    async def _wait_for_the_end(self) -> None:
        """Wait for the STOPs, slow lines and goals that were requested, and print what is left."""
        wait = self._conditions.wait
        await wait(lambda: self._input.is_quiet)  # A STOP may have come with the last line.
        await wait(lambda: not self._running_beside)
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
        await wait(lambda: self._stop_sender.are_answered(last_stop))
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

    async def _carry_out(self, line: TypedLine) -> None:
        """Carry out a line and wait for its answer, but not for that of a slow `call`.

        Each `cancel` directly behind the line is carried out meanwhile, if a goal runs.
        """
        with self._robot.stops.typed_at(line.stops_before):
            running = asyncio.ensure_future(self._execute(line))
        running.add_done_callback(lambda _: self._conditions.check_again())
        is_call = line.text.split()[:1] == ["call"]
        try:
            await self._conditions.wait_at_most(running.done, _QUICK_ANSWER)
            slow_at = self._clock.monotonic() + SLOW_CALL

            def is_slow() -> bool:
                return is_call and not self._is_asking and self._clock.monotonic() >= slow_at

            def may_go_on() -> bool:
                return running.done() or self._is_cancel_next or is_slow()

            while True:
                await self._conditions.wait(may_go_on)
                if is_slow() and not running.done():
                    self._run_beside_later_lines(running)
                    return
                if running.done() or (cancel := self._input.take()) is None:
                    break
                with self._robot.stops.typed_at(cancel.stops_before):
                    await self._execute(cancel)
            await running
        finally:
            if running not in self._tasks:
                running.cancel()

    @property
    def _is_cancel_next(self) -> bool:
        has_goal = self._station.running_goal is not None
        return has_goal and self._input.is_cancel_next and not self._is_asking

    def _run_beside_later_lines(self, running: asyncio.Future[None]) -> None:
        self._running_beside += 1
        self._tasks.add(running)

        def on_end(_: object) -> None:
            self._running_beside -= 1
            self._tasks.discard(running)
            self._conditions.check_again()

        running.add_done_callback(on_end)

    async def _execute(self, line: TypedLine) -> None:
        if line.fault:
            self._printer.print_failure(line.fault)
            return
        try:
            word, *rest = shlex.split(line.text)
        except ValueError:
            word, *rest = line.text.split()
            fault = "a quote is not closed, or nothing follows the last \\"
            self._printer.print_failure(f"{word}: {fault}")
            return
        try:
            outcome = await self._dispatch(word, rest)
        except Void:
            outcome = Outcome(Code.CANCELLED, NOT_SENT)
        except UnknownVerbError as error:  # Its text names the word.
            self._printer.print_failure(str(error))
            return
        except (ArchoError, ValueError) as error:
            outcome = Outcome(Code.MISUSE, str(error))
        if not outcome.ok:
            self._printer.print_failure(f"{word}: {outcome.text}")

    async def _dispatch(self, word: str, rest: list[str]) -> Outcome:
        """Run the verb that a line names, and print what was asked for; the caller prints failures.

        DONE at once for a followed topic and for verbs that take seconds, whose outcome is printed
        later. `skip` sets the exit code to 1.
        """
        if word in ("help", "quit") and rest:
            raise ValueError("takes no values")
        if word == "help":
            self._printer.print_text(help_text(self._verbs))
            return Outcome(Code.DONE, "")
        if word in ("allow", "deny"):
            return await self._answer_request(word, rest)
        station = self._station
        verb, rest = choose_verb(self._verbs, station, word, rest)
        values, yes = parse(verb, station, rest)
        if isinstance(verb, Echo) and values.get(FOLLOW):
            self._end_following()
            self._printer.print_text(f"following {values['topic']}; an empty line ends it")
            self._following = self._start_task(self._follow(verb, values))
            return Outcome(Code.DONE, "")
        if verb.started_text:
            self._printer.print_text(verb.started_text)
            self._running_beside += 1
            self._start(self._run_slow_verb(verb, values))
            return Outcome(Code.DONE, "")
        wait, ask = self._conditions.wait_at_most, None if yes else self._ask
        outcome = await run_when_ready(station, verb, values, wait, ask)
        # The snapshot may not have been delivered yet, and `_goals_have_ended` needs its goal.
        self._on_snapshot(self._robot.snapshot)
        if verb.tells_with(values) and outcome.ok:
            self._printer.print_text(outcome.text)
        waiting = [goal.text for goal in station.queue.waiting]
        if verb.moves and outcome.code == Code.ACCEPTED and waiting:
            self._printer.print_timed(
                f"queue: {line_by_line.queue_text(waiting, station.queue.hold_reason)}"
            )
        # A skipped goal will not arrive, so not all that was requested has succeeded.
        self._printer.has_failed = self._printer.has_failed or verb.id == "skip"
        return outcome

    async def _run_slow_verb(self, verb: Verb, values: Values) -> None:
        """Run a verb that the caller counted in `_running_beside`, and print its outcome."""
        try:
            outcome = await run_when_ready(
                self._station, verb, values, self._conditions.wait_at_most, None
            )
        except (ArchoError, ValueError) as error:
            outcome = Outcome(Code.MISUSE, str(error))
        finally:
            self._running_beside -= 1
        if outcome.ok:
            self._printer.print_text(outcome.text)
        else:
            self._printer.print_failure(f"{verb.id}: {outcome.text}")
        self._conditions.check_again()

    async def _follow(self, verb: Echo, values: Values) -> None:
        """Print each message of a topic, and how many were left out, until the task is cancelled.

        A topic that is not on the graph is waited for while the robot may still appear.
        """
        try:
            await self._conditions.wait_at_most(
                lambda: verb.is_ready(self._station, values), ROBOT_TIMEOUT - self._station.age
            )
            await verb.follow(
                self._station,
                values,
                self._print_followed,
                self._printer.print_timed,
                for_program=False,
                has_room=lambda: self._output.is_done,
            )
        except (ArchoError, ValueError) as error:
            self._printer.print_failure(f"{verb.id}: {error}")

    def _print_followed(self, shown: FollowedMessage) -> None:
        self._printer.print_text(f"{shown.text}\n---" if "\n" in shown.text else shown.text)
        if shown.left_out_text:
            self._printer.print_text(shown.left_out_text)

    def _end_following(self) -> None:
        if self._following is not None:
            self._following.cancel()
            self._following = None

    def _on_snapshot(self, snapshot: Snapshot) -> None:
        self._printer.print_news(snapshot)
        self._printer.print_alarms(self._station.on_snapshot(snapshot))
        self._printer.print_requests()
        self._conditions.check_again()

    # Questions and requests, which a person answers.

    async def _ask(self, question: Question) -> None:
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
        finally:
            self._is_asking = False
        # A terminal hands over one line a read: a STOP may be right behind the answer.
        await self._conditions.wait(lambda: self._input.is_quiet)
        answer = "" if line is None else line.text.strip().lower()
        if line is not None and (line.fault or answer not in ("", *_YES, *_NO)):
            self._put_back = line
        gate()
        if answer not in _YES:
            raise ArchoError("not done: the answer was not yes")

    async def _answer_request(self, word: str, rest: list[str]) -> Outcome:
        """Allow or deny what an assistant requested, if a person has read the request.

        An answer counts only if it was typed alone, 0.3 s or more after the line before, a second
        or more after the request was printed, and if all output is written.
        """
        if not self._input.is_terminal:
            raise ValueError("only a person at a terminal answers an assistant")
        if len(rest) != 1 or not rest[0].isascii() or not rest[0].isdecimal() or len(rest[0]) > 9:
            raise ValueError("needs the number of a request")
        # The rest of a paste, or a STOP, may be right behind this line.
        await self._conditions.wait(lambda: self._input.is_quiet)
        number, (read_at, pause) = int(rest[0]), self._input.last_line_timing
        shown_at = self._printer.requests_shown_at.get(number)
        if shown_at is None and self._station.approvals.get(number) is None:
            return Outcome(Code.REFUSED, f"there is no request {number}")
        # Whoever types an answer ahead, or pastes it with other lines, has not read the request.
        is_alone = pause >= _PAUSE_BEFORE_ANSWER and not self._input.has_line_or_end
        is_read = shown_at is not None and read_at - shown_at >= READING_TIME
        if not is_read or not is_alone or not self._output.is_done:
            return Outcome(
                Code.REFUSED, "read the request first, then answer it in a line of its own"
            )
        outcome = self._station.approvals.answer(number, allowed=word == "allow")
        self._conditions.check_again()
        return outcome

    # What the station calls (`station.Frontend`).

    def carry_out(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        """Run work as a task beside the others; the end of the input does not wait for it."""
        self._start(work())

    def run_in_background(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        self._start(work())

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
        """Do nothing: `_ask` watches for a STOP itself, and ends without an answer."""

    def restart(self, why: str) -> None:
        """Log a warning only: restarting would lose lines that were read already."""
        self._robot.note("WARN", "console", f"{why}: they count from the next start on")


def run(station: Station, read: int | None) -> int:
    """Operate a station until the end, with the process's signals; return the exit code."""

    async def operate() -> int:
        return await Plain(station, read, sys.stdout.fileno()).run()

    return asyncio.run(operate())
