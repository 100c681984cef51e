"""The user's programs that run beside the console: `--node FILE`, and those of a launch file."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any

from archo_tui.errors import UserFileError
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.ros_names import base_name
from archo_tui.user_code.errors import NodeFileError
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.program import KILL_TIMEOUT, Callbacks, HostedProgram, Program

_BEHIND_STOP = "is not started behind a STOP that is not released: release it first"
_MET_STOP = "is not started: a STOP came, and was released, before it had made a node"
_THEN_S = ", then s in Nodes starts it"
_THEN_S_TWICE = ", then s in Nodes, twice, starts the saved text"
_FORCED = "did not end by ctrl+c, and was ended by force"
_STUCK = "the one before is stuck: its code still runs, and no STOP reaches it"


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
        on_node: Callable[[str, Callable[[], bool]], str],
        has_stop: Callable[[], bool],
        gate: Callable[[], Callable[[], bool]],
        operator_values: Callable[[str], Mapping[str, Any]],
        on_restored: Callable[[str, Mapping[str, Any]], None],
        on_spin: Callable[[HostedProgram, str, Sequence[str]], None],
    ) -> None:
        self._make, self._on_event, self._on_gone = make, on_event, on_gone
        self._has_stop, self._on_restored = has_stop, on_restored
        self._callbacks = Callbacks(
            on_end=self._ended,
            on_node=lambda hosted, name: on_node(name, lambda: hosted.is_stopping),
            may_run=lambda: not has_stop(),
            gate=gate,
            operator_values=operator_values,
            on_restored=self.report_restored,
            on_event=on_event,
            on_spin=on_spin,
        )
        self._changing = threading.Lock()
        self._hosted: list[HostedProgram] = []
        self._is_over = False  # Set when the console ends: nothing is begun any more.

    def __iter__(self) -> Any:
        return iter(list(self._hosted))

    def add(self, program: Program) -> None:
        """Add a program, run it, and wait until it waits for others or is over, START_TIME at most.

        Behind a STOP it is added, and not run.
        """
        program.file.compile()
        hosted = self._make(program, self._callbacks)
        with self._changing:
            self._hosted.append(hosted)
            if not self._begin(hosted):
                return
        hosted.wait()
        late = hosted.constructor_line()
        if late:
            self._on_event("INFO", hosted.name.lstrip("/"), late)

    def _begin(self, hosted: HostedProgram) -> bool:
        """Run a program, unless a STOP is not released or the console ends; return False then."""
        if self._is_over:
            return False
        if self._has_stop():
            hosted.wait_for_release()
            self._say_not_begun(hosted)
            return False
        hosted.begin()
        return True

    def add_failed(self, program: Program, error: UserFileError) -> None:
        """Add a program whose text does not compile: it has crashed, which an event says."""
        hosted = self._make(program, self._callbacks)
        hosted.record_failure(error)
        self._hosted.append(hosted)
        self._ended(hosted)

    @property
    def all_have_crashed(self) -> bool:
        """True if there are programs, and each crashed without a node and is not respawned."""
        return bool(self._hosted) and all(h.has_failed_for_good for h in self._hosted)

    def _ended(self, hosted: HostedProgram) -> None:
        if hosted not in self._hosted:  # A new text that failed before the old one made way.
            return
        self._on_gone(hosted.served)
        state = hosted.state
        if hosted.was_refused:
            self._say_not_begun(hosted)
        elif state.life is Life.CRASHED:
            self._on_event("ERROR", state.name.lstrip("/"), f"crashed: {state.error}")
        else:
            self._on_event("INFO", state.name.lstrip("/"), f"{hosted.file.path.name} has ended")

    def _say_not_begun(self, hosted: HostedProgram, was_saved: bool = False) -> None:
        file = hosted.file.path.name
        saved = "was saved, and " if was_saved else ""
        source = file if was_saved else hosted.state.name.lstrip("/")
        then = _THEN_S if hosted.state.life is Life.WAITING else _THEN_S_TWICE
        why = _BEHIND_STOP if self._has_stop() else _MET_STOP
        self._on_event("WARN", source, f"{file} {saved}{why}{then}")

    def report_restored(
        self, name: str, values: Mapping[str, Any], refused: Mapping[str, str]
    ) -> None:
        """Report the parameters that a node was given again, and why it refused others."""
        for parameter, reason in refused.items():
            text = f"{parameter} was not set again: {reason}"  # The value may be a secret.
            self._on_event("WARN", name.lstrip("/"), text)
        if values:
            self._on_restored(name, values)

    def states(self) -> tuple[Hosted, ...]:
        """Return the state of each node of each program; one state for a program without nodes."""
        return tuple(state for hosted in self for state in hosted.current_states())

    def names(self) -> list[str]:
        """Return the full names of all nodes; for a program without nodes, its own name."""
        return [name for hosted in self for name in hosted.names]

    def find(self, name: str, *, to_start: bool = False) -> HostedProgram | None:
        """Return the program with that full name among its `names`, or None.

        Of several, one that does not run comes first if it is `to_start`, else last.
        """
        found = [hosted for hosted in self if name in hosted.names]
        found.sort(key=lambda hosted: hosted.state.life.is_running is to_start)
        return found[0] if found else None

    def start(self, hosted: HostedProgram) -> Outcome:
        """Run a program that does not run again, with its file's text as it is now.

        A stuck run is ended by force once more, and left aside if it still runs.
        """
        with self._changing:
            if hosted.state.life.is_running:
                is_starting = hosted.current_states()[0].life is Life.STARTING
                does = "starting" if is_starting else "running"
                return Outcome(Code.REFUSED, f"{hosted.name} is {does}")
            if self._has_stop():
                return Outcome(Code.REFUSED, f"{hosted.name} {_BEHIND_STOP}")
            text = f"{hosted.name} started"
            if not hosted.stop():
                text += f", {_STUCK}"
            try:
                hosted.file.compile()
            except NodeFileError as error:
                return Outcome(Code.REFUSED, str(error))
            new = self._successor(hosted)
            self._hosted[self._hosted.index(hosted)] = new
            self._begin(new)
        return Outcome(Code.DONE, text)

    def _successor(self, old: HostedProgram, *, is_held: bool = False) -> HostedProgram:
        new = self._make(old.program._replace(start_delay=0.0), self._callbacks, is_held)
        new.state = new.state._replace(name=old.state.name)
        return new

    def stop(self, hosted: HostedProgram) -> Outcome:
        """End a program as Ctrl-C does, by force after JOIN_TIMEOUT; it is not respawned."""
        with self._changing:
            name = hosted.name
            if not hosted.stop():
                return Outcome(Code.TIMEOUT, f"{name} does not stop: its code does not return")
            self._on_gone(hosted.served)
        return Outcome(Code.DONE, f"{name} stopped")

    def copy(self, hosted: HostedProgram) -> Outcome:
        """Run the program once more, its nodes under the next names free here: `dashboard_2`."""
        with self._changing:
            if not (hosted.has_name or hosted.program.is_copy):
                return Outcome(Code.REFUSED, f"{hosted.name} has made no node to copy")
            if self._has_stop():
                return Outcome(Code.REFUSED, f"a copy of {hosted.name} {_BEHIND_STOP}")
            base = next(h for h in self._hosted if h.file is hosted.file and not h.program.is_copy)
            names, taken = base.names, {*self.names()}
            number = next(n for n in count(2) if not {f"{name}_{n}" for name in names} & taken)
            rules: list[str] = []
            for name in names:
                # A launch file may have renamed its node already.
                node = "" if base.program.name else f"{base_name(name)}:"
                rules += ["-r", f"{node}__node:={base_name(name)}_{number}"]
            first, *others = base.program.ros_args or ("--ros-args",)
            ros_args, name = (first, *rules, *others), f"{names[0]}_{number}"
            program = base.program._replace(ros_args=ros_args, name=name, is_copy=True)
            new = self._make(program, self._callbacks)
            self._hosted.append(new)
            self._begin(new)
        return Outcome(Code.DONE, f"{new.name} started")

    def reload(self, file: ProgramFile) -> None:
        """Restart the running and crashed programs of a saved file with its new text.

        The new text runs up to its `rclpy.init` beside the old one. If it is not Python, or fails
        until then, or a STOP is not released, the old one runs on. A program that has ended or was
        stopped is not started. An event tells what was done, or why nothing was.
        """
        with self._changing:
            running = (Life.UP, Life.STARTING, Life.CRASHED)
            olds = [h for h in self._hosted if h.file is file and h.state.life in running]
            name = file.path.name
            try:
                file.compile()
            except NodeFileError as error:
                self._say_not_restarted(olds, name, error)
                return
            if not olds:
                lives = {h.state.life for h in self._hosted if h.file is file}
                then = "and has ended: s in Nodes runs it again"
                if Life.WAITING in lives:
                    then = "and waits for a release: s in Nodes runs it"
                elif Life.STUCK in lives:
                    then = f"and {_STUCK}; s in Nodes runs it again"
                self._on_event("INFO", name, f"{name} was saved, {then}")
            begun = [(old.name, new) for old in olds if (new := self._replace(old)) is not None]
        for _, new in begun:
            new.wait()
        # One that was refused at its first node has said so.
        names = sorted(old for old, new in begun if not new.was_refused)
        if names:
            self._on_event("YOU", "console", f"{name} was saved: {', '.join(names)} restarted")

    def _say_not_restarted(
        self, olds: Sequence[HostedProgram], name: str, error: UserFileError
    ) -> None:
        for hosted in olds:
            hosted.report_not_restarted(error)
        self._on_event("ERROR", name, f"the saved text does not run: {error}")

    def _replace(self, old: HostedProgram) -> HostedProgram | None:
        """Run a saved text, and end the old one once it has begun; None if the old one runs on."""
        if self._has_stop() or self._is_over:
            old.wait_for_release()
            self._say_not_begun(old, was_saved=True)
            return None
        new = self._successor(old, is_held=True)
        new.begin()
        has_init = new.wait_for_init()
        if not has_init or (new.state.life is Life.ENDED and not old.is_over):
            old.file.does_not_import = True
            crash = new.crash or f"{old.file}: it ends without a node"
            error = NodeFileError(crash, new.state.traceback)
            self._say_not_restarted([old], old.file.path.name, error)
            return None
        if self._has_stop():  # It came while the new text began.
            new.stop()
            old.wait_for_release()
            self._say_not_begun(old, was_saved=True)
            return None
        name = old.name.lstrip("/")
        if not old.stop():
            self._on_event("ERROR", name, _STUCK)
        elif old.was_forced:
            self._on_event("WARN", name, _FORCED)
        self._on_gone(old.served)
        self._hosted[self._hosted.index(old)] = new
        if self._has_stop():  # It came while the old one ended.
            new.stop()
            new.wait_for_release()
            self._say_not_begun(new, was_saved=True)
            return None
        new.go_on()
        return new

    def begin_to_end(self) -> None:
        """Ask all programs to end, without waiting, and start none from now on."""
        self._is_over = True
        for hosted in self:
            hosted.begin_to_stop()

    def end(self, seconds: Callable[[], float]) -> list[str]:
        """Wait `seconds()` for all programs, then end them by force; return what did not end."""
        for hosted in self:
            hosted.join(seconds())
        for hosted in self:
            hosted.force_end()
        end = time.monotonic() + KILL_TIMEOUT
        return [h.name for h in self if not h.stop(0.0, end - time.monotonic())]
