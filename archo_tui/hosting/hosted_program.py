"""A program of the user's own, which runs beside the console until its `main()` returns."""

from __future__ import annotations

import contextlib
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

from archo_tui.errors import UserFileError
from archo_tui.hosting.hosted_node import CONSTRUCTION_TIME, CONSTRUCTOR_POLL, without_file_name
from archo_tui.hosting.program_file import ProgramFile
from archo_tui.hosting.time_limit import Interrupted
from archo_tui.robot.state.snapshot import Hosted, Life

JOIN_TIMEOUT = 3.0  # Seconds that a program has to end after its SIGINT.
KILL_TIMEOUT = 0.5  # Seconds that it then takes at most.
LEAST_RESPAWN_DELAY = 1.0  # Seconds, so that a program that fails at once is no flood.


class Program(NamedTuple):
    """A program to run, and how.

    Attributes:
        file: The file of the program.
        ros_args: The words from `--ros-args` on that `rclpy.init` gets.
        arguments: The words of the command line before `ros_args`.
        name: The full name of its node, if that is known before the program runs; else "".
        domain_id: The ROS domain; None for that of the environment.
        respawn_delay: Seconds between its end and the next run, raised to LEAST_RESPAWN_DELAY if it
            is less; None to run it only once.
        start_delay: Seconds before the first run.
    """

    file: ProgramFile
    ros_args: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    name: str = ""
    domain_id: int | None = None
    respawn_delay: float | None = None
    start_delay: float = 0.0


class ProgramEnd(NamedTuple):
    """The result of a run of a program.

    Attributes:
        code: The exit code; 1 after an exception, 130 after an interruption, -N after signal N.
        error: The exception, the text of a SystemExit or the signal, in one line which begins with
            the file; "" for none.
        traceback: The traceback of the exception; "" for none.
    """

    code: int
    error: str = ""
    traceback: str = ""


