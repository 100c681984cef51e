"""The checker's own ROS node, and its view of the programs that it checks."""

from __future__ import annotations

import linecache
import re
import time
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from rcl_interfaces.msg import Log
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from archo_tui.base.clock import Clock
from archo_tui.base.nearest import nearest
from archo_tui.robot.messages.types import kinds, load_class
from archo_tui.robot.state.graph import logger_node
from archo_tui.robot.state.snapshot import Life
from archo_tui.ros.names import base_name
from archo_tui.user_code.check.tap import Failed, Skipped
from archo_tui.user_code.errors import WORDLESS
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.host import Host
from archo_tui.user_code.probe import destroy
from archo_tui.user_code.program import HostedProgram
from archo_tui.user_code.source import Source

ANSWER = 3.0  # Seconds in which an answer or a log line must arrive.
_RESTART = 10.0  # Seconds in which the nodes of a program that runs again must spin.
_POLL = 0.02  # Seconds between two looks whether they do.
_MIN_RUN = 1.5  # Seconds, so that a timer of 1 s fires once.
_SPIN_TIME = 0.05  # Seconds of one spin of the checker's executor.
_WAKE_TIME = 2.0  # Seconds in which an executor that was woken takes its turn, and a process ends.
_THREAD_CRASH = "exception in thread "  # The first words of what a thread's error prints.
_FRAME = re.compile(r'  File "(.+)", line (\d+), in ')
_MIN_SIMILARITY = 0.8  # From which a name counts as a misspelling.
# The robot's own names; none of them is a misspelling of another.
_ROBOT_NAMES = {
    *("battery_level", "battery_drain", "motor_status", "set_charging", "reset_encoder"),
    *("emergency_stop", "release_emergency_stop", "move_to_shelf"),
    *("max_speed", "wheel_radius", "low_battery_threshold", "publish_period", "shelf_count"),
}


class Kind(NamedTuple):
    """A kind of thing that a node may have by name, with the words for it."""

    key: str  # In the answer of `Probe`.
    you: str  # `you publish`
    node: str  # `no node publishes`
    noun: str


PUBLISHERS = Kind("publishers", "publish", "publishes", "topic")
SUBSCRIPTIONS = Kind("subscriptions", "subscribe to", "subscribes to", "topic")
SERVICES = Kind("services", "serve", "serves", "service")
ACTIONS = Kind("actions", "serve", "serves", "action")
PARAMETERS = Kind("parameters", "declare", "declares", "name")


class CheckedNode(NamedTuple):
    """A node of a checked program."""

    file: ProgramFile
    name: str
    has: dict[str, dict[str, Any]]  # As `Probe` describes it.


