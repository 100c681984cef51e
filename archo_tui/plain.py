"""`archo-tui --plain`: the station line by line, for scripts, screen readers, dumb terminals."""

from __future__ import annotations

import asyncio
import contextlib
import shlex
import sys
from collections import deque
from collections.abc import Awaitable, Callable, Coroutine
from functools import partial
from typing import TYPE_CHECKING

from archo_tui import goal_text, state_text
from archo_tui.alarms import Alarm, advice, ways
from archo_tui.clock import time_of_day
from archo_tui.plain_input import Input, Line
from archo_tui.plain_output import Output
from archo_tui.robot import forms
from archo_tui.robot.parameter_values import parse, range_text
from archo_tui.robot.state import Goal, Outcome, Parameter, Phase, Snapshot
from archo_tui.robot.stops import NOT_SENT, Void
from archo_tui.robot.text import safe
from archo_tui.robot.values import text_of
from archo_tui.robots.model import GoalKind, Robot
from archo_tui.shutdown import Shutdown
from archo_tui.targets import Target
from archo_tui.terminal.ascii import ascii_only, in_ascii

if TYPE_CHECKING:
    from archo_tui.station import Station

_SHOWN_LEVELS = ("YOU", "PEER", "WARN", "ERROR", "FATAL")
_WAIT = 5.0  # s for the robot to be there before a command is tried
_THERE = 2.0  # s from the start in which all of its topics are on the graph
_APART = 1.0  # s between a STOP and the next but one, when they are all that is typed
_SLOW = 2.0  # s for the reader to catch up before the next line; once, if it does not read at all
_LAST = 0.5  # s after a signal for a STOP to be answered, and for what is not written yet
_MOST_GOALS = 1000  # that wait in the queue


def help_text(robot: Robot) -> str:
    """The commands, a line each."""
    lines = [
        *((_typed("go", kind), kind.title) for kind in robot.goals[:1]),
        *((_typed(kind.id, kind), kind.title) for kind in robot.goals[1:]),
        ("cancel", "cancel the running goal; what waits behind it is held"),
        ("continue, skip", "continue a held queue of goals, or leave out its next one"),
        ("stop", "software stop, at once and latched; not the hardware one"),
        ("release", "release the stop; nothing resumes by itself"),
    ]
    for command in robot.commands:
        names = ", ".join(filter(None, (command.id, command.off_word)))
        lines.append((names, command.help or command.title))
    lines += [
        ("set NODE NAME VALUE", "set a parameter; quotes as in a shell: 'a  b', ''"),
        ("undo", "undo your last change of a parameter"),
        ("params", "list the parameters"),
        ("status", "show the state of the robot"),
        ("quit", "end, once the running goal has ended"),
    ]
    return "\n".join(f"{names:<25} {does[0].lower()}{does[1:]}" for names, does in lines)


def _typed(verb: str, kind: GoalKind) -> str:
    """How a goal is given: `go N ...`, or `go x=... y=...`."""
    labels = [given.label or path for path, given in kind.form.items()]
    several = " ".join(f"{label.lower()}=..." for label in labels)
    return f"{verb} {'N ...' if len(labels) == 1 else several}".rstrip()


