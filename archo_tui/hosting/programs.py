"""The user's programs that run beside the console: `--run FILE`, and those of a launch file."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from archo_tui.errors import UserFileError
from archo_tui.hosting.hosted_program import KILL_TIMEOUT, HostedProgram, Program
from archo_tui.hosting.program_file import ProgramFile
from archo_tui.hosting.user_file import NodeFileError
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Hosted, Life

_BEHIND_STOP = "is not started behind a STOP that is not released: release it first"


class Programs:
    """The user's programs of this console, each of which can be ended and run again.

    `states` and `names` may be called on any thread. All else may block for seconds, so it is never
    called on the UI thread.
    """

    def __init__(
        self,
        make: Callable[..., HostedProgram],
        on_event: Callable[[str, str, str], None],
        on_gone: Callable[[Sequence[str]], None],
        on_node: Callable[[str, Callable[[], bool]], None],
        has_stop: Callable[[], bool],
        operator_values: Callable[[str], Mapping[str, Any]],
    ) -> None:
        """Create the collection without programs.

        Args:
            make: Makes a hosted program, which is not begun yet.
            on_event: Called with level, source and text of an event, on any thread.
            on_gone: Called with the services and actions that a program that ended, was stopped or
                is restarted has served; on any thread.
            on_node: Called with the full name of each node that a program makes, and with a
                function that returns True if the program is to end; on any thread.
            has_stop: Returns True while a STOP is not released.
            operator_values: Returns the parameters that the operator has set on a node, by its full
                name.
        """
        self._make, self._on_event, self._on_gone = make, on_event, on_gone
        self._on_node, self._has_stop = on_node, has_stop
        self._operator_values = operator_values
        self._changing = threading.Lock()
        self._hosted: list[HostedProgram] = []
        self._is_over = False  # Set when the console ends: nothing is begun any more.

    def add(self, program: Program) -> None:
        """Add a program, run it, and wait until it is at rest or over, at most CONSTRUCTION_TIME.

        Raises:
            NodeFileError: Its text cannot be read or is not Python. The program is not added.
        """
        program.file.compile()
        hosted = self._new(program)
        with self._changing:
            self._hosted.append(hosted)
            hosted.begin()
        hosted.wait()

    def add_failed(self, program: Program, error: UserFileError) -> None:
        """Add a program whose text does not compile: it has crashed, which an event says."""
        hosted = self._new(program)
        hosted.record_failure(error)
        self._hosted.append(hosted)
        self._ended(hosted)

    @property
    def all_have_crashed(self) -> bool:
        """True if there are programs, and each crashed without a node and is not respawned."""
        return bool(self._hosted) and all(h.has_failed_for_good for h in self._hosted)

    def _new(self, program: Program) -> HostedProgram:
        return self._make(program, self._ended, self._node_made, lambda: not self._has_stop())

    def _node_made(self, hosted: HostedProgram, name: str) -> None:
        self._on_node(name, lambda: hosted.is_stopping)

    def _ended(self, hosted: HostedProgram) -> None:
        state = hosted.state
        self._on_gone(hosted.served)
        file = hosted.file.path.name
        if hosted.was_refused:
            self._on_event("WARN", state.name.lstrip("/"), f"{file} {_BEHIND_STOP}")
        elif state.life is Life.CRASHED:
            self._on_event("ERROR", state.name.lstrip("/"), f"crashed: {state.error}")
        else:
            self._on_event("INFO", state.name.lstrip("/"), f"{file} has ended")

    def states(self) -> tuple[Hosted, ...]:
        """Return the state of each node of each program; one state for a program without nodes."""
        return tuple(state for hosted in list(self._hosted) for state in hosted.current_states())

    def names(self) -> list[str]:
        """Return the full names of all nodes; for a program without nodes, its own name."""
        return [name for hosted in list(self._hosted) for name in hosted.names]

    def find(self, name: str) -> HostedProgram | None:
        """Return the program with that full name among its `names`, or None."""
        return next((h for h in list(self._hosted) if name in h.names), None)

    def start(self, hosted: HostedProgram) -> Outcome:
        """Run a stopped, ended, crashed or stuck program again, with its file's text as it is now.

        A stuck run is ended by force once more, and left aside if it still runs.

        Returns:
            The outcome, as soon as the program has begun; REFUSED if the program runs, a STOP is
            not released, or the text of its file is not Python.
        """
        with self._changing:
            if hosted.state.life.is_running:
                return Outcome(Code.REFUSED, f"{hosted.name} is running")
            if self._has_stop():
                return Outcome(Code.REFUSED, f"{hosted.name} {_BEHIND_STOP}")
            text = f"{hosted.name} started{self._lost_parameters(hosted)}"
            if not hosted.stop():
                text += ", the one before is stuck: its code still runs"
            try:
                self._run_again(hosted)
            except NodeFileError as error:
                return Outcome(Code.REFUSED, str(error))
        return Outcome(Code.DONE, text)

    def stop(self, hosted: HostedProgram) -> Outcome:
        """End a program as Ctrl-C does, by force after JOIN_TIMEOUT; it is not respawned.

        Returns:
            DONE, after a call of `on_gone`, also if the program had ended before; TIMEOUT if the
            program does not end: it is stuck then.
        """
        with self._changing:
            name = hosted.name
            if not hosted.stop():
                return Outcome(Code.TIMEOUT, f"{name} does not stop: its code does not return")
            self._on_gone(hosted.served)
        return Outcome(Code.DONE, f"{name} stopped")

    def reload(self, file: ProgramFile) -> None:
        """Restart the running and crashed programs of a saved file with its new text.

        If a STOP is not released, or the text is not Python, they are not restarted; an error of
        the text is put into their state. A program that has ended or was stopped is not started. An
        event tells what was done, or why nothing was, once the programs are at rest.
        """
        begun: list[tuple[str, HostedProgram]] = []
        lost = ""
        with self._changing:
            ours = [h for h in self._hosted if h.file is file]
            olds = [h for h in ours if h.state.life in (Life.UP, Life.STARTING, Life.CRASHED)]
            name = file.path.name
            try:
                file.compile()
            except NodeFileError as error:
                for hosted in olds:
                    hosted.report_not_restarted(error)
                self._on_event("ERROR", name, f"the saved text does not run: {error}")
                return
            if not olds:
                text = f"{name} was saved, and has ended: s in Nodes runs it again"
                self._on_event("INFO", name, text)
            elif self._has_stop():
                self._report_not_begun(name)
            else:
                lost = "".join(map(self._lost_parameters, olds))
                begun = self._restart(olds, name)
        for _, new in begun:
            new.wait()
        # One that was refused at its first node has said so.
        restarted = sorted(old for old, new in begun if not new.was_refused)
        if restarted:
            text = f"{name} was saved: {', '.join(restarted)} restarted{lost}"
            self._on_event("YOU", "console", text)

    def _report_not_begun(self, file: str) -> None:
        text = f"{file} was saved, and {_BEHIND_STOP}, then s in Nodes runs it anew"
        self._on_event("WARN", file, text)

    def _restart(self, olds: list[HostedProgram], file: str) -> list[tuple[str, HostedProgram]]:
        """End programs and run them again, unless a STOP came meanwhile, which an event says.

        Returns:
            The name of each program before, and its new run.
        """
        begun = []
        for old in olds:
            name = old.name
            if not old.stop():
                text = "the one before is stuck: its code still runs"
                self._on_event("WARN", name.lstrip("/"), text)
            self._on_gone(old.served)
            if self._has_stop():  # It came while the old one ended.
                self._report_not_begun(file)
            else:
                begun.append((name, self._run_again(old)))
        return begun

    def _lost_parameters(self, old: HostedProgram) -> str:
        """Return a clause that names the parameters that a restart loses; "" if it loses none."""
        names = [f"{n.lstrip('/')} {name}" for n in old.names for name in self._operator_values(n)]
        return f"; not set again: {', '.join(names)}" if names else ""

    def _run_again(self, old: HostedProgram) -> HostedProgram:
        """Compile a program's file anew and run it; return the new object in the old one's place.

        After `begin_to_end` the program is not run.

        Raises:
            NodeFileError: Its text is not Python; the old object stays.
        """
        new = self._new(old.program)
        new.file.compile()
        self._hosted[self._hosted.index(old)] = new
        if not self._is_over:
            new.begin()
        return new

    def begin_to_end(self) -> None:
        """Ask all programs to end, without waiting, and start none from now on."""
        self._is_over = True
        for hosted in self._hosted:
            hosted.begin_to_stop()

    def end(self, seconds: Callable[[], float]) -> list[str]:
        """Wait for the end of all programs; end those that still run by force, within KILL_TIMEOUT.

        Args:
            seconds: Returns the number of seconds that are left for waiting before force.

        Returns:
            The names of the programs that did not end.
        """
        for hosted in self._hosted:
            hosted.join(seconds())
        for hosted in self._hosted:
            hosted.force_end()
        end = time.monotonic() + KILL_TIMEOUT
        return [h.name for h in self._hosted if not h.stop(0.0, end - time.monotonic())]