class Checker:
    """A ROS node beside the programs, with what checks need: nodes, logs and waiting."""

    def __init__(
        self,
        host: Host,
        context: Context,
        clock: Clock,
        radius: float,
        printed: Sequence[str],
    ) -> None:
        self.radius = radius  # In m, the wheel_radius that a file gives to all nodes.
        self.printed = printed  # The lines of the programs, which grow while they run.
        self._host, self.now = host, clock.monotonic
        self.node = Node("_archo_check", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._began = self.now()
        self._crashes: list[str] = []  # Of programs that were run again.
        self.levels: list[tuple[float, float]] = []  # When battery levels came, and these.
        self.logs: list[Log] = []
        self.node.create_subscription(Log, "/rosout", self.logs.append, 100)

    def close(self) -> None:
        """Destroy the checker's node."""
        self._executor.shutdown(0)
        destroy(self.node)

    def until(
        self, holds: Callable[[], object], seconds: float, nodes: Sequence[CheckedNode] = ()
    ) -> bool:
        """Spin until `holds()`; return False when time is over. Raise Failed if a node crashed."""
        end = self.now() + seconds
        while not holds():
            for hosted in self._programs_of(nodes):
                if hosted.state.life is Life.CRASHED:
                    raise Failed(hosted.crash)
            if self.now() > end:
                return False
            self._executor.spin_once(timeout_sec=_SPIN_TIME)
        return True

    def result(self, future: Any, seconds: float, nodes: Sequence[CheckedNode]) -> Any:
        """Spin until a future is done, and return its result; None if it is late."""
        if not self.until(future.done, seconds, nodes):
            for hosted in self._programs_of(nodes):  # It may raise what a callback raised.
                hosted.ask({"ask": "wake"})
            self.until(lambda: False, _WAKE_TIME, nodes)
        return future.result() if future.done() else None

    def nodes(self) -> list[CheckedNode]:
        """Run crashed programs again, and return the nodes of all."""
        self._restart_crashed()
        return [
            CheckedNode(hosted.file, has.pop("name"), has)
            for hosted in self._host.programs
            for has in self._ask_nodes(hosted)
        ]

    def _crashed(self) -> list[HostedProgram]:
        return [hosted for hosted in self._host.programs if hosted.state.life is Life.CRASHED]

    def _restart_crashed(self) -> None:
        crashed = self._crashed()
        for hosted in crashed:
            self._crashes.append(hosted.crash)
            self._host.start_again(hosted)
        if crashed:
            wait_for_spins(self._host.programs, _RESTART)

    def _ask_nodes(self, program: HostedProgram) -> list[dict[str, Any]]:
        """Return what the program's nodes have; ask again while one is just made, ANSWER seconds.

        A program that has ended has none.
        """
        answer: dict[str, Any] = {}

        def is_answered() -> bool:
            answer.update(program.ask({"ask": "nodes"}))
            return "nodes" in answer or program.is_over

        self.until(is_answered, ANSWER)
        found: list[dict[str, Any]] = answer.get("nodes", [])
        return found

    def nodes_with(self, what: Kind, wanted: str, but: str = "") -> list[CheckedNode]:
        """Return the nodes that have something of that name, but for nodes called `but`.

        Without one, raise Failed if another name was probably meant to be the wanted one, else
        Skipped. ARCHO's own names are never meant to be another.
        """
        found = [node for node in self.nodes() if base_name(node.name) != but]
        nodes = [node for node in found if wanted in node.has[what.key]]
        if nodes:
            return nodes
        short = wanted.lstrip("/")
        names = sorted({name for node in found for name in node.has[what.key]})
        others = [name for name in names if name.lstrip("/") not in _ROBOT_NAMES]
        meant = [name for name in others if _is_meant_as(name, short)]
        if not others:
            raise Skipped(f"no node {what.node} {short}")
        shown = meant or others
        where = self.line_of_text(found, shown[0])
        text = f"{where}you {what.you} {', '.join(shown)}; the chapter's {what.noun} is {short}"
        raise Failed(text) if meant else Skipped(text)

    def load_type(
        self,
        nodes: Sequence[CheckedNode],
        what: Kind,
        name: str,
        wanted: Sequence[str],
        fields: Mapping[str, Sequence[str]] = MappingProxyType({}),
    ) -> Any:
        """Return the class of what the first node has; raise Failed if it is no wanted type.

        One of the learner's own package does if it has its name, and `fields` by their part.
        """
        type_name = nodes[0].has[what.key][name]["type"]
        kind = load_class(type_name)
        is_own = bool(fields) and base_name(type_name) == base_name(wanted[0])
        parts = {part: kinds(getattr(kind, part)) for part in fields} if is_own else {}
        lacks = [field for part in parts for field in fields[part] if field not in parts[part]]
        if lacks or not (is_own or type_name in wanted):
            without = f" without {', '.join(lacks)}" if lacks else ""
            text = f"you {what.you} a {type_name}{without}; the chapter's is {wanted[0]}"
            raise Failed(f"{self.line_of_text(nodes, name)}{text}")
        return kind

    def _programs_of(self, nodes: Sequence[CheckedNode]) -> list[HostedProgram]:
        """Return the programs of some nodes, as they run now."""
        files = [node.file for node in nodes]
        return [hosted for hosted in self._host.programs if hosted.file in files]

    def set_numbers(self, node: CheckedNode, values: dict[str, Any]) -> None:
        """Set attributes of a node."""
        for hosted in self._programs_of([node]):
            hosted.ask({"ask": "set", "node": node.name, "values": values})

    def busy_line(self, nodes: Sequence[CheckedNode]) -> str:
        """Return `FILE:LINE, in: ...` of the line that a callback of some nodes executes now."""
        busy = (hosted.ask({"ask": "busy"}).get("busy", "") for hosted in self._programs_of(nodes))
        return next(filter(None, busy), "")

    def stuck(self, nodes: Sequence[CheckedNode]) -> str:
        """Return `: a callback does not return, FILE:LINE, in: ...`, or "" if none runs."""
        busy = self.busy_line(nodes)
        return f": a callback does not return, {busy}" if busy else ""

    def line(self, nodes: Sequence[CheckedNode], ask: Callable[[Source], int | None]) -> str:
        """Return `FILE:LINE: ` for the first node in whose file `ask` finds a line, or ""."""
        found = ((node.file, ask(node.file.source)) for node in nodes)
        return next((f"{file}:{line}: " for file, line in found if line is not None), "")

    def line_of_text(self, nodes: Sequence[CheckedNode], text: str) -> str:
        """Return `FILE:LINE: ` of the first string literal `text`; slashes do not matter."""
        return self.line(nodes, lambda source: source.line_of_text(text))

    def logs_of(self, nodes: Sequence[CheckedNode], since: int) -> list[Log]:
        """Return the log lines of some nodes from an index in `logs` on."""
        names = {node.name for node in nodes}
        return [log for log in self.logs[since:] if logger_node(log.name) in names]

    def last_exception(self, since: int) -> str:
        """Return the last error whose traceback was printed, as `FILE:LINE: TypeError: ...`; or "".

        rclpy prints that of an execute callback and goes on.
        """
        found = where = text = ""
        for line in self.printed[since:]:
            frame = _FRAME.match(line)
            if frame is not None:
                for hosted in self._host.programs:
                    if hosted.file.code.is_own(frame[1]):
                        where = f"{hosted.file.code.display_name(frame[1])}:{frame[2]}"
                        text = linecache.getline(frame[1], int(frame[2])).strip()
            elif where and line[:1].strip():
                found = f"{where}: {WORDLESS.get(line, line)}, in: {text}"
                where = ""
        return found

    def check_crashes(self) -> None:
        """Spin until a timer of 1 s has fired; raise Failed with a line for each different crash.

        Crashes of programs come first, the oldest before the others, then those of threads.
        """
        self._restart_crashed()
        self.until(self._crashed, self._began + _MIN_RUN - self.now())
        crashes = [*self._crashes, *(hosted.crash for hosted in self._crashed())]
        thread_crashes = [line for line in self.printed if line.startswith(_THREAD_CRASH)]
        crashes += [line.partition(": ")[2] for line in thread_crashes]
        if crashes:
            raise Failed("\n".join(dict.fromkeys(crashes)))


def wait_for_spins(programs: Sequence[HostedProgram], seconds: float) -> None:
    """Wait until the nodes of each program spin, and so are complete, or it is over."""
    end = time.monotonic() + seconds
    while any(not (p.is_over or p.has_spun) for p in programs) and time.monotonic() < end:
        time.sleep(_POLL)


def _is_meant_as(name: str, wanted: str) -> bool:
    """Return True if a name was probably meant to be the wanted one; any namespace is ignored.

    A name counts if its spelling is similar, or if it has all words of the wanted name, or only
    such words.
    """
    last = base_name(name)
    own, words = _words(last), _words(wanted)
    is_similar = bool(nearest(wanted, [last.lower()], _MIN_SIMILARITY))
    return is_similar or (bool(own) and (own <= words or words <= own))


def _words(name: str) -> set[str]:
    """Return the words of a name in snake_case or camelCase, in lower case; digits are left out."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}
