"""The nodes of this process, each constructed and spun in its own thread.

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
from archo_tui.hosting.hosted_node import HostedNode, without_file_name
from archo_tui.hosting.hosted_program import HostedProgram
from archo_tui.hosting.node_files import NodeFile
from archo_tui.hosting.programs import Programs
from archo_tui.hosting.user_file import NodeFileError
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Hosted, Life

END_TIMEOUT = 1.5  # Seconds for all nodes when the console ends.
_LOCK_POLL = 0.05  # Seconds between two checks whether a node that waits for the lock is stopped.


class Host:
    """The nodes of this process, and the user's programs.

    `states`, `names` and `unended_names` may be called on any thread. All else may block for
    JOIN_TIMEOUT and longer, so it is never called on the UI thread; one call at a time changes
    nodes.

    Attributes:
        nodes: The nodes, with those that were stopped or have crashed; not those of programs.
        operator_values: Returns the parameters that the operator has set on a node, by its full
            name. The session sets it.
        programs: The user's programs.
    """

    def __init__(
        self,
        context: Context,
        on_event: Callable[[str, str, str], None],
        on_end: Callable[[Sequence[str]], None],
        early_stop_request: Callable[[], tuple[str, Mapping[str, Any]]] = lambda: ("", {}),
        on_early_stop: Callable[[str], None] = lambda _: None,
        on_restored: Callable[[str, Mapping[str, Any]], None] = lambda *_: None,
        make_program: Callable[..., HostedProgram] = HostedProgram,
    ) -> None:
        """Create a host without nodes.

        Args:
            context: The rclpy context of the nodes.
            on_event: Called with level, source and text of an event, on any thread.
            on_end: Called with the services and actions that no node of this process serves any
                more, perhaps none, after a node or program has ended; on any thread.
            early_stop_request: Returns the full name of the service of a STOP that is not released,
                and the values of its request; "" for the name if there is no such STOP.
            on_early_stop: Called with the name of a node that confirmed that STOP before it spins.
            on_restored: Called with the name of a node, and the parameters that were set on it
                again after it was constructed anew; on any thread.
            make_program: Makes a program, which is not begun yet.
        """
        self._context = context
        self._on_event, self._on_end = on_event, on_end
        self._early_stop_request, self._on_early_stop = early_stop_request, on_early_stop
        self._on_restored = on_restored
        self.operator_values: Callable[[str], Mapping[str, Any]] = lambda _: {}
        self._changing = threading.Lock()
        self._has_started = False
        self.nodes: list[HostedNode] = []
        self.programs = Programs(
            make_program,
            on_event,
            self._report_gone,
            self._make_way_for_program_node,
            lambda: bool(early_stop_request()[0]),
            lambda name: self.operator_values(name),
        )

    def add(self, make: Callable[..., Any]) -> None:
        """Construct a node, which `start` spins.

        A node of a file whose constructor takes long or waits for other nodes is late: it is added,
        too, an event names the line of its constructor, and it starts by itself, not before
        `start`.

        Args:
            make: Makes the node, given the context by that name.

        Raises:
            Exception: The exception that the constructor raises; the node is not added then.
        """
        with self._changing:
            hosted = self._hosted(make)
            self._wait(hosted)
            self.nodes.append(hosted)

    def _hosted(self, make: Callable[..., Any], rename: str = "") -> HostedNode:
        callbacks = self._on_crashed, self._on_event, self._on_made_late, self._carry_out_stop_early
        return HostedNode(make, self._context, *callbacks, rename)

    def _wait(self, hosted: HostedNode) -> None:
        """Wait for a node; if it is late, write an event, which is a warning if it is overdue.

        Raises:
            Exception: The exception that the constructor raises.
        """
        if not hosted.wait():
            level = "WARN" if hosted.is_overdue else "INFO"
            self._on_event(level, hosted.name.lstrip("/"), hosted.lateness_text())

    def start(self) -> None:
        """Spin every node that is made; late nodes start by themselves from now on.

        A STOP that was read before is carried out first.
        """
        with self._changing:
            self._has_started = True
            for hosted in self.nodes:
                if hosted.is_made:
                    self._restore_parameters(hosted)
                    self._start(hosted)

    def wait_longer(self, seconds: float) -> list[str]:
        """Wait for the nodes that are late.

        Args:
            seconds: The time limit for all of them together.

        Returns:
            A text for each node that is not made by then: the line at which its constructor is, or
            the error that the constructor raised.
        """
        end = time.monotonic() + seconds
        late = [hosted for hosted in self.nodes if hosted.is_late]
        waited = (hosted.wait_longer(max(end - time.monotonic(), 0.0)) for hosted in late)
        return [wrong for wrong in waited if wrong]

    def states(self) -> tuple[Hosted, ...]:
        """Return the states of all nodes, programs' last; may be called on any thread."""
        nodes = tuple(hosted.current_state() for hosted in self.nodes)
        return nodes + self.programs.states()

    def names(self) -> list[str]:
        """Return the full names of all nodes, programs' included; may be called on any thread.

        Nodes that were stopped or have crashed are among them, and for a program without nodes its
        own name.
        """
        return [*(hosted.name for hosted in self.nodes), *self.programs.names()]

    def users_names(self) -> list[str]:
        """Return the full names of the nodes of the user's files; may be called on any thread."""
        return [hosted.name for hosted in self.states() if hosted.file]

    def unended_names(self) -> list[str]:
        """Return the full names of the nodes, programs' included, that are up, starting or stuck.

        May be called on any thread.
        """
        ended = (Life.STOPPED, Life.CRASHED, Life.ENDED)
        return [hosted.name for hosted in self.states() if hosted.life not in ended]

    def start_node(self, name: str) -> Outcome:
        """Construct a stopped, crashed or stuck node again and spin it, or run its program again.

        If a STOP is not released, a node that serves it carries it out before it spins, and a
        program is refused. What still runs of a stuck node is interrupted and taken off the graph.
        The node gets the parameters that the operator has set, and the text of its file that was
        last loaded.

        Args:
            name: The fully qualified name of one of the nodes.

        Returns:
            The outcome; REFUSED if the node runs, is starting, or raises in its constructor;
            NOT_CONFIRMED if it spins now without having confirmed the STOP; otherwise DONE, also
            for a node whose constructor takes long: it starts by itself.
        """
        program = self.programs.find(name)
        if program is not None:
            return self.programs.start(program)
        with self._changing:
            named = [hosted for hosted in self.nodes if hosted.name == name]
            old = next((h for h in named if not h.state.life.is_running), named[0])
            if old.state.life.is_running:
                does = "starting" if old.state.life is Life.STARTING else "running"
                return Outcome(Code.REFUSED, f"{name} is {does}")
            text = f"{name} started"
            if not old.stop():  # It is stuck. A crashed node ends here and releases what it holds.
                text += self._abandon(old)
                self._report_ended(old)
            return self._make_and_spin(old.make_again, text, instead_of=old)

    def stop_node(self, name: str) -> Outcome:
        """Stop a node, or end its program as Ctrl-C does; other nodes are not affected.

        Args:
            name: The fully qualified name of one of the nodes.

        Returns:
            DONE, also if it had ended before, after a call of `on_end` with what no node of this
            process serves any more; TIMEOUT if a callback of the node, or the program, does not
            return: it is stuck then.
        """
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
        """Run another node of the same class, under the next name free here: `dashboard_2`.

        If a STOP is not released, a copy that serves it carries it out before it spins.

        Args:
            name: The fully qualified name of one of the nodes.

        Returns:
            REFUSED for the node of a program, or if the constructor raises or takes no name;
            otherwise DONE or NOT_CONFIRMED, as `start_node`.
        """
        if self.programs.find(name) is not None:
            return Outcome(Code.REFUSED, f"{name} is a program of its own: it is not copied")
        with self._changing:
            kind = self._find(name).make
            first = next(hosted for hosted in self.nodes if hosted.make is kind)
            taken = {hosted.name for hosted in self.nodes}
            number = next(n for n in count(2) if f"{first.name}_{n}" not in taken)
            short = f"{first.name.rpartition('/')[2]}_{number}"
            return self._make_and_spin(lambda: self._hosted(kind, short), f"{short} started")

    def reload(self, file: NodeFile) -> None:
        """Load a file as it is now, and run its nodes in place of all those it has here.

        Stopped and crashed nodes of the file are replaced, too, and copies end. If the file cannot
        be imported, the old nodes run on. If a new node cannot be constructed, the old nodes are
        constructed again. An event says what was done. If a STOP is not released, a node that
        serves it carries it out before it spins. A node of the robot's own with the name of a new
        one is stopped and removed.

        The nodes get the parameters that the operator has set.
        """
        with self._changing:
            olds = [hosted for hosted in self.nodes if hosted.file is file]
            try:
                makers = file.load()
            except NodeFileError as error:
                self._report_not_run(olds, file, error)
                return
            for old in olds:
                if not old.stop():
                    self._on_event("WARN", old.name.lstrip("/"), self._abandon(old).lstrip(", "))
                self._report_ended(old)
            failed: NodeFileError | None = None
            news: list[HostedNode] = []
            try:
                for make in makers:
                    news.append(self._hosted(make))
                    self._wait(news[-1])
            except Exception as error:  # NodeFileError, or an error of rclpy about a name.
                failed = error if isinstance(error, NodeFileError) else NodeFileError(str(error))
                for new in news:
                    new.stop()
                file.restore()
                news = self._make_all_again(olds)
            names = {new.name for new in news}
            for other in [h for h in self.nodes if h not in olds and h.name in names]:
                other.stop()  # A node of the robot's own, whose place the new one takes.
                olds.append(other)
            made = [new for new in news if not new.is_late]
            for new in made:
                self._restore_parameters(new)
            self.nodes = sorted(
                [*(hosted for hosted in self.nodes if hosted not in olds), *news],
                key=lambda hosted: hosted.name,
            )
            stopped = "".join([self._start(new).text for new in made])
        if failed is not None:
            self._report_not_run(news, file, failed)
        else:
            restarted = ", ".join(sorted(names))
            text = f"{file.path.name} was saved: {restarted} restarted{stopped}"
            self._on_event("YOU", "console", text)
            if file.not_run:
                self._on_event("WARN", file.path.name, file.not_run)

    def _start(self, new: HostedNode) -> Outcome:
        """Spin a new node, which first carries out a STOP that is not released, if it serves it.

        The node spins even if it does not confirm the STOP.

        Returns:
            The outcome of `_carry_out_stop`.
        """
        outcome = self._carry_out_stop(new)
        new.start()
        return outcome

    def _carry_out_stop(self, new: HostedNode) -> Outcome:
        """Make a new node carry out a STOP that is not released, if it serves it.

        A STOP that the node does not confirm becomes an error event; `on_early_stop` is called for
        one that it confirms.

        Returns:
            The outcome of the STOP, with a text to append to `NODE started`: DONE and "" if there
            is nothing to carry out, NOT_CONFIRMED if the node does not confirm the STOP.
        """
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

    def _carry_out_stop_early(self, new: HostedNode) -> None:
        """Make a node carry out a STOP that is not released, before its constructor spins it.

        Do nothing if a STOP already held when the constructor last spun the node: since then the
        node receives requests itself. `was_stopped_early` of the node is set for the next call.
        """
        is_told, new.was_stopped_early = new.was_stopped_early, bool(self._early_stop_request()[0])
        if not is_told:
            self._carry_out_stop(new)

    def _on_made_late(self, hosted: HostedNode) -> None:
        """Start a late node, one whose constructor has returned after `HostedNode.wait` gave up.

        The node gets the operator's parameters and replaces a node of the robot's own of the same
        name; an event says that it is made. It spins only if `start` was called. Nothing of this is
        done for a node that is being stopped. This is called on the node's thread: a caller that
        stops the node holds the lock and waits for this thread, which therefore never waits for the
        lock without checking `is_stopping`.
        """
        if not self._acquire_unless(lambda: hosted.is_stopping):
            return
        try:
            self._restore_parameters(hosted)
            self._remove_own(hosted.name)
            self._on_event("INFO", hosted.name.lstrip("/"), "its constructor has returned")
            if self._has_started:
                self._start(hosted)
        finally:
            self._changing.release()

    def _make_way_for_program_node(self, name: str, is_stopping: Callable[[], bool]) -> None:
        """Stop and remove the node of the robot's own, if any, that a node of a program replaces.

        `on_end` is called for it. Do nothing if the program is to end. This is called on a thread
        of the program.

        Args:
            name: The full name of both nodes.
            is_stopping: Returns True if the program is to end.
        """
        if self._acquire_unless(is_stopping):
            try:
                self._remove_own(name)
            finally:
                self._changing.release()

    def _acquire_unless(self, is_stopping: Callable[[], bool]) -> bool:
        """Take the lock; return False, without it, once `is_stopping` returns True."""
        while not self._changing.acquire(timeout=_LOCK_POLL):
            if is_stopping():
                return False
        if is_stopping():
            self._changing.release()
            return False
        return True

    def _remove_own(self, name: str) -> None:
        for own in [h for h in self.nodes if h.file is None and h.name == name]:
            own.stop()
            self.nodes.remove(own)
            self._report_ended(own)

    def _make_all_again(self, olds: list[HostedNode]) -> list[HostedNode]:
        """Construct nodes again, and return them, not spinning; an event names each that fails."""
        made = []
        for old in olds:
            try:
                new = old.make_again()
                self._wait(new)
                made.append(new)
            except Exception as error:
                self._on_event(
                    "ERROR", old.name.lstrip("/"), f"cannot be started again: {in_one_line(error)}"
                )
        return made

    def _report_not_run(
        self, nodes: list[HostedNode], file: NodeFile, error: NodeFileError
    ) -> None:
        """Put the error of a file's new text into the state of nodes, and write an event."""
        for hosted in nodes:
            text = without_file_name(file, str(error))
            hosted.state = hosted.state._replace(error=text, traceback=error.report)
        self._on_event("ERROR", file.path.name, f"the saved text does not run: {error}")

    def _restore_parameters(self, hosted: HostedNode) -> None:
        """Set the operator's parameter values on a new node, which does not spin yet.

        An event names each parameter that the node refuses; `on_restored` is called with the
        others, if any.
        """
        restored = {}
        for name, value in self.operator_values(hosted.name).items():
            reason = hosted.set_parameter(name, value)
            if reason:
                text = f"{name} was not set again: {reason}"  # The value may be a secret.
                self._on_event("WARN", hosted.name.lstrip("/"), text)
            else:
                restored[name] = value
        if restored:
            self._on_restored(hosted.name, restored)

    def _abandon(self, old: HostedNode) -> str:
        """Abandon a stuck node, and return a clause that begins with `, the one before`.

        The clause says that the node was interrupted, or that its callback still runs.
        """
        if old.abandon():
            return ", the one before did not return and was interrupted"
        return ", the one before is stuck: its callback still runs"

    def _make_and_spin(
        self, make: Callable[[], HostedNode], text: str, instead_of: HostedNode | None = None
    ) -> Outcome:
        """Construct a node, add it to the nodes and spin it, after a STOP that is not released.

        Args:
            make: Starts to construct the node.
            text: `NODE started`, for the outcome.
            instead_of: The node that it replaces; None if it is a further one.

        Returns:
            The outcome; REFUSED with the error if the constructor raises, NOT_CONFIRMED if the node
            does not confirm the STOP. A late node is DONE: it is added, and starts by itself.
        """
        try:
            new = make()
            self._wait(new)
        except Exception as error:  # The constructor may raise anything.
            return Outcome(Code.REFUSED, in_one_line(error))
        kept = [hosted for hosted in self.nodes if hosted is not instead_of]
        self.nodes = sorted([*kept, new], key=lambda hosted: hosted.name)
        if new.is_late:
            return Outcome(Code.DONE, f"{text}; {new.lateness_text()}")
        self._restore_parameters(new)
        outcome = self._start(new)
        return outcome._replace(text=text + outcome.text)

    def _find(self, name: str) -> HostedNode:
        return next(hosted for hosted in self.nodes if hosted.name == name)

    def stop(self) -> list[str]:
        """Ask every node and program to end, and wait END_TIMEOUT; then end programs by force.

        `on_end` is not called.

        Returns:
            The names of the nodes and programs that did not end.
        """
        end = time.monotonic() + END_TIMEOUT
        # Whoever holds the lock may hang in the import of a file.
        is_locked = self._changing.acquire(timeout=END_TIMEOUT / 2)
        try:
            self.programs.begin_to_end()
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
        """Call `on_end` with the names that no other node or program that is UP serves.

        Args:
            names: The services and actions that have gone.
            others: The other nodes; None for all of them.
        """
        nodes = [h.state for h in (self.nodes if others is None else others)]
        states = [state for state in (*nodes, *self.programs.states()) if state.life is Life.UP]
        left = {name for state in states for name in state.serves}
        self._on_end([name for name in names if name not in left])

    def _on_crashed(self, hosted: HostedNode) -> None:
        self._report_ended(hosted)
        self._on_event("ERROR", hosted.name.lstrip("/"), f"crashed: {hosted.state.error}")
