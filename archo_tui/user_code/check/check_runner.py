"""The checker's own ROS node, and its view of the programs that it checks."""

from __future__ import annotations

import linecache
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from rcl_interfaces.msg import Log
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.robot.state.graph import logger_node
from archo_tui.robot.state.snapshot import Life
from archo_tui.user_code.errors import WORDLESS
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.host import Host
from archo_tui.user_code.program import HostedProgram
from archo_tui.user_code.source import Source

ANSWER = 3.0  # Seconds in which an answer or a log line must arrive.
_RESTART = 10.0  # Seconds in which a program that runs again must have made its nodes.
_MIN_RUN = 1.5  # Seconds, so that a timer of 1 s fires once.
_SPIN_TIME = 0.05  # Seconds of one spin of the checker's executor.
_WAKE_TIME = 2.0  # Seconds in which an executor that was woken takes its turn, and a process ends.
_MAX_TRIES = 5  # For programs that crash again and again.
_THREAD_CRASH = "exception in thread "  # The first words of what a thread's error prints.
_FRAME = re.compile(r'  File "(.+)", line (\d+), in ')


class CrashedError(Exception):
    """The error for a program that crashed during a check, with the mistake and its line."""


class CheckedNode(NamedTuple):
    """A node of a checked program, as `Probe` describes it, by its own names of what it has."""

    file: ProgramFile
    name: str
    publishers: dict[str, Any]
    subscriptions: dict[str, Any]
    services: dict[str, Any]
    actions: dict[str, str]
    parameters: dict[str, Any]
    numbers: dict[str, Any]


