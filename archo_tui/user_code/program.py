"""A program of the user's own, which runs beside the console until its `main()` returns."""

from __future__ import annotations

import contextlib
import threading
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from signal import Signals
from typing import Any, NamedTuple

from archo_tui.base.errors import UserFileError, in_one_line
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.hosted import HostedThread
from archo_tui.user_code.interrupt import Interrupted

START_TIME = 2.0  # Seconds that the start of the next one waits for a program.
IMPORT_TIME = 10.0  # Seconds in which the text of a saved file must have called `rclpy.init`.
LEAST_RESPAWN_DELAY = 1.0  # Seconds, so that a program that fails at once is no flood.
_SAVED_BEHIND_STOP = "saved behind a STOP: release it, then s twice starts the saved text"
_POLL = 0.05  # Seconds between two looks at a program that is waited for.


class Program(NamedTuple):
    """A program to run, and how."""

    file: ProgramFile
    ros_args: tuple[str, ...] = ()  # From `--ros-args` on.
    arguments: tuple[str, ...] = ()  # The words before them.
    name: str = ""  # The full name of its node, if it is known before the program runs.
    domain_id: int | None = None  # None means that of the environment.
    respawn_delay: float | None = None  # Seconds, LEAST_RESPAWN_DELAY at least; None: runs once.
    start_delay: float = 0.0  # Seconds before the first run.
    is_copy: bool = False
    sees_ros_args: bool = False  # In `sys.argv`, as a program of a launch file.


class ProgramEnd(NamedTuple):
    """The result of a run of a program."""

    code: int  # 1 after an exception, 130 after an interruption, -N after signal N.
    error: str = ""  # In one line which begins with the file; "" for none.
    traceback: str = ""


class Callbacks(NamedTuple):
    """The functions of the console that a program calls, each in a thread of its own."""

    on_end: Callable[[HostedProgram], None]  # It has ended, and was not stopped.
    on_node: Callable[[HostedProgram, str], str]
    """It has made a node of that full name; returns why it may not, or ""."""
    may_run: Callable[[], bool]  # False while a STOP is not released.
    gate: Callable[[], Callable[[], bool]]  # Returns what is true once a STOP came after the call.
    operator_values: Callable[[str], Mapping[str, Any]]  # The parameters set on a node by hand.
    on_restored: Callable[[str, Mapping[str, Any], Mapping[str, str]], None]
    """The values that a node was given again, and why it refused others, by parameter."""
    on_event: Callable[[str, str, str], None]  # Level, source and text.
    on_spin: Callable[[HostedProgram, str, Sequence[str]], None]
    """A node spins for the first time: its full name, and the parameters that it declares."""