class HostedProgram(ABC):
    """The base of a program of the user's own, and the thread that runs it, again if it respawns.

    On the embedded engine it is a `ProgramThread` of this process, on ROS 2 a `ProgramChild`.

    Attributes:
        program: The program to run.
        file: The file of the program.
        state: The state of the program; `current_states` has one for each of its nodes.
        crash: The `ProgramEnd.error` of the last run that ended by itself; "" before.
        has_name: True once a node of it was accepted, in this run or before.
        was_refused: True if this run was ended at its first node because a STOP was not released.
        served: The full names of the services and actions that it was last known to serve.
    """

    thread_class: type[threading.Thread] = threading.Thread  # Of the thread of the program.

    def __init__(
        self,
        program: Program,
        on_end: Callable[[HostedProgram], None],
        on_node: Callable[[HostedProgram, str], None],
        may_run: Callable[[], bool],
    ) -> None:
        """Create the hosted program; `begin` runs it.

        Args:
            program: The program to run.
            on_end: Called each time that the program has ended without being stopped, in a thread
                of the program.
            on_node: Called with this object and the full name of each node that the program makes,
                in a thread of the program; not for a node that is refused behind a STOP.
            may_run: Returns False while a STOP is not released.
        """
        self.program, self.file = program, program.file
        self._on_end, self._on_node, self._may_run = on_end, on_node, may_run
        name, file = program.name or f"/{program.file.path.stem}", program.file
        self.state = Hosted(name, Life.STARTING, file=file.path.name, saved=file.saved)
        self.crash = ""
        self.has_name = self.was_refused = False
        self._has_node = False  # In this run.
        self.served: tuple[str, ...] = ()
        self._stopping = threading.Event()
        self._thread = self.thread_class(target=self._run, name=name, daemon=True)

    @property
    def name(self) -> str:
        """The first of `names`."""
        return self.names[0]

    @property
    def names(self) -> tuple[str, ...]:
        """The full names of the program's nodes on the graph, the oldest first; never empty.

        Without a node on the graph, this is the name of the first node that the program ever made;
        before that the planned name, or `/` and the file's name without `.py`.
        """
        return self.node_names() or (self.state.name,)

    @property
    def is_stopping(self) -> bool:
        """True if the program has been asked to end."""
        return self._stopping.is_set()

    def current_states(self) -> tuple[Hosted, ...]:
        """Return a state for each node of the program, or one state if it has none.

        Each state has the services and actions of the whole program. `served` is updated if the
        program is UP.
        """
        state = self.state
        if state.life is Life.UP:
            self.served = self.serves_now()
        return tuple(state._replace(name=name, serves=self.served) for name in self.names)

    def begin(self) -> None:
        """Start the thread that runs the compiled file; call this once only.

        With a start delay, the first run also waits until no STOP holds. Without one, a STOP ends
        the run at its first node, see `accept_node`.
        """
        self.state = self.state._replace(saved=self.file.saved)
        self._thread.start()

    def wait(self) -> None:
        """Wait until the program `is_at_rest` or has ended, at most CONSTRUCTION_TIME."""
        end = time.monotonic() + CONSTRUCTION_TIME
        while self._thread.is_alive() and time.monotonic() < end and not self.is_at_rest():
            time.sleep(CONSTRUCTOR_POLL)

    def report_not_restarted(self, error: UserFileError) -> None:
        """Put the error of the saved text into `state`; the program runs on with the old text."""
        text = without_file_name(self.file, str(error))
        self.state = self.state._replace(error=text, traceback=error.report)

    def record_failure(self, error: UserFileError) -> None:
        """Put the error of a text that does not compile into `state`: the program has crashed."""
        self.report_not_restarted(error)
        self.state = self.state._replace(life=Life.CRASHED)
        self.crash = str(error)

    @property
    def has_failed_for_good(self) -> bool:
        """True if the program has crashed without a node, and is not respawned."""
        is_over = self.state.life is Life.CRASHED and self.program.respawn_delay is None
        return is_over and not self.has_name

    def _run(self) -> None:
        """Run the program until it has ended, and again if it respawns, once no STOP holds."""
        with contextlib.suppress(Interrupted, KeyboardInterrupt):  # Too late for the program.
            self._run_and_respawn()

    def _run_and_respawn(self) -> None:
        if self.program.start_delay > 0 and not self._may_run_after(self.program.start_delay):
            return
        while not self._stopping.is_set():
            self.state = self.state._replace(life=Life.UP, error="", traceback="")
            self._has_node = self.was_refused = False
            self._record_end(self.run_once())
            delay = self.program.respawn_delay
            if delay is None or not self._may_run_after(max(delay, LEAST_RESPAWN_DELAY)):
                return

    def _may_run_after(self, delay: float) -> bool:
        """Wait `delay` seconds and until no STOP holds; return False if the program is to end."""
        if self._stopping.wait(delay):
            return False
        while not self._may_run():
            if self._stopping.wait(CONSTRUCTOR_POLL):
                return False
        return True

    def _record_end(self, end: ProgramEnd) -> None:
        """Set `state` and `crash` from a run's result; call `on_end` unless it was stopped.

        A run that was stopped, or refused because of a STOP, counts as STOPPED; exit code 0 as
        ENDED, any other as CRASHED.
        """
        name = self.state.name
        if self._stopping.is_set():
            self.state = self.state._replace(name=name, life=Life.STOPPED, error="")
            return
        if self.was_refused:
            self.state = self.state._replace(name=name, life=Life.STOPPED, error="")
            self._on_end(self)
            return
        self.crash = end.error
        error = without_file_name(self.file, end.error) or f"exit code {end.code}"
        if end.code == 0:
            self.state = self.state._replace(name=name, life=Life.ENDED, error="")
        else:
            self.state = self.state._replace(
                name=name, life=Life.CRASHED, error=error, traceback=end.traceback
            )
        self._on_end(self)

    def accept_node(self, name: str) -> bool:
        """Record a node that the program has made, and decide whether the program may go on.

        A STOP that was sent since the program was started has not reached its nodes. So the program
        must end if a STOP holds when its first node is made; before that it moves nothing. The name
        of its first node ever becomes that of the program and its thread. `on_node` is called.

        Args:
            name: The full name of the node.

        Returns:
            False if the program must end; `was_refused` is True then.
        """
        if not self._has_node and not self._may_run():
            self.was_refused = True
            return False
        if not self.has_name:
            self.has_name = True
            self.state = self.state._replace(name=name)
            self._thread.name = name  # By which its output is known.
        self._on_node(self, name)
        if not self._has_node and not self._may_run():  # The robot's own node held it, and is gone.
            self.was_refused = True
            return False
        self._has_node = True
        return True

    def begin_to_stop(self) -> None:
        """Interrupt the program, as Ctrl-C does, without waiting for its end; it is not respawned.

        A second call does nothing.
        """
        if self._stopping.is_set():
            return
        self._stopping.set()
        if self._thread.is_alive():
            self.interrupt()

    def join(self, timeout: float) -> bool:
        """Wait for the end of the program, at most `timeout` seconds.

        Returns:
            True if it has ended or was never begun.
        """
        if self._thread.ident is not None:
            self._thread.join(max(timeout, 0.0))
        return not self._thread.is_alive()

    def stop(self, timeout: float = JOIN_TIMEOUT, kill_timeout: float = KILL_TIMEOUT) -> bool:
        """Interrupt the program and wait for its end; end it by force if it takes too long.

        Its state becomes STOPPED, unless it has crashed. What it left on the graph is taken off.

        Args:
            timeout: Seconds to wait before it is ended by force.
            kill_timeout: Seconds to wait after that.

        Returns:
            False if the program did not end; it is STUCK then.
        """
        self.begin_to_stop()
        if not self.join(timeout):
            self.force_end()
            if not self.join(kill_timeout):
                self.state = self.state._replace(name=self.name, life=Life.STUCK)
                return False
        self.release()
        if self.state.life is not Life.CRASHED:
            self.state = self.state._replace(name=self.name, life=Life.STOPPED, error="")
        return True

    @abstractmethod
    def run_once(self) -> ProgramEnd:
        """Run the program until it has ended, in the calling thread, and return the result."""

    @abstractmethod
    def node_names(self) -> tuple[str, ...]:
        """Return the full names of the program's nodes on the graph, the oldest first."""

    @abstractmethod
    def serves_now(self) -> tuple[str, ...]:
        """Return the full names of the services and actions that its nodes are known to serve."""

    @abstractmethod
    def is_at_rest(self) -> bool:
        """Return True if the program has made a node and waits for other nodes or messages.

        A `ProgramChild`, into which the console cannot look, is at rest once it has made a node.
        """

    @abstractmethod
    def interrupt(self) -> None:
        """Interrupt the program as Ctrl-C does; may be called again, and on any thread."""

    @abstractmethod
    def force_end(self) -> None:
        """End the program by force if it runs, without waiting; may be called on any thread."""

    def release(self) -> None:  # noqa: B027
        """Take the nodes that an ended program has left off the graph; a child leaves none."""


def exit_code(error: SystemExit) -> tuple[int, str]:
    """Return the exit code that Python makes of a SystemExit, and the text that it prints or ""."""
    if error.code is None:
        return 0, ""
    if isinstance(error.code, int):
        return error.code, ""
    return 1, str(error.code)