class Plain:
    """Reads commands, prints what happens, one line each."""

    def __init__(self, station: Station, read: int | None, write: int) -> None:
        """Reads from and writes to file descriptors; `read` is None where there is no input."""
        self._station, self._robot, self._clock = station, station.robot, station.clock
        self._changed = asyncio.Event()
        self._input = Input(read, self._robot.stops, self._heard)
        self._output = Output(write, self._written)
        self._ascii = ascii_only()
        names = ("release", *(command.id for command in station.robot.description.commands))
        goals = station.robot.description.goals
        # how a goal is given
        self._ask = f"Type {_typed('go', goals[0])} to give one." if goals else ""
        self._ways = ways(station.robot.description, {name: f"type {name}" for name in names})
        self._begun = station.clock.monotonic()
        self._printed: set[int] = set()  # the numbers of events that were printed
        self._goal: Goal | None = None
        self._failed = False  # a line, or a goal
        self._sent: Outcome | None = None  # how the robot answered what was sent last
        self._answered = self._robot.stops.count  # so many STOPs are
        self._has_run = False  # some other line since the last STOP
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
        if self._output.is_broken:
            self._shutdown.begin(1)
        self._changed.set()

    async def _obey(self) -> None:
        """Send the STOPs: one that is sent covers all that were read before."""
        sent = deque([-_APART] * 2, maxlen=2)  # when the last two were
        while True:
            await self._hold(lambda: not self._are_answered())
            # of a flood only two a second reach the robot, unless something else left meanwhile
            spared = sent[0] + _APART - self._clock.monotonic()
            if spared > 0:
                await self._until(lambda: self._has_run, spared)
            await self._until(lambda: self._robot.snapshot.offered, _WAIT)
            sent.append(self._clock.monotonic())
            covered, self._has_run = self._robot.stops.count, False
            outcome = await self._robot.emergency_stop()
            self._answered = covered
            if not outcome.ok:
                self._fail(f"stop: {outcome.text}")
            self._changed.set()

    def _are_answered(self) -> bool:
        """True when the robot has answered every STOP that was read, or did not in time."""
        return self._answered >= self._robot.stops.count

    async def _serve(self) -> None:
        while (line := await self._line()) is not None and line.text.split() != ["quit"]:
            if line.fault or line.text.split():  # else blanks of some other script
                with self._robot.stops.at(line.stops):
                    await self._run(line)
        await self._hold(lambda: self._input.is_quiet)  # a stop may have come with the last line
        await self._hold(self._is_over)
        last = self._robot.stops.count
        await self._hold(lambda: self._answered >= last)
        held = self._station.targets.held
        if held:
            waiting = ", ".join(target.text for target in self._station.targets.waiting)
            self._say(f"not driven: {waiting} ({held})")
        await self._hold(lambda: self._output.is_done)
        if not self._shutdown.has_begun:
            well = not self._failed and not self._station.targets.waiting
            well = well and not self._output.is_broken
            self._finish(0 if well else 1)

    async def _line(self) -> Line | None:
        """The next one, once every STOP before it is answered; None at the end of the input."""
        # this also gives everything else its turn, however much is typed
        await self._until(lambda: self._output.has_room, self._patience)
        self._patience = _SLOW if self._output.has_room else 0.0
        await self._hold(lambda: self._input.has_news)
        line = self._input.take()
        if line is not None:
            await self._hold(lambda: self._answered >= line.stops)
        return line

    def _is_over(self) -> bool:
        """No goal of ours runs, and none is to be sent."""
        goal, targets = self._goal, self._station.targets
        runs = goal is not None and goal.is_running and goal.mine
        return not runs and not targets.is_going

    async def _tick(self) -> None:
        while True:
            await self._clock.sleep(1.0)
            self._tell_alarms(self._station.tick())
            self._changed.set()

    def _finish(self, code: int) -> None:
        if not self._end.done():
            self._end.set_result(code)

    def _out(self, text: str) -> None:
        lines = [safe(line) for line in text.splitlines()]
        self._output.put(
            "".join(f"{in_ascii(line) if self._ascii else line}\n" for line in lines).encode()
        )

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
        gate = self._robot.stops.gate()
        self._has_run = self._has_run or not gate.is_shut
        try:
            outcome = await self._do(verb, rest)
        except Void:
            outcome = Outcome(False, NOT_SENT)
        if outcome is not None and not outcome.ok:
            self._fail(f"{verb}: {outcome.text}")

    async def _do(self, verb: str, rest: list[str]) -> Outcome | None:
        robot = self._robot
        if verb == "set":
            return await self._set(rest)
        kind = self._kind(verb)
        if kind is not None:
            return await self._go(kind, rest)
        if rest:
            return Outcome(False, f"unknown: {' '.join([verb, *rest])} (help lists the commands)")
        simple: dict[str, Callable[[], Awaitable[Outcome]]] = {
            "release": robot.release_emergency_stop,
        }
        for command in robot.description.commands:
            simple[command.id] = partial(robot.command, command)
            if command.toggle:
                simple[command.off_word] = partial(robot.command, command, False)
        if verb in ("continue", "skip"):
            return self._queue(verb)
        if verb == "cancel":  # which no STOP voids
            await self._until(lambda: robot.snapshot.offered, _WAIT)
            return await robot.cancel()
        if verb in simple:
            await self._for_robot(lambda: robot.snapshot.offered)
            return await simple[verb]()
        if verb == "undo":
            return await self._undo()
        if verb == "help":
            self._out(help_text(robot.description))
        elif verb == "params":
            await self._until(self._are_reported, self._left(_WAIT))
            self._params()
        elif verb == "status":
            await self._until(self._is_heard, self._left(_WAIT))
            self._status()
        else:
            return Outcome(False, f"no command {verb!r} (help lists them)")
        return None

    def _left(self, seconds: float) -> float:
        """How much of that time since the start has not passed."""
        return max(self._begun + seconds - self._clock.monotonic(), 0.0)

    def _are_reported(self) -> bool:
        """True when every node of the robot has reported its parameters."""
        snapshot = self._robot.snapshot
        nodes = {node.name for node in snapshot.nodes}
        return bool(nodes) and nodes <= {p.node for p in snapshot.parameters}

    def _is_heard(self) -> bool:
        """True when battery and motion are, as far as the robot has them."""
        snapshot, robot = self._robot.snapshot, self._robot.description
        missing = []
        if robot.battery is not None and snapshot.battery.received is None:
            missing.append(robot.battery.topic)
        if robot.motion is not None and snapshot.motion.received is None:
            missing.append(robot.motion.topic)
        return not any(topic in snapshot.offered or self._left(_THERE) for topic in missing)

    def _queue(self, verb: str) -> Outcome:
        station = self._station
        if not station.targets.waiting:
            return Outcome(False, "no goal waits in the queue")
        if verb == "continue":
            return station.resume()
        self._failed = True  # one goal less that arrives
        station.drop()
        return Outcome(True, "")

    def _kind(self, verb: str) -> GoalKind | None:
        """The goal of the robot file that a verb sends: `go` is the first one."""
        goals = self._robot.description.goals
        if verb == "go" and goals:
            return goals[0]
        return next((kind for kind in goals if kind.id == verb), None)

    async def _go(self, kind: GoalKind, words: list[str]) -> Outcome:
        leaves = self._robot.snapshot.forms[kind.id]
        several = len(leaves) == 1 and forms.is_number(leaves[0]) and "=" not in "".join(words)
        rows = [[word] for word in words] if several and words else [words]
        if len(self._station.targets.waiting) + len(rows) > _MOST_GOALS:
            return Outcome(False, f"more than {_MOST_GOALS} goals would wait")
        try:
            targets = [
                Target(
                    kind, forms.parse_all(leaves, kind.form, forms.named(leaves, kind.form, row))
                )
                for row in rows
            ]
        except ValueError as error:
            return Outcome(False, str(error))
        await self._for_robot(lambda: kind.action in self._robot.snapshot.offered)
        outcome = await self._send_all(targets)
        self._take(self._robot.snapshot)  # the goal is known before the end is looked for
        return outcome

    def carry_out(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        """Beside the rest."""
        self._start(work())

    def goal_answered(self, target: Target, outcome: Outcome, *, queued: bool) -> None:
        """One from the queue is not waited for by its line: it is said."""
        self._sent = outcome
        if not outcome.ok and queued:
            self._fail(f"{target.text}: {outcome.text}")
        self._station.look()
        self._changed.set()

    def restart(self, why: str) -> None:
        """Not here, and said: lines that are read already would be lost."""
        self._robot.note("WARN", "console", f"{why}: they count from the next start on")

    async def _send_all(self, targets: list[Target]) -> Outcome:
        """The first at once, or behind what runs; the others one after the other."""
        self._sent = None
        going = self._station.targets.is_going
        goal = self._robot.snapshot.running_goal
        self._station.submit(targets)
        if going or goal is not None:
            return Outcome(True, "queued")
        await self._until(lambda: self._sent is not None)
        assert self._sent is not None
        return self._sent

    async def _set(self, words: list[str]) -> Outcome:
        if len(words) < 3:
            return Outcome(False, f"needs NODE NAME VALUE{self._meant(words)}")
        node, name, text = words[0], words[1], " ".join(words[2:])
        full = node if node.startswith("/") else f"/{node}"

        def found() -> list[Parameter]:
            known = self._robot.snapshot.parameters
            return [p for p in known if (p.node, p.name) == (full, name)]

        await self._for_robot(found)
        for parameter in found():
            try:
                value = parse(parameter, text)
            except ValueError as error:
                return Outcome(False, f"{node} {name}: {error}")
            outcome = await self._station.set_parameters(full, {name: value})
            return outcome if outcome.ok else Outcome(False, f"{node} {name}: {outcome.text}")
        return Outcome(False, f"{full} has no parameter {name}")

    def _meant(self, words: list[str]) -> str:
        """The line with the node, when just that is missing."""
        known = self._robot.snapshot.parameters
        nodes = [p.node.lstrip("/") for p in known if len(words) == 2 and p.name == words[0]]
        return f": set {nodes[0]} {shlex.join(words)}" if len(nodes) == 1 else ""

    async def _undo(self) -> Outcome:
        snapshot, edits = self._robot.snapshot, self._station.edits
        reason = edits.blocked(snapshot)
        others = [f"{name} is {text_of(v)}" for name, v in edits.changed_since(snapshot).items()]
        if others and not reason:  # the screen asks; here only what is sure is done
            reason = f"changed by somebody else since: {', '.join(others)}"
        return Outcome(False, reason) if reason else await self._station.undo()

    def _params(self) -> None:
        for p in self._robot.snapshot.parameters:
            mark = "*" if p.is_changed else ""
            line = f"{p.node.lstrip('/')} {p.name} {text_of(p.value)}{mark} {p.type}"
            self._out(f"{line} {range_text(p)}".rstrip())

    def _status(self) -> None:
        snapshot, now = self._robot.snapshot, self._clock.monotonic()
        plain = state_text.plain
        self._out(f"battery {plain(state_text.battery_line(snapshot, now, 80))}")
        title = snapshot.robot.motion.title.lower() if snapshot.robot.motion else "motion"
        self._out(f"{title} {plain(state_text.motion_word(snapshot, now, 80))}")
        self._out(f"{title} {plain(state_text.motion_line(snapshot, now)).strip()}")
        for reading in snapshot.gauges:
            self._out(plain(state_text.gauge_line(reading, now)))
        self._out(f"goal {plain(goal_text.goal_line(snapshot, now, self._ask))}")
        for alarm in self._station.view.alarms:
            self._out(f"alarm {advice(alarm, self._ways)}")

    # what happens

    def _take(self, snapshot: Snapshot) -> None:
        for event in snapshot.events:
            if event.number not in self._printed and event.level in _SHOWN_LEVELS:
                count = f" (x {event.count})" if event.count > 1 else ""  # since the last look
                self._say(f"{event.level} {event.source}: {event.text}{count}", event.time)
        self._printed = {event.number for event in snapshot.events}
        self._tell_goal(snapshot)
        self._tell_alarms(self._station.take(snapshot))
        self._changed.set()

    def _tell_goal(self, snapshot: Snapshot) -> None:
        goal, before = snapshot.goal, self._goal
        self._goal = goal
        if any(ended.mine and ended.phase != Phase.ARRIVED for ended in snapshot.history):
            self._failed = True
        if goal is None:
            return
        same = before is not None and before.sent == goal.sent
        if before is None or not same or _said_of(before) != _said_of(goal):
            line = goal_text.goal_line(snapshot, self._clock.monotonic(), self._ask)
            self._say(f"goal {' '.join(state_text.plain(line).split())}")

    def _tell_alarms(self, changed: list[Alarm]) -> None:
        for alarm in changed:
            self._say(f"alarm {alarm.state.value}: {advice(alarm, self._ways)}")

    def _fail(self, said: str) -> None:
        """Say what did not succeed; the exit code will."""
        self._say(f"failed: {said}")
        self._failed = True

    def _say(self, text: str, at: float | None = None) -> None:
        self._out(f"{time_of_day(self._clock.now() if at is None else at)} {text}")

    async def _for_robot(self, holds: Callable[[], object]) -> None:
        """Wait for it to be there; raises Void when a STOP is read meanwhile."""
        gate = self._robot.stops.gate()
        await self._until(lambda: gate.is_shut or holds(), _WAIT)
        gate()

    async def _until(self, condition: Callable[[], object], timeout: float | None = None) -> None:
        """Wait until the condition holds after a snapshot, or the time (s) has passed."""
        with contextlib.suppress(TimeoutError):
            await self._clock.wait_for(self._hold(condition), timeout)

    async def _hold(self, condition: Callable[[], object]) -> None:
        while not condition():
            self._changed.clear()
            await self._changed.wait()


def _said_of(goal: Goal) -> tuple[Phase, float | None]:
    return goal.phase, goal.remaining


def run(station: Station, read: int | None) -> int:
    """Operate through a descriptor and standard output; returns the exit code."""

    async def operate() -> int:
        return await Plain(station, read, sys.stdout.fileno()).run()

    return asyncio.run(operate())