class CheckRunner:
    """The checker's own ROS node, and what checks need: queries, logs and restarts of programs."""

    def __init__(
        self,
        host: Host,
        context: Context,
        clock: Clock,
        radius: float,
        printed: Sequence[str],
    ) -> None:
        """Create the checker's node beside the programs, and hear their logs."""
        self.radius = radius  # In m, that the file gives all nodes.
        self.printed = printed  # The lines of the programs, which grow while they run.
        self._host, self._clock = host, clock
        self.node = Node("_archo_check", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._began = self.now()
        self._crashes: dict[str, None] = {}  # A dict keeps the order and drops repetitions.
        self.logs: list[Log] = []
        self.node.create_subscription(Log, "/rosout", self.logs.append, 100)

    def close(self) -> None:
        """Destroy the checker's node."""
        self._executor.shutdown(0)
        self.node.destroy_node()

    def now(self) -> float:
        """Return monotonic time, in s."""
        return self._clock.monotonic()

    def restart_crashed(self) -> None:
        """Record the crashes of programs, and run these again."""
        for hosted in self._crashed():
            self._crashes[hosted.crash] = None
            self._host.start_again(hosted)
            for again in self._host.programs:
                if again.file is hosted.file:
                    again.wait(_RESTART)

    def _crashed(self) -> list[HostedProgram]:
        return [hosted for hosted in self._host.programs if hosted.state.life is Life.CRASHED]

    def nodes(self) -> list[CheckedNode]:
        """Restart crashed programs, and return their nodes; none after five crashes in a row."""
        for _ in range(_MAX_TRIES):
            self.restart_crashed()
            found = [
                CheckedNode(hosted.file, **node)
                for hosted in self._host.programs
                for node in self._ask_nodes(hosted)
            ]
            if not self._crashed():
                return found
        return []

    def _ask_nodes(self, program: HostedProgram) -> list[dict[str, Any]]:
        """Return what the program's nodes have; ask again while one is just made, ANSWER seconds.

        A program that has ended has none.
        """
        answer: dict[str, Any] = {}

        def is_answered() -> bool:
            answer.update(program.ask({"ask": "nodes"}))
            return "nodes" in answer or program.is_over

        self.spin_until(is_answered, ANSWER)
        found: list[dict[str, Any]] = answer.get("nodes", [])
        return found

    def programs_of(self, nodes: Sequence[CheckedNode]) -> list[HostedProgram]:
        """Return the programs of some nodes, as they run now."""
        files = [node.file for node in nodes]
        return [hosted for hosted in self._host.programs if hosted.file in files]

    def set_numbers(self, node: CheckedNode, values: dict[str, Any]) -> None:
        """Set attributes of a node."""
        for hosted in self.programs_of([node]):
            hosted.ask({"ask": "set", "node": node.name, "values": values})

    def wait_for_crashes(self) -> None:
        """Restart crashed programs, and spin until the checker is 1.5 s old, or one crashes.

        So a timer of 1 s has fired by then.
        """
        self.restart_crashed()
        is_over = lambda: bool(self._crashed())  # noqa: E731
        self.spin_until(is_over, self._began + _MIN_RUN - self.now())

    def collect_crashes(self) -> list[str]:
        """Return a line for each different crash so far.

        Crashes of programs come first, the oldest before the others, then those of threads.
        """
        for hosted in self._crashed():
            self._crashes[hosted.crash] = None
        for number, line in enumerate(self.printed):
            if line.startswith(_THREAD_CRASH):
                self._crashes[line.partition(": ")[2]] = None
            elif line.startswith("Exception in thread "):
                self._crashes |= dict.fromkeys([*self._tracebacks(number)][:1])
        return list(self._crashes)

    def busy_line(self, nodes: Sequence[CheckedNode]) -> str:
        """Return `FILE:LINE, in: ...` of the line that a callback of some nodes executes now."""
        for hosted in self.programs_of(nodes):
            line: str = hosted.ask({"ask": "busy"}).get("busy", "")
            if line:
                return line
        return ""

    def find_line(self, nodes: Sequence[CheckedNode], ask: Callable[[Source], int | None]) -> str:
        """Return `FILE:LINE: ` for the first node in whose file `ask` finds a line, or ""."""
        return _find_line([node.file for node in nodes], ask)

    def find_text(self, text: str) -> str:
        """Return `FILE:LINE: ` of the first string literal `text` in the programs' files, or "".

        Slashes at the ends of the text do not matter.
        """
        files = [hosted.file for hosted in self._host.programs]
        return _find_line(files, lambda source: source.line_of_text(text))

    def last_exception(self, since: int) -> str:
        """Return the last printed exception of the programs, in one line with its place, or "".

        rclpy prints the traceback of an exception of an execute callback and goes on.
        """
        return ([*self._tracebacks(since)] or [""])[-1]

    def _tracebacks(self, since: int) -> Iterator[str]:
        """Yield the error of each printed traceback with a line of the programs' files.

        Each is one line: `FILE:LINE: TypeError: ..., in: x = y + 1`.
        """
        where = text = ""
        for line in self.printed[since:]:
            frame = _FRAME.match(line)
            if frame is not None:
                for hosted in self._host.programs:
                    if hosted.file.code.is_own(frame[1]):
                        where = f"{hosted.file.code.display_name(frame[1])}:{frame[2]}"
                        text = linecache.getline(frame[1], int(frame[2])).strip()
            elif where and line[:1].strip():
                yield f"{where}: {WORDLESS.get(line, line)}, in: {text}"
                where = ""

    def logs_of(self, nodes: Sequence[CheckedNode], since: int) -> Iterator[Log]:
        """Yield the log lines of some nodes from an index in `logs` on."""
        names = {node.name for node in nodes}
        return (log for log in self.logs[since:] if logger_node(log.name) in names)

    def spin_until(
        self, holds: Callable[[], object], seconds: float, nodes: Sequence[CheckedNode] = ()
    ) -> bool:
        """Spin until `holds()`; return False when time is over. CrashedError if a node crashed."""
        end = self.now() + seconds
        while not holds():
            for hosted in self.programs_of(nodes):
                if hosted.state.life is Life.CRASHED:
                    raise CrashedError(hosted.crash)
            if self.now() > end:
                return False
            self._executor.spin_once(timeout_sec=_SPIN_TIME)
        return True

    def wait_for_result(self, future: Any, nodes: Sequence[CheckedNode]) -> Any:
        """Spin until a future is done, and return its result; None after ANSWER seconds."""
        if not self.spin_until(future.done, ANSWER, nodes):
            self.wake(nodes)
        return future.result() if future.done() else None

    def wake(self, nodes: Sequence[CheckedNode]) -> None:
        """Give the executors of some nodes a turn, at which they raise what callbacks raised."""
        for hosted in self.programs_of(nodes):
            hosted.ask({"ask": "wake"})
        self.spin_until(lambda: False, _WAKE_TIME, nodes)


def _find_line(files: Sequence[ProgramFile], ask: Callable[[Source], int | None]) -> str:
    for file in files:
        line = ask(file.source)
        if line is not None:
            return f"{file}:{line}: "
    return ""
