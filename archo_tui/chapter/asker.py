"""The checker's own node, and what it sees of the nodes that are checked."""

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

from archo_tui.hosting.host import HostedNode
from archo_tui.hosting.limited import stack_of
from archo_tui.hosting.node_files import WORDLESS, code_of
from archo_tui.hosting.source import Source
from archo_tui.robot.state import Life, logger_node
from archo_tui.session import Session

T = TypeVar("T")

ANSWER = 3.0  # s until an answer or a log line must be there
_WATCHED = 1.5  # s that every node runs at least, for a timer of one second
_SLICE = 0.05  # s of one turn of the checker's executor
_LOOKS = 5  # at nodes that crash again and again
_THREAD = "Exception in thread "  # as Python begins to say what ended one
_FRAME = re.compile(r'  File "(.+)", line (\d+), in ')


class CrashedError(Exception):
    """A node that is asked has crashed; the text is the learner's mistake, with its line."""


class Asker:
    """Asks the nodes that a session hosts. Those that crash are restarted."""

    def __init__(self, session: Session, radius: float, printed: Sequence[str]) -> None:
        """See `check`."""
        self.radius, self.printed = radius, printed
        self._host, self._clock = session.host, session.station.clock
        context = self._host.nodes[0].node.context
        self.node = Node("_archo_check", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._began = self.now()
        self._crashes: dict[str, None] = {}  # in the order in which they came
        self.logs: list[Log] = []
        self.node.create_subscription(Log, "/rosout", self.logs.append, 100)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown(0)
        self.node.destroy_node()

    def now(self) -> float:
        """Monotonic s."""
        return self._clock.monotonic()

    # the nodes

    def nodes(self) -> list[HostedNode]:
        """Those that run; what has crashed is started again first."""
        for hosted in [h for h in self._host.nodes if h.state.life == Life.CRASHED]:
            self._crashes[hosted.crash] = None
            self._host.start_node(hosted.name)
        return self.running()

    def look(self, ask: Callable[[Node], T]) -> dict[HostedNode, T]:
        """What each node says of itself; one that crashes in this moment is asked again."""
        for _ in range(_LOOKS):
            with contextlib.suppress(InvalidHandle, NodeNameNonExistentError):
                return {hosted: ask(hosted.node) for hosted in self.nodes()}
        return {}

    def running(self) -> list[HostedNode]:
        """Those that run, or have crashed since `nodes()`."""
        return [h for h in self._host.nodes if h.state.life in (Life.UP, Life.CRASHED)]

    def not_run(self) -> list[str]:
        """Return a line for each file whose `main()` does more than make nodes."""
        files = dict.fromkeys(hosted.file for hosted in self._host.nodes)
        return [file.not_run for file in files if file is not None and file.not_run]

    def wait_for_crashes(self) -> None:
        """Until what runs once a second has run: until now it may not have."""
        nodes = self.nodes()
        with contextlib.suppress(CrashedError):
            self.until(lambda: False, self._began + _WATCHED - self.now(), nodes)

    def all_crashes(self) -> list[str]:
        """What every crash was, once; of threads that nodes have started, too."""
        self.nodes()
        for number, line in enumerate(self.printed):
            if line.startswith(_THREAD):
                self._crashes |= dict.fromkeys([*self._tracebacks(number)][:1])
        return list(self._crashes)

    def busy(self, nodes: Sequence[HostedNode]) -> str:
        """Where a callback of theirs is now: `FILE:LINE`, and its line. "" when all wait."""
        for hosted in nodes:
            for thread in hosted.threads():
                if hosted.file is not None:
                    where, line = hosted.file.place(stack_of(thread))
                    if line:
                        return f"{where}{line}"
        return ""

    def place(self, nodes: Sequence[HostedNode], ask: Callable[[Source], int | None]) -> str:
        """`FILE:LINE: ` of a line in their files; "" where there is none."""
        for hosted in nodes:
            line = ask(hosted.file.source) if hosted.file is not None else None
            if line is not None:
                return f"{hosted.file}:{line}: "
        return ""

    def place_of_text(self, text: str) -> str:
        """`FILE:LINE: ` of a name, or of words."""
        return self.place(self._host.nodes, lambda source: source.line_of_text(text))

    def place_of(self, callback: Any) -> str:
        """`FILE:LINE: ` of a callback."""
        code = code_of(callback)
        for hosted in self._host.nodes:
            if code and hosted.file is not None and hosted.file.is_own(code.co_filename):
                return f"{hosted.file.named(code.co_filename)}:{code.co_firstlineno}: "
        return ""

    def raised(self, since: int) -> str:
        """What an execute callback raised last since that line was printed, and where.

        rclpy prints the traceback and goes on.
        """
        return ([*self._tracebacks(since)] or [""])[-1]

    def _tracebacks(self, since: int) -> Iterator[str]:
        """Those that were printed since that line and name a line of the files."""
        where = text = ""
        for line in self.printed[since:]:
            frame = _FRAME.match(line)
            if frame is not None:
                for hosted in self._host.nodes:
                    if hosted.file is not None and hosted.file.is_own(frame[1]):
                        where = f"{hosted.file.named(frame[1])}:{frame[2]}"
                        text = linecache.getline(frame[1], int(frame[2])).strip()
            elif where and line[:1].strip():
                yield f"{where}: {WORDLESS.get(line, line)}, in: {text}"
                where = ""

    def logged(self, nodes: Sequence[HostedNode], since: int) -> Iterator[Log]:
        """What these nodes have logged since that line of the logs."""
        names = {hosted.name for hosted in nodes}
        return (log for log in self.logs[since:] if logger_node(log.name) in names)

    # waiting

    def until(
        self, holds: Callable[[], object], seconds: float, nodes: Sequence[HostedNode] = ()
    ) -> bool:
        """Spin until it holds; False when the time is over. Raises CrashedError when one does."""
        end = self.now() + seconds
        while not holds():
            for hosted in nodes:
                if hosted.state.life == Life.CRASHED:
                    raise CrashedError(hosted.crash)
            if self.now() > end:
                return False
            self._executor.spin_once(timeout_sec=_SLICE)
        return True

    def answer(self, future: Any, nodes: Sequence[HostedNode]) -> Any:
        """The result of a future, None when it does not come in time."""
        return future.result() if self.until(future.done, ANSWER, nodes) else None
