"""The checker's own ROS node, and its view of the nodes that it checks."""

from __future__ import annotations

import contextlib
import linecache
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import Log
from rclpy._rclpy_pybind11 import InvalidHandle, NodeNameNonExistentError
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from archo_tui.hosting.explain import WORDLESS, code_of
from archo_tui.hosting.hosted_node import HostedNode
from archo_tui.hosting.source import Source
from archo_tui.hosting.time_limit import stack_of
from archo_tui.robot.state.graph import logger_node
from archo_tui.robot.state.snapshot import Life
from archo_tui.session import Session

T = TypeVar("T")

ANSWER = 3.0  # Seconds in which an answer or a log line must arrive.
_MIN_RUN = 1.5  # Seconds, so that a timer of 1 s fires once.
_SPIN_TIME = 0.05  # Seconds of one spin of the checker's executor.
_MAX_TRIES = 5  # For nodes that crash again and again.
_THREAD_CRASH = "Exception in thread "  # The first words of threading.excepthook.
_FRAME = re.compile(r'  File "(.+)", line (\d+), in ')


class CrashedError(Exception):
    """The error for a node that crashed during a check; its text has the mistake and its line."""


class CheckRunner:
    """The checker's own ROS node, and what checks need: queries, logs and restarts of nodes.

    Attributes:
        node: The checker's node, which `spin_until` spins.
        logs: The messages on /rosout that the checker's node received, in their order.
        radius: The wheel_radius in m of the parameter file that all nodes were given.
        printed: The lines that the nodes print, which grow while they run.
    """

    def __init__(self, session: Session, radius: float, printed: Sequence[str]) -> None:
        """Create the checker's node beside the nodes of a session, and subscribe to their logs.

        Args:
            session: The session that hosts the nodes, at least one.
            radius: The wheel_radius in m of the parameter file that all nodes were given.
            printed: The lines that the nodes print, which grow while they run.
        """
        self.radius, self.printed = radius, printed
        self._host, self._clock = session.host, session.station.clock
        context = self._host.nodes[0].node.context
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

    def restart_crashed(self) -> list[HostedNode]:
        """Record the crashes of nodes, start these nodes again, and return `started_nodes`."""
        for hosted in [h for h in self._host.nodes if h.state.life == Life.CRASHED]:
            self._crashes[hosted.crash] = None
            self._host.start_node(hosted.name)
        return self.started_nodes()

    def query(self, ask: Callable[[Node], T]) -> dict[HostedNode, T]:
        """Restart crashed nodes, and return what `ask` returns for each of `started_nodes`.

        If a node crashes meanwhile, all are asked again; after five attempts the result is empty.
        """
        for _ in range(_MAX_TRIES):
            with contextlib.suppress(InvalidHandle, NodeNameNonExistentError):
                return {hosted: ask(hosted.node) for hosted in self.restart_crashed()}
        return {}

    def started_nodes(self) -> list[HostedNode]:
        """Return the nodes that run, and those that have crashed since they were started."""
        return [h for h in self._host.nodes if h.state.life in (Life.UP, Life.CRASHED)]

    def unrun_lines(self) -> list[str]:
        """Return a line for each file whose `main()` calls more for its nodes than is run here."""
        files = dict.fromkeys(hosted.file for hosted in self._host.nodes)
        return [file.not_run for file in files if file is not None and file.not_run]

    def wait_for_crashes(self) -> None:
        """Restart crashed nodes, then spin until the checker is 1.5 s old or a node crashes.

        So a timer of 1 s has fired by then. The crash is not raised: see `collect_crashes`.
        """
        nodes = self.restart_crashed()
        with contextlib.suppress(CrashedError):
            self.spin_until(lambda: False, self._began + _MIN_RUN - self.now(), nodes)

    def collect_crashes(self) -> list[str]:
        """Restart crashed nodes, and return a line for each different crash so far.

        Crashes of nodes come first, the oldest before the others, then those of threads that nodes
        have started.
        """
        self.restart_crashed()
        for number, line in enumerate(self.printed):
            if line.startswith(_THREAD_CRASH):
                self._crashes |= dict.fromkeys([*self._tracebacks(number)][:1])
        return list(self._crashes)

    def busy_line(self, nodes: Sequence[HostedNode]) -> str:
        """Return place and text of the line that a callback of some nodes executes now.

        Returns:
            `FILE:LINE, in: ...` of the first node that executes code of its file or folder; "" if
            none does.
        """
        for hosted in nodes:
            for thread in hosted.threads():
                if hosted.file is not None:
                    where, line = hosted.file.code.place(stack_of(thread))
                    if line:
                        return f"{where}{line}"
        return ""

    def find_line(self, nodes: Sequence[HostedNode], ask: Callable[[Source], int | None]) -> str:
        """Return `FILE:LINE: ` for the first node in whose file `ask` finds a line, or ""."""
        for hosted in nodes:
            line = ask(hosted.file.source) if hosted.file is not None else None
            if line is not None:
                return f"{hosted.file}:{line}: "
        return ""

    def find_text(self, text: str) -> str:
        """Return `FILE:LINE: ` of the first string literal `text` in the nodes' files, or "".

        Slashes at the ends of the text do not matter.
        """
        return self.find_line(self._host.nodes, lambda source: source.line_of_text(text))

    def find_callback(self, callback: Any) -> str:
        """Return `FILE:LINE: ` of the definition of a callback in the nodes' files, or ""."""
        code = code_of(callback)
        for hosted in self._host.nodes:
            if code and hosted.file is not None and hosted.file.code.is_own(code.co_filename):
                return f"{hosted.file.code.display_name(code.co_filename)}:{code.co_firstlineno}: "
        return ""

    def last_exception(self, since: int) -> str:
        """Return the last printed exception of the nodes' files, in one line with its place, or "".

        A traceback without a line of these files does not count. rclpy prints the traceback of an
        exception of an execute callback and goes on.

        Args:
            since: The index in `printed` with which the search begins.
        """
        return ([*self._tracebacks(since)] or [""])[-1]

    def _tracebacks(self, since: int) -> Iterator[str]:
        """Yield the error of each printed traceback with a line of the nodes' files or folders.

        Each is one line: `FILE:LINE: TypeError: ..., in: x = y + 1`.
        """
        where = text = ""
        for line in self.printed[since:]:
            frame = _FRAME.match(line)
            if frame is not None:
                for hosted in self._host.nodes:
                    if hosted.file is not None and hosted.file.code.is_own(frame[1]):
                        where = f"{hosted.file.code.display_name(frame[1])}:{frame[2]}"
                        text = linecache.getline(frame[1], int(frame[2])).strip()
            elif where and line[:1].strip():
                yield f"{where}: {WORDLESS.get(line, line)}, in: {text}"
                where = ""

    def logs_of(self, nodes: Sequence[HostedNode], since: int) -> Iterator[Log]:
        """Yield the log lines of some nodes, in the order in which they were received.

        Args:
            nodes: The nodes.
            since: The index in `logs` with which the search begins.
        """
        names = {hosted.name for hosted in nodes}
        return (log for log in self.logs[since:] if logger_node(log.name) in names)

    def spin_until(
        self, holds: Callable[[], object], seconds: float, nodes: Sequence[HostedNode] = ()
    ) -> bool:
        """Spin the checker's node until `holds()` is true.

        Args:
            holds: The condition.
            seconds: The longest wait.
            nodes: Nodes that must not crash meanwhile.

        Returns:
            True if the condition holds; False if the time was over before.

        Raises:
            CrashedError: One of the nodes crashed before the condition held.
        """
        end = self.now() + seconds
        while not holds():
            for hosted in nodes:
                if hosted.state.life == Life.CRASHED:
                    raise CrashedError(hosted.crash)
            if self.now() > end:
                return False
            self._executor.spin_once(timeout_sec=_SPIN_TIME)
        return True

    def wait_for_result(self, future: Any, nodes: Sequence[HostedNode]) -> Any:
        """Spin until a future is done, and return its result; None if ANSWER seconds pass before.

        Args:
            future: A future of the checker's node.
            nodes: Nodes that must not crash meanwhile.

        Raises:
            CrashedError: One of the nodes crashed.
            Exception: The exception that the future has.
        """
        return future.result() if self.spin_until(future.done, ANSWER, nodes) else None
