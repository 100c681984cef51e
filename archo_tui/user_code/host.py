"""The nodes of this process: ARCHO's own, each in its own thread, and the user's programs.

A node that crashes does not affect the others.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any

from rclpy.context import Context

from archo_tui.errors import in_one_line
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.user_code.node import HostedNode
from archo_tui.user_code.probe import restore
from archo_tui.user_code.program import HostedProgram
from archo_tui.user_code.programs import Programs

_STUCK = "is stuck: its callback still runs"
END_TIMEOUT = 1.5  # Seconds for all nodes when the console ends.
_LOCK_POLL = 0.05  # Seconds between two looks whether a program that waits for the lock is to end.


class Host:
    """The nodes of this process, and the user's programs.

    `states`, `names` and `unended_names` may be called on any thread. All else may block for
    JOIN_TIMEOUT and longer, so it is never called on the UI thread; one call at a time changes
    nodes.
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
        self._context = context
        self._on_event, self._on_end = on_event, on_end
        self._early_stop_request, self._on_early_stop = early_stop_request, on_early_stop
        self.operator_values: Callable[[str], Mapping[str, Any]] = lambda _: {}
        self._changing = threading.Lock()
        self.nodes: list[HostedNode] = []
        self.programs = Programs(
            make_program,
            on_event,
            self._report_gone,
            self._make_way_for_program_node,
            lambda: bool(early_stop_request()[0]),
            gate,
            lambda name: self.operator_values(name),
            on_restored,
            on_spin,
        )

    def add(self, make: Callable[..., Any]) -> None:
        """Make a node, given the context by that name; `start` spins it."""
        with self._changing:
            self.nodes.append(HostedNode(make, self._context, self._on_crashed))

    def start(self) -> None:
        """Spin every node; a STOP that was read before is carried out first."""
        with self._changing:
            for hosted in self.nodes:
                self._restore_parameters(hosted)
                self._start(hosted)

    def states(self) -> tuple[Hosted, ...]:
        """Return the states of all nodes, programs' last; may be called on any thread."""
        return tuple(hosted.state for hosted in self.nodes) + self.programs.states()

    def names(self) -> list[str]:
        """Return the full names of all nodes, programs' included; may be called on any thread.

        Nodes that were stopped or have crashed are among them, and for a program without nodes its
        own name.
        """
        return [*(hosted.name for hosted in self.nodes), *self.programs.names()]

    def unended_names(self) -> list[str]:
        """Return the full names of the nodes, programs' included, that are up, starting or stuck.

        May be called on any thread.
        """
        ended = (Life.STOPPED, Life.CRASHED, Life.ENDED, Life.WAITING)
        return [hosted.name for hosted in self.states() if hosted.life not in ended]

    def start_node(self, name: str) -> Outcome:
        """Make a node that does not run again and spin it, or run its program again.

        If a STOP is not released, a node that serves it carries it out before it spins, and a
        program is refused, as is a node whose callback still runs.
        """
        program = self.programs.find(name, to_start=True)
        if program is not None:
            return self.programs.start(program)
        with self._changing:
            old = self._find(name)
            if old.state.life.is_running:
                return Outcome(Code.REFUSED, f"{name} is running")
            if not old.stop():  # A crashed node ends here and releases what it holds.
                return Outcome(Code.REFUSED, f"{name} {_STUCK}")
            return self._make_and_spin(old.make_again, f"{name} started", instead_of=old)

    def stop_node(self, name: str) -> Outcome:
        """Stop a node, or end its program as Ctrl-C does; other nodes are not affected."""
        program = self.programs.find(name)
        if program is not None:
            return self.programs.stop(program)
        with self._changing:
            hosted = self._find(name)
            if not hosted.stop():
                return Outcome(Code.TIMEOUT, f"{name} does not stop: its callback does not return")
            self._report_ended(hosted)
            holds = self._early_stop_request()[0] in hosted.state.serves
            held = "; it held the STOP, and is told of it again before it starts" if holds else ""
            return Outcome(Code.DONE, f"{name} stopped{held}")

    def copy_node(self, name: str) -> Outcome:
        """Run a node or its program once more, under the next name free here: `dashboard_2`.

        If a STOP is not released, a copy of a node that serves it carries it out before it spins,
        and a program is refused.
        """
        program = self.programs.find(name)
        if program is not None:
            return self.programs.copy(program)
        with self._changing:
            kind = self._find(name).make
            first = next(hosted for hosted in self.nodes if hosted.make is kind)
            taken = self.names()
            number = next(n for n in count(2) if f"{first.name}_{n}" not in taken)
            short = f"{first.name.rpartition('/')[2]}_{number}"
            return self._make_and_spin(
                lambda: HostedNode(kind, self._context, self._on_crashed, short), f"{short} started"
            )

    def _start(self, new: HostedNode) -> Outcome:
        """Spin a new node, which first carries out a STOP that is not released, if it serves it.

        The node spins even if it does not confirm the STOP, which becomes an error event.
        """
        outcome = self._carry_out_stop(new)
        new.start()
        return outcome

    def _carry_out_stop(self, new: HostedNode) -> Outcome:
        service, request = self._early_stop_request()
        if not service or not new.serves(service):
            return Outcome(Code.DONE, "")
        refusal = new.carry_out_stop(service, request)
        if refusal:
            why = f"the STOP is not confirmed by it ({refusal}): use the hardware stop"
            self._on_event("ERROR", new.name.lstrip("/"), why)
            return Outcome(Code.NOT_CONFIRMED, f"; {why}")
        self._on_early_stop(new.name)
        return Outcome(Code.DONE, f"; {new.name} was told STOP first, and is stopped")

    def _make_way_for_program_node(self, name: str, is_stopping: Callable[[], bool]) -> str:
        """Stop and remove ARCHO's own node, if any, that a node of a program replaces.

        Return why it is not replaced, or "". A stuck one is not: beside it, a STOP that the new one
        confirms would not stop it. Called on a thread of the program; does nothing once that is to
        end.
        """
        while not self._changing.acquire(timeout=_LOCK_POLL):
            if is_stopping():
                return ""
        try:
            for own in [h for h in self.nodes if h.name == name and not is_stopping()]:
                if not own.stop():
                    return f"ARCHO's own {name.lstrip('/')} {_STUCK}, so it is not replaced"
                self.nodes.remove(own)
                self._report_ended(own)
            return ""
        finally:
            self._changing.release()

    def _restore_parameters(self, hosted: HostedNode) -> None:
        """Set the operator's parameters on a new node, which does not spin yet."""
        values = self.operator_values(hosted.name)
        if not values:
            return
        self.programs.report_restored(hosted.name, *restore(hosted.node, values))

    def _make_and_spin(
        self, make: Callable[[], HostedNode], text: str, instead_of: HostedNode | None = None
    ) -> Outcome:
        """Make a node, in place of another or beside all, and spin it after a STOP."""
        try:
            new = make()
        except Exception as error:  # The constructor may raise anything.
            return Outcome(Code.REFUSED, in_one_line(error))
        kept = [hosted for hosted in self.nodes if hosted is not instead_of]
        self.nodes = sorted([*kept, new], key=lambda hosted: hosted.name)
        self._restore_parameters(new)
        outcome = self._start(new)
        return outcome._replace(text=text + outcome.text)

    def _find(self, name: str) -> HostedNode:
        return next(hosted for hosted in self.nodes if hosted.name == name)

    def stop(self) -> list[str]:
        """Ask every node and program to end, and wait END_TIMEOUT; then end programs by force.

        `on_end` is not called.
        """
        end = time.monotonic() + END_TIMEOUT
        self.programs.begin_to_end()
        # Whoever holds the lock may hang in a callback.
        is_locked = self._changing.acquire(timeout=END_TIMEOUT / 2)
        try:
            for hosted in self.nodes:
                hosted.begin_to_stop()
            stuck = [n.name for n in self.nodes if not n.stop(max(end - time.monotonic(), 0.0))]
            return stuck + self.programs.end(lambda: end - time.monotonic())
        finally:
            if is_locked:
                self._changing.release()

    def _report_ended(self, hosted: HostedNode) -> None:
        """Call `on_end` with what the node served and no other node that is UP serves."""
        others = [h for h in self.nodes if h is not hosted]
        self._report_gone(hosted.state.serves, others)

    def _report_gone(
        self, names: Sequence[str], others: Sequence[HostedNode] | None = None
    ) -> None:
        """Call `on_end` with the names that no other node or program that is UP serves."""
        nodes = [h.state for h in (self.nodes if others is None else others)]
        states = [state for state in (*nodes, *self.programs.states()) if state.life is Life.UP]
        left = {name for state in states for name in state.serves}
        self._on_end([name for name in names if name not in left])

    def _on_crashed(self, hosted: HostedNode) -> None:
        self._report_ended(hosted)
        self._on_event("ERROR", hosted.name.lstrip("/"), f"crashed: {hosted.state.error}")
