"""The host of ARCHO's own nodes and the user's programs.

One that crashes does not affect the others.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any

from rclpy.context import Context

from archo_tui.base.errors import UserFileError, in_one_line
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.ros.names import base_name
from archo_tui.user_code.errors import NodeFileError
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.hosted import KILL_TIMEOUT
from archo_tui.user_code.own_node import OwnNode
from archo_tui.user_code.probe import restore
from archo_tui.user_code.program import Callbacks, HostedProgram, Program, ProgramEnd
from archo_tui.user_code.usage import Usage

_Hosted = OwnNode | HostedProgram
_BEHIND_STOP = "is not started behind a STOP that is not released: release it first"
_MET_STOP = "is not started: a STOP came, and was released, before it had made a node"
_THEN_S = ", then s in Nodes starts it"
_THEN_S_TWICE = ", then s in Nodes, twice, starts the saved text"
_FORCED = "did not end by ctrl+c, and was ended by force"
_OWN_STUCK = "is stuck: its callback still runs"
_STUCK = "the one before is stuck: its code still runs, and no STOP reaches it"

END_TIMEOUT = 1.5  # Seconds for everything when the console ends.
WAY_TIMEOUT = 10.0  # Seconds in which a node that is replaced must end, on a busy machine, too.
_LOCK_POLL = 0.05  # Seconds between two looks whether a program that waits for the lock is to end.


class Host:
    """ARCHO's own nodes and the user's programs, each of which can be ended and run again.

    `states`, `names` and `unended_names` may be called on any thread. All else may block for
    JOIN_TIMEOUT and longer, so it is never called on the UI thread.
    """

    def __init__(
        self,
        context: Context,
        on_event: Callable[[str, str, str], None],
        on_end: Callable[[Sequence[str]], None],  # Services and actions that nobody serves now.
        early_stop_request: Callable[[], tuple[str, Mapping[str, Any]]],  # "" for no STOP.
        on_early_stop: Callable[[str], None],  # A node has confirmed it before it spins.
        gate: Callable[[], Callable[[], bool]],  # As `program.Callbacks` has it.
        on_restored: Callable[[str, Mapping[str, Any]], None],
        make_program: Callable[..., HostedProgram],
        on_spin: Callable[[HostedProgram, str, Sequence[str]], None],
    ) -> None:
        self._context, self._make = context, make_program
        self._on_event, self._on_end, self._on_restored = on_event, on_end, on_restored
        self._early_stop_request, self._on_early_stop = early_stop_request, on_early_stop
        self.operator_values: Callable[[str], Mapping[str, Any]] = lambda _: {}
        self._callbacks = Callbacks(
            on_end=self._on_program_ended,
            on_node=self._make_way,
            may_run=lambda: not self._has_stop(),
            gate=gate,
            operator_values=lambda name: self.operator_values(name),
            on_restored=self._report_restored,
            on_event=on_event,
            on_spin=on_spin,
        )
        self._changing = threading.Lock()
        self._hosted: list[_Hosted] = []
        self._replaced: set[str] = set()  # The full names of all nodes that programs have made.
        self._is_over = False  # Set when the console ends: nothing is begun any more.

    @property
    def nodes(self) -> list[OwnNode]:
        """ARCHO's own nodes."""
        return [hosted for hosted in list(self._hosted) if isinstance(hosted, OwnNode)]

    @property
    def programs(self) -> list[HostedProgram]:
        """The user's programs."""
        return [hosted for hosted in list(self._hosted) if isinstance(hosted, HostedProgram)]

    def states(self) -> tuple[Hosted, ...]:
        """Return the state of each node; one state for a program without nodes; programs' last."""
        return tuple(
            state for hosted in (*self.nodes, *self.programs) for state in hosted.current_states()
        )

    def names(self) -> list[str]:
        """Return the full names of all nodes; for a program without nodes, its own name.

        Nodes that were stopped or have crashed are among them.
        """
        return [name for hosted in list(self._hosted) for name in hosted.names]

    def unended_names(self) -> list[str]:
        """Return the full names of the nodes and programs that are up, starting or stuck."""
        ended = (Life.STOPPED, Life.CRASHED, Life.ENDED, Life.WAITING)
        return [hosted.name for hosted in self.states() if hosted.life not in ended]

    def find(self, name: str, *, to_start: bool = False) -> _Hosted | None:
        """Return what has that full name among its `names`, or None.

        Of several, one that does not run comes first if it is `to_start`, else last.
        """
        hosts: list[_Hosted] = [*self.programs, *self.nodes]
        found = [hosted for hosted in hosts if name in hosted.names]
        found.sort(key=lambda hosted: hosted.state.life.is_running is to_start)
        return found[0] if found else None

    def usage(self, name: str) -> Usage | None:
        """Return what a node or its program has taken; None for one that does not run here."""
        found = self.find(name)
        return None if found is None else found.usage()

    def _found(self, name: str, *, to_start: bool = False) -> _Hosted:
        found = self.find(name, to_start=to_start)
        assert found is not None
        return found

    def _has_stop(self) -> bool:
        return bool(self._early_stop_request()[0])

    def add(self, make: Callable[..., Any]) -> None:
        """Make a node of ARCHO's own, given the context by that name; `start` spins it.

        If a program has made a node of that name meanwhile, there is none of ARCHO's own.
        """
        with self._changing:
            own = OwnNode(make, self._context, self._on_crashed)
            if own.name in self._replaced:
                own.stop()
            else:
                self._hosted.append(own)

    def start(self) -> None:
        """Spin ARCHO's own nodes; a STOP that was read before is carried out first."""
        with self._changing:
            for hosted in self.nodes:
                self._begin(hosted)

    def add_program(self, program: Program, *, may_fail: bool = False) -> None:
        """Add a program, run it, and wait until it waits for others or is over, START_TIME at most.

        Behind a STOP it is added, and not run. If its text does not compile, raise UserFileError,
        or add it as crashed if it `may_fail`.
        """
        hosted = self._make(program, self._callbacks)
        try:
            program.file.compile()
        except UserFileError as error:
            if not may_fail:
                raise
            self._hosted.append(hosted)
            hosted.record_end(ProgramEnd(1, str(error), error.report))
            return
        with self._changing:
            self._hosted.append(hosted)
            self._begin(hosted)
        hosted.wait()
        late = hosted.constructor_line()
        if late:
            self._on_event("INFO", hosted.name.lstrip("/"), late)

    @property
    def all_have_crashed(self) -> bool:
        """True if there are programs, and each crashed without a node and is not respawned."""
        return bool(self.programs) and all(
            h.state.life is Life.CRASHED and h.program.respawn_delay is None and not h.has_name
            for h in self.programs
        )

    def _on_program_ended(self, hosted: HostedProgram) -> None:
        if hosted not in self._hosted:  # A new text that failed before the old one made way.
            return
        self._report_gone(hosted.served)
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

    def _report_restored(
        self, name: str, values: Mapping[str, Any], refused: Mapping[str, str]
    ) -> None:
        """Report the parameters that a node was given again, and why it refused others."""
        for parameter, reason in refused.items():
            text = f"{parameter} was not set again: {reason}"  # The value may be a secret.
            self._on_event("WARN", name.lstrip("/"), text)
        if values:
            self._on_restored(name, values)

    def _begin(self, hosted: _Hosted) -> Outcome:
        """Run a program, unless a STOP is not released or the console ends; or spin a node.

        A node gets the operator's parameters and carries out a STOP before. It spins even if it
        does not confirm the STOP, which the outcome and an error event say.
        """
        outcome = Outcome(Code.DONE, "")
        if self._is_over:
            return outcome
        if isinstance(hosted, OwnNode):
            if values := self.operator_values(hosted.name):
                self._report_restored(hosted.name, *restore(hosted.node, values))
            outcome = self._carry_out_stop(hosted)
        elif self._has_stop():
            hosted.wait_for_release()
            self._say_not_begun(hosted)
            return outcome
        hosted.begin()
        return outcome

    def _carry_out_stop(self, hosted: OwnNode) -> Outcome:
        service, request = self._early_stop_request()
        if not service or not hosted.serves(service):
            return Outcome(Code.DONE, "")
        refusal = hosted.carry_out_stop(service, request)
        if refusal:
            why = f"the STOP is not confirmed by it ({refusal}): use the hardware stop"
            self._on_event("ERROR", hosted.name.lstrip("/"), why)
            return Outcome(Code.NOT_CONFIRMED, f"; {why}")
        self._on_early_stop(hosted.name)
        return Outcome(Code.DONE, f"; {hosted.name} was told STOP first, and is stopped")

    def start_node(self, name: str) -> Outcome:
        """Start what does not run of that name again: see `start_again`."""
        return self.start_again(self._found(name, to_start=True))

    def start_again(self, hosted: _Hosted) -> Outcome:
        """Make a node that does not run again and spin it, or run a program's text as it is now.

        If a STOP is not released, a node that serves it carries it out before it spins, and a
        program is refused. A stuck node is refused; of a program, what still runs is left aside.
        """
        with self._changing:
            name = hosted.name
            if hosted.state.life.is_running:
                is_starting = hosted.current_states()[0].life is Life.STARTING
                does = "starting" if is_starting else "running"
                return Outcome(Code.REFUSED, f"{name} is {does}")
            if isinstance(hosted, HostedProgram) and self._has_stop():
                return Outcome(Code.REFUSED, f"{name} {_BEHIND_STOP}")
            text = f"{name} started"
            if not hosted.stop():
                if isinstance(hosted, OwnNode):
                    return Outcome(Code.REFUSED, f"{name} {_OWN_STUCK}")
                text += f", {_STUCK}"
            try:
                new = self._successor(hosted)
            except Exception as error:  # The constructor may raise anything.
                return Outcome(Code.REFUSED, in_one_line(error))
            self._hosted[self._hosted.index(hosted)] = new
            outcome = self._begin(new)
        return outcome._replace(text=text + outcome.text)

    def _successor(self, old: _Hosted) -> _Hosted:
        if isinstance(old, OwnNode):
            return old.make_again()
        old.file.compile()
        return self._program_again(old)

    def _program_again(self, old: HostedProgram, *, is_held: bool = False) -> HostedProgram:
        new = self._make(old.program._replace(start_delay=0.0), self._callbacks, is_held)
        new.state = new.state._replace(name=old.state.name)
        return new

    def stop_node(self, name: str) -> Outcome:
        """Stop a node, or end its program as Ctrl-C does, by force after JOIN_TIMEOUT.

        Other nodes are not affected, and the program is not respawned.
        """
        with self._changing:
            hosted = self._found(name)
            name = hosted.name
            if not hosted.stop():
                return Outcome(Code.TIMEOUT, f"{name} does not stop: its code does not return")
            self._report_gone(hosted.served)
            text = f"{name} stopped"
            if isinstance(hosted, OwnNode) and self._early_stop_request()[0] in hosted.served:
                text += "; it held the STOP, and is told of it again before it starts"
            return Outcome(Code.DONE, text)

    def copy_node(self, name: str) -> Outcome:
        """Run a node or its program once more, under the next names free here: `dashboard_2`.

        If a STOP is not released, a copy of a node that serves it carries it out before it spins,
        and a program is refused.
        """
        with self._changing:
            hosted = self._found(name)
            if isinstance(hosted, HostedProgram):
                if not (hosted.has_name or hosted.program.is_copy):
                    return Outcome(Code.REFUSED, f"{hosted.name} has made no node to copy")
                if self._has_stop():
                    return Outcome(Code.REFUSED, f"a copy of {hosted.name} {_BEHIND_STOP}")
            try:
                new = self._copy(hosted)
            except Exception as error:  # The constructor may raise anything.
                return Outcome(Code.REFUSED, in_one_line(error))
            self._hosted.append(new)
            outcome = self._begin(new)
        return outcome._replace(text=f"{new.name} started{outcome.text}")

    def _copy(self, hosted: _Hosted) -> _Hosted:
        if isinstance(hosted, OwnNode):
            own = next(node for node in self.nodes if node.make is hosted.make)
            return own.make_again(f"{base_name(own.name)}_{self._free_number(own.names)}")
        of_file = [program for program in self.programs if program.file is hosted.file]
        base = next(h for h in of_file if not h.program.is_copy)
        number = self._free_number(base.names)
        rules: list[str] = []
        for name in base.names:
            # A launch file may have renamed its node already.
            node = "" if base.program.name else f"{base_name(name)}:"
            rules += ["-r", f"{node}__node:={base_name(name)}_{number}"]
        first, *others = base.program.ros_args or ("--ros-args",)
        ros_args, name = (first, *rules, *others), f"{base.names[0]}_{number}"
        program = base.program._replace(ros_args=ros_args, name=name, is_copy=True)
        return self._make(program, self._callbacks)

    def _free_number(self, names: Sequence[str]) -> int:
        """Return the first number from 2 on that no node here has behind one of the names."""
        taken = {*self.names()}
        return next(n for n in count(2) if not {f"{name}_{n}" for name in names} & taken)

    def _make_way(self, program: HostedProgram, name: str) -> str:
        """Stop and remove ARCHO's own node, if any, that a node of a program replaces.

        Return why it is not replaced, or "". A stuck one is not: beside it, a STOP that the new one
        confirms would not stop it. Called on a thread of the program; does nothing once that is to
        end.
        """
        while not self._changing.acquire(timeout=_LOCK_POLL):
            if program.is_stopping:
                return ""
        try:
            self._replaced.add(name)
            for own in [own for own in self.nodes if own.name == name and not program.is_stopping]:
                if not own.stop(WAY_TIMEOUT):
                    return f"ARCHO's own {name.lstrip('/')} {_OWN_STUCK}, so it is not replaced"
                self._hosted.remove(own)
                self._report_gone(own.served)
            return ""
        finally:
            self._changing.release()

    def reload(self, file: ProgramFile) -> None:
        """Restart the running and crashed programs of a saved file with its new text.

        The new text runs up to its `rclpy.init` beside the old one. If it is not Python, or fails
        until then, or a STOP is not released, the old one runs on. A program that has ended or was
        stopped is not started. An event tells what was done, or why nothing was.
        """
        with self._changing:
            running = (Life.UP, Life.STARTING, Life.CRASHED)
            of_file = [hosted for hosted in self.programs if hosted.file is file]
            olds = [hosted for hosted in of_file if hosted.state.life in running]
            name = file.path.name
            try:
                file.compile()
            except NodeFileError as error:
                self._say_not_restarted(olds, name, error)
                return
            if not olds:
                lives = {hosted.state.life for hosted in of_file}
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
            self._wait_for_release(old)
            return None
        new = self._program_again(old, is_held=True)
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
            self._wait_for_release(old)
            return None
        name = old.name.lstrip("/")
        if not old.stop():
            self._on_event("ERROR", name, _STUCK)
        elif old.was_forced:
            self._on_event("WARN", name, _FORCED)
        self._report_gone(old.served)
        self._hosted[self._hosted.index(old)] = new
        if self._has_stop():  # It came while the old one ended.
            new.stop()
            self._wait_for_release(new)
            return None
        new.go_on()
        return new

    def _wait_for_release(self, hosted: HostedProgram) -> None:
        hosted.wait_for_release()
        self._say_not_begun(hosted, was_saved=True)

    def stop(self) -> list[str]:
        """Ask everything to end, and wait END_TIMEOUT; then end programs by force.

        `on_end` is not called. Return the names of what did not end.
        """
        end = time.monotonic() + END_TIMEOUT
        self._is_over = True
        for hosted in list(self._hosted):
            hosted.begin_to_stop()
        # Whoever holds the lock may hang in a callback.
        is_locked = self._changing.acquire(timeout=END_TIMEOUT / 2)
        try:
            hosts = list(self._hosted)
            for hosted in hosts:
                hosted.begin_to_stop()
                hosted.join(end - time.monotonic())
            for hosted in hosts:
                hosted.force_end()
            end = time.monotonic() + KILL_TIMEOUT
            return [h.name for h in hosts if not h.stop(0.0, end - time.monotonic())]
        finally:
            if is_locked:
                self._changing.release()

    def _report_gone(self, names: Sequence[str]) -> None:
        """Call `on_end` with the names that no other node or program that is UP serves."""
        left = {name for state in self.states() if state.life is Life.UP for name in state.serves}
        self._on_end([name for name in names if name not in left])

    def _on_crashed(self, hosted: OwnNode) -> None:
        self._report_gone(hosted.served)
        self._on_event("ERROR", hosted.name.lstrip("/"), f"crashed: {hosted.state.error}")