class HostedProgram(HostedThread):
    """The base of a program of the user's own, and the thread that runs it, again if it respawns.

    On the embedded engine it is a `ProgramThread` of this process, on ROS 2 a `ProgramChild`.
    """

    def __init__(self, program: Program, callbacks: Callbacks, is_held: bool = False) -> None:
        """Create the hosted program; `begin` runs it."""
        self.program, self.file, self.callbacks = program, program.file, callbacks
        name, file = program.name or f"/{program.file.path.stem}", program.file
        super().__init__(Hosted(name, Life.STARTING, file=file.path.name, saved=file.saved))
        self.crash = ""  # The error of the last run that ended by itself.
        self.has_name = False  # True once a node of it was accepted, in this run or before.
        self.was_refused = False  # This run ended where it would make a node behind a STOP.
        self.blocker = ""  # Why this run ended at a node that it would make, if not for a STOP.
        self.has_begun = threading.Event()  # Set once this run has called `rclpy.init`.
        self._goes_on = threading.Event()  # Not set while it is held at `rclpy.init`.
        if not is_held:
            self._goes_on.set()
        self._has_node = self.has_spun = False  # In this run; each class, if it has no main().
        self._is_gate_shut: Callable[[], bool] = lambda: False  # Of this run.

    def current_states(self) -> tuple[Hosted, ...]:
        """Return a state for each node of the program, or one state if it has none.

        One whose constructor has not returned is STARTING, with the line where it is.
        """
        if self.state.life is not Life.UP:
            return super().current_states()
        self.served = self.serves_now()
        states, where = super().current_states(), self.constructor_line()
        if not where:
            return states
        line, _, text = self.file.without_name(where).partition(": ")
        error = f"{line}, in: {text.partition(', in: ')[2]}"
        return tuple(state._replace(life=Life.STARTING, error=error) for state in states)

    def begin(self) -> None:
        """Start the thread that runs the compiled file; call this once only."""
        self.state = self.state._replace(saved=self.file.saved)
        self._is_gate_shut = self.callbacks.gate()
        super().begin()

    def wait(self) -> None:
        """Wait until the program waits for others or has ended, START_TIME at most."""
        end = time.monotonic() + START_TIME
        while not (self.is_over or time.monotonic() > end or self.is_at_rest()):
            time.sleep(_POLL)

    def wait_for_init(self) -> bool:
        """Wait until the program calls `rclpy.init`, at most IMPORT_TIME; False if it crashed."""
        end = time.monotonic() + IMPORT_TIME
        while not (self.is_over or time.monotonic() > end):
            if self.has_begun.wait(_POLL):
                break
        return self.state.life is not Life.CRASHED

    def go_on(self) -> None:
        """Let a program that is held go on."""
        self._goes_on.set()

    def wait_for_release(self) -> None:
        """Say in `state` that a STOP is not released: it waits, or runs on with its old text."""
        if self.is_over:
            self.state = self.state._replace(life=Life.WAITING, error="", traceback="")
        else:
            self.state = self.state._replace(error=_SAVED_BEHIND_STOP, traceback="")

    def report_not_restarted(self, error: UserFileError) -> None:
        """Put the error of the saved text into `state`; the program runs on with the old text."""
        text = self.file.without_name(str(error))
        self.state = self.state._replace(error=text, traceback=error.report)

    def _run(self) -> None:
        """Run the program until it has ended, and again if it respawns and no STOP holds."""
        with contextlib.suppress(Interrupted, KeyboardInterrupt):  # Too late for the program.
            if self.program.start_delay > 0 and not self._may_run_after(self.program.start_delay):
                return
            while not self._stopping.is_set():
                self.state = self.state._replace(life=Life.UP, error="", traceback="")
                self._has_node = self.has_spun = self.was_refused = False
                self.blocker = ""
                try:
                    end = self.run_once()
                except Exception as error:  # As when no process or descriptor is free.
                    end = ProgramEnd(1, f"{self.file}: {in_one_line(error)}")
                self.record_end(end)
                delay = self.program.respawn_delay
                if delay is None or self.was_refused:
                    return
                if not self._may_run_after(max(delay, LEAST_RESPAWN_DELAY)):
                    return
                self._is_gate_shut = self.callbacks.gate()

    def _may_run_after(self, delay: float) -> bool:
        """Wait `delay` seconds; return False if the program is to end, or to wait for a release."""
        if self._stopping.wait(delay):
            return False
        if self.callbacks.may_run():
            return True
        self.was_refused = True
        self.record_end(ProgramEnd(0))
        return False

    def record_end(self, end: ProgramEnd) -> None:
        """Set `state` and `crash` from a run's result; call `on_end` unless it was stopped."""
        done = self.state._replace(error="", traceback="")
        if self._stopping.is_set():
            self.state = done._replace(life=Life.STOPPED)
            return
        if self.was_refused:
            self.state = done._replace(life=Life.WAITING)
        elif end.code == 0 and not self.blocker:
            self.state = done._replace(life=Life.ENDED)
        else:
            by = f"ended by {_signal_name(-end.code)}" if end.code < 0 else ""
            error = self.blocker or by or end.error or f"exit code {end.code}"
            self.crash = error if error == end.error else f"{self.file}: {error}"
            error = self.file.without_name(self.crash)
            self.state = done._replace(life=Life.CRASHED, error=error, traceback=end.traceback)
        self.callbacks.on_end(self)

    def begin_context(self) -> bool:
        """Note a call of `rclpy.init`, and wait while held; False if the program must end."""
        self.has_begun.set()
        while not self._goes_on.wait(_POLL):
            if self._stopping.is_set():
                return False
        return True

    def accept_node(self, name: str) -> bool:
        """Record a node that the program has made, and decide whether the program may go on.

        A STOP that was sent since the program was started has not reached its nodes, also if it is
        released by now. So the program must end when its first node is made; before that it moves
        nothing. The name of its first node ever becomes that of the program and its thread.
        """
        if self._is_behind_stop():
            self.was_refused = True
            return False
        self.blocker = self.callbacks.on_node(self, name)
        if self.blocker or self.is_stopping:
            return False
        if not self.has_name:
            self.has_name = True
            self.state = self.state._replace(name=name)
            self._thread.name = name  # By which its output is known.
        # The robot's own node may have held it, and be gone.
        if self._is_behind_stop():
            self.was_refused = True
            return False
        self._has_node = True
        return True

    def take_report(self, report: Mapping[str, Any]) -> None:
        """Take a report of the program's `SpinWatch`."""
        if "spins" in report:
            self.has_spun |= report["all_spin"]  # That of another thread may be later.
            self.callbacks.on_spin(self, *report["spins"])
        elif "restored" in report:
            self.callbacks.on_restored(*report["restored"])
        else:
            name, text = report["warning"]
            self.callbacks.on_event("WARN", name.lstrip("/"), text)

    def _is_behind_stop(self) -> bool:
        """Return True if the first node may not be made: a STOP holds, or came and was released."""
        return not self._has_node and (self._is_gate_shut() or not self.callbacks.may_run())

    @abstractmethod
    def run_once(self) -> ProgramEnd:
        """Run the program until it has ended, in the calling thread, and return the result."""

    @abstractmethod
    def serves_now(self) -> tuple[str, ...]:
        """Return the full names of the services and actions that its nodes are known to serve."""

    @abstractmethod
    def is_at_rest(self) -> bool:
        """Return True if the program waits for other nodes or messages.

        A `ProgramChild`, into which the console cannot look, is at rest once it has made a node.
        """

    @abstractmethod
    def ask(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer of the program's `Probe`; {} if there is none in time."""

    def constructor_line(self) -> str:
        """Return the line of `Probe` about a node's constructor that has not returned, or ""."""
        return ""


def with_ros_args(args: Sequence[str], program: Program) -> list[str]:
    """Return what `rclpy.init` is given, with the ROS arguments of the program if it has none."""
    return [*args] if "--ros-args" in args else [*args, *program.ros_args]


def _signal_name(number: int) -> str:
    return {int(known): known.name for known in Signals}.get(number, f"signal {number}")


def exit_code(error: SystemExit) -> tuple[int, str]:
    """Return the exit code that Python makes of a SystemExit, and the text that it prints or ""."""
    if error.code is None:
        return 0, ""
    if isinstance(error.code, int):
        return error.code & 0xFF, ""
    return 1, str(error.code)
