"""A node of this process, and the thread that constructs and spins it."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Mapping
from functools import partial
from traceback import extract_stack
from typing import Any, NoReturn

import rclpy
from rclpy.action import get_action_server_names_and_types_by_node
from rclpy.context import Context
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

import archo_tui
from archo_tui.errors import in_one_line
from archo_tui.hosting import global_executor
from archo_tui.hosting.explain import explain
from archo_tui.hosting.global_executor import GlobalExecutor
from archo_tui.hosting.node_files import FileNode
from archo_tui.hosting.time_limit import Interrupted, interrupt, raise_in, run_limited, stack_of
from archo_tui.hosting.tracebacks import traceback_without
from archo_tui.hosting.user_file import NodeFileError, UserFile
from archo_tui.hosting.workers import Workers, multi_threaded
from archo_tui.robot.messages.types import kinds
from archo_tui.robot.messages.values import filled
from archo_tui.robot.outcome import outcome_of
from archo_tui.robot.state.snapshot import Hosted, Life

# Seconds to wait for a constructor before other nodes start, or for a callback before a node spins.
CONSTRUCTION_TIME = 2.0
JOIN_TIMEOUT = 3.0  # Seconds that a callback may still take when its node is stopped.
CONSTRUCTOR_POLL = 0.05  # Seconds between two checks of a constructor.
# The functions of rclpy that return only after other nodes have done something.
_WAITING_FUNCTIONS = {
    *("spin", "spin_once", "spin_until_future_complete"),
    *("wait_for_server", "wait_for_service", "wait_for_services"),
}


class HostedNode:
    """A node, and the thread that constructs and spins it.

    Attributes:
        node: The node; not set until its constructor has returned.
        make: The function or FileNode that makes the node.
        file: The node file; None for a node of the robot's own.
        state: The state of the node; `current_state` is more precise while it is constructed.
        was_stopped_early: True if a STOP was not released when the constructor last spun the node.
        crash: `FILE:LINE` and the error of a node of a file that has crashed; "" otherwise.
    """

    node: Node

    def __init__(
        self,
        make: Callable[..., Node],
        context: Context,
        on_crash: Callable[[HostedNode], None],
        on_event: Callable[[str, str, str], None],
        on_late: Callable[[HostedNode], None],
        on_early: Callable[[HostedNode], object],
        rename: str = "",
    ) -> None:
        """Start the thread, which constructs the node, and return without waiting for it.

        Args:
            make: Makes the node, given the context.
            context: The rclpy context of the node.
            on_crash: Called when the node has crashed, in its thread.
            on_event: Called with level, source and text of an event, in any of its threads.
            on_late: Called when the node is made after `wait` has given up, in its thread.
            on_early: Called each time before the constructor spins the node, in its thread.
            rename: The name of the node; "" for the name that it gives itself.
        """
        self.make, self._context, self._rename = make, context, rename
        self._on_crash, self._on_event = on_crash, on_event
        self._on_late, self._on_early = on_late, on_early
        self.file = make.file if isinstance(make, FileNode) else None
        self._global = GlobalExecutor(context, self._on_added)
        self._executor: Executor = self._global
        self._workers: Workers | None = None
        self._begun: list[Node] = []  # The node of a file, once its constructor has begun.
        self._name = ""  # Set once the node is made.
        self._name_before = "/" if self.file is None else f"/{self.file.path.stem}"
        self.state = Hosted(self.name, Life.STARTING)
        if self.file is not None:
            named, saved = self.file.path.name, self.file.saved
            self.state = self.state._replace(file=named, saved=saved)
        self._stopping = False
        self._was_taken = False
        self.was_stopped_early = False
        self.crash = ""
        self._failure: BaseException | None = None  # What the constructor raised.
        self._is_late = False
        self._began = time.monotonic()
        self._lock = threading.Lock()
        self._has_returned = False  # True once the constructor has returned.
        self._is_over = threading.Event()  # Set once the node is ready to be spun, or has failed.
        self._may_spin = threading.Event()
        # The output of the constructor is known by the name of the thread.
        name = "construction" if self.file is None else f"/{self.file.path.stem}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def name(self) -> str:
        """The full name; until the node has one, `/` and its file's name without `.py`, or `/`."""
        if self._name:
            return self._name
        for node in self._begun:
            with contextlib.suppress(Exception):  # The constructor may not have come that far.
                self._name_before = node.get_fully_qualified_name()
        return self._name_before

    @property
    def is_made(self) -> bool:
        """True once the constructor has returned without an error; stays True."""
        return bool(self._name)

    @property
    def is_late(self) -> bool:
        """True once `wait` has given up on the constructor; stays True when the node is made."""
        return self._is_late

    @property
    def is_stopping(self) -> bool:
        """True if the thread has been asked to end."""
        return self._stopping

    def current_state(self) -> Hosted:
        """Return the state of the node now.

        While a node of a file is constructed, `error` is the line that runs, and `serves` holds the
        services and actions that its constructor has made so far.
        """
        state = self.state
        if state.life is not Life.STARTING or self.file is None:
            return state
        where, line = self.file.code.place(stack_of(self._thread))
        place = without_file_name(self.file, f"{where}{line}")
        return state._replace(name=self.name, error=place, serves=self._serves_by_now())

    def _serves_by_now(self) -> tuple[str, ...]:
        """Return the services and actions that the node has made in its constructor so far.

        The constructor may spin the node and never return. The result is empty while the
        constructor has not called that of `Node`.
        """
        with contextlib.suppress(Exception):  # The constructor may not have come that far.
            return tuple(sorted({name for node in self._begun for name in served_names(node)}))
        return ()

    def wait(self) -> bool:
        """Wait until the node is made; for a node of the robot's own without a time limit.

        Returns:
            False if the constructor of a node of a file waits for other nodes, or takes longer
            than CONSTRUCTION_TIME; it goes on then, and the node is late.

        Raises:
            Exception: The exception that the constructor raises.
        """
        while not self._is_over.wait(None if self.file is None else CONSTRUCTOR_POLL):
            if not (self.is_overdue or waits_for_others(self._thread)):
                continue
            with self._lock:
                self._is_late = not self._is_over.is_set()
            break
        if self._failure is not None and not self._is_late:
            raise self._failure
        return not self._is_late

    @property
    def is_overdue(self) -> bool:
        """True once CONSTRUCTION_TIME has passed since construction began, even if it has ended."""
        return time.monotonic() - self._began >= CONSTRUCTION_TIME

    def lateness_text(self) -> str:
        """Return where the constructor of a late node of a file is, and why it has not returned.

        Returns:
            A line, as `FILE:LINE: Talker.__init__ waits for other nodes, in: ...`.
        """
        assert isinstance(self.make, FileNode)
        where, line = self.make.file.code.place(stack_of(self._thread))
        limit = f"did not return within {CONSTRUCTION_TIME:g} s"
        does = limit if self.is_overdue else "waits for other nodes"
        return f"{where}: {self.make.class_name}.__init__ {does}{line}"

    def wait_longer(self, seconds: float) -> str:
        """Wait for a node that is late.

        Args:
            seconds: The time limit.

        Returns:
            The line at which its constructor still is, or the error that the constructor raised; ""
            if the node is made.
        """
        self._is_over.wait(seconds)
        if self._failure is not None:
            return str(self._failure)
        return "" if self._is_over.is_set() else self.lateness_text()

    def _run(self) -> None:
        """Construct the node, and spin it once `start` allows that.

        An error of the constructor is left to `wait`, or is a crash if `wait` has given up.
        """
        global_executor.use(self._global)
        with contextlib.suppress(Interrupted):  # It was stopped while it was constructed.
            try:
                self._construct()
            except Exception as error:
                self._failure = error
            self._thread.name = f"waiting {self.name}"  # Only spinning threads' names begin with /.
            with self._lock:
                self._is_over.set()
            if self._failure is not None:
                if self._is_late and not self._stopping:
                    self._crashed(self._failure)
                return
            if self._is_late:
                self._on_late(self)
            self._may_spin.wait()
            self._spin()

    def _construct(self) -> None:
        options: dict[str, Any] = {}
        if self._rename:
            options["cli_args"] = ["--ros-args", "-r", f"__node:={self._rename}"]
        if isinstance(self.make, FileNode):
            options["begun"] = self._begun.append
        self.node = self.make(context=self._context, **options)
        self._has_returned = True
        name = self.node.get_fully_qualified_name()
        self._executor, self._workers = self._main_executor(name)
        self._executor.add_node(self.node)
        serves = served_names(self.node)
        self.state = self.state._replace(name=name, life=Life.UP, serves=serves)
        self._name = name

    def _main_executor(self, name: str) -> tuple[Executor, Workers | None]:
        """Return the executor that spins the node as `main()` of its file does.

        If `main()` names no executor, or the node has no file, that is the global executor.

        Returns:
            The executor, and its threads if it has several, else None.
        """
        if not isinstance(self.make, FileNode) or not self.make.has_executor:
            return self._global, None
        if self.make.threads is None:
            return SingleThreadedExecutor(context=self._context), None
        begin = partial(global_executor.use, self._global)
        return multi_threaded(self._context, self.make.threads, name, begin)

    def _on_added(self, node: Node) -> None:
        """Call `on_early` for a node that its constructor is about to spin; warn of a nested spin.

        This is called before user code spins a node, by `rclpy.spin` and the like.
        """
        if not self._is_over.is_set():
            if self._begun and not self._has_returned:
                self._on_early(self)
        elif node.executor not in (None, self._global):
            self._warn_of_nested_spin(node)

    def _warn_of_nested_spin(self, node: Node) -> None:
        """Warn, once, that a nested spin takes a node from the executor of `main()`, as on ROS 2.

        Do nothing for a node of the robot's own, or one that another executor spins.
        """
        if node.executor is not self._executor or self._was_taken or self.file is None:
            return
        self._was_taken = True
        where, line = self.file.code.place(extract_stack())
        name = node.get_name()
        what = f"takes {name} from the executor of main(), which calls nothing of {name} any more"
        self._on_event("WARN", name, f"{where}: {what}: pass executor=self.executor{line}")

    def start(self) -> None:
        """Let the thread spin the node, whose constructor has returned.

        From now on the thread has the name of the node, by which its output is known.
        """
        self._thread.name = self.name
        self._may_spin.set()

    def serves(self, service: str) -> bool:
        """Return True if the node has a service (not an action), also while it is constructed.

        Args:
            service: The full name of the service.
        """
        return self._service(service) is not None

    def _service(self, name: str) -> Any:
        nodes = [self.node] if self.is_made else self._begun
        services = [service for node in nodes for service in node.services]
        return next((found for found in services if found.service_name == name), None)

    def carry_out_stop(self, service: str, request: Mapping[str, Any]) -> str:
        """Call the STOP callback of a node that does not spin yet, for CONSTRUCTION_TIME at most.

        A coroutine that waits for something does not confirm the STOP.

        Args:
            service: The full name of the STOP service, which the node `serves`.
            request: The values of the request; a service whose request has other fields is not
                called.

        Returns:
            The reason why the STOP is not confirmed; "" if it is.
        """
        served = self._service(service)
        kind = served.srv_type

        def stop() -> Any:
            if kinds(kind.Request).keys() != request.keys():
                raise ValueError("the request of its service differs: not called")
            answer = served.callback(filled(kind.Request(), request), kind.Response())
            if isinstance(answer, Coroutine):
                try:
                    answer.send(None)
                except StopIteration as end:
                    return end.value
                answer.close()
                raise ValueError("its callback waits for something")
            return answer

        try:
            answer = run_limited(stop, CONSTRUCTION_TIME, self.name)
            outcome = outcome_of(answer)
        except Exception as error:  # The user's callback may raise anything.
            return in_one_line(error)
        return "" if outcome.ok else outcome.text

    def set_parameter(self, name: str, value: Any) -> str:
        """Set a parameter of a node that does not spin yet, within CONSTRUCTION_TIME.

        Returns:
            "" if the node accepts it; else its reason, what its callback raised, or that the time
            ran out.
        """
        try:
            result = run_limited(
                lambda: self.node.set_parameters([Parameter(name, value=value)])[0],
                CONSTRUCTION_TIME,
                self.name,
            )
        except Exception as error:  # The user's callback may raise anything.
            return in_one_line(error)
        return "" if result.successful else result.reason or "refused"

    def make_again(self) -> HostedNode:
        """Start to construct another node of the same maker and name; this node stays as it is."""
        callbacks = self._on_crash, self._on_event, self._on_late, self._on_early
        return HostedNode(self.make, self._context, *callbacks, self._rename)

    def _spin(self) -> None:
        try:
            while not self._stopping and self._context.ok():
                self._executor.spin_once()
        except (ExternalShutdownException, Interrupted):
            return
        except BaseException as error:  # SystemExit ends the node, not the console.
            self._crashed(error)

    def _crashed(self, error: BaseException) -> None:
        text = in_one_line(error)
        report = traceback_without(error, rclpy, archo_tui)
        if isinstance(error, NodeFileError):
            self.crash, report = str(error), error.report
        elif self.file is not None:
            self.crash = explain(error, self.file.code, self.file.source)[0]
        if self.file is not None:
            text = without_file_name(self.file, self.crash)
        name = self.name
        self.state = self.state._replace(name=name, life=Life.CRASHED, error=text, traceback=report)
        self._leave_graph()
        self._on_crash(self)

    def _leave_graph(self) -> None:
        if self.is_made:
            self._executor.remove_node(self.node)
            destroy(self.node)
        else:  # Take off what the constructor has put on the graph so far.
            for node in self._begun:
                with contextlib.suppress(Exception):
                    destroy(node)

    def threads(self) -> list[threading.Thread]:
        """Return the threads of the node that run: the spinning one, and its workers."""
        workers = self._workers.threads if self._workers is not None else ()
        return [thread for thread in (self._thread, *workers) if thread.is_alive()]

    def begin_to_stop(self) -> None:
        """Ask the thread to end, without waiting for it.

        A constructor is interrupted, and so is a callback that spins; any other callback runs to
        its end. A node that waits for `start` is not spun any more.
        """
        self._stopping = True
        self._may_spin.set()
        if self._thread.is_alive():
            if not self.is_made:
                self.state = self.state._replace(serves=self._serves_by_now())
                raise_in(self._thread)
            self._global.create_task(_end_spinning)
            if self._executor is not self._global:
                self._executor.create_task(lambda: None)

    def stop(self, timeout: float = JOIN_TIMEOUT) -> bool:
        """End the threads and destroy the node; its state becomes STOPPED, unless it has crashed.

        Args:
            timeout: Seconds to wait for the running callbacks.

        Returns:
            False if a callback takes longer: the node is STUCK then, and not destroyed.
        """
        self.begin_to_stop()
        end = time.monotonic() + timeout
        # Asked anew each time, because the spinning thread starts workers until it has ended.
        while (threads := self.threads()) and time.monotonic() < end:
            threads[0].join(max(end - time.monotonic(), 0.0))
        if self.threads():
            self.state = self.state._replace(name=self.name, life=Life.STUCK)
            return False
        self._executor.shutdown(0)
        if self._global is not self._executor:
            self._global.shutdown(0)
        if self.is_made:
            destroy(self.node)
        if self.state.life != Life.CRASHED:
            self.state = self.state._replace(name=self.name, life=Life.STOPPED, error="")
        return True

    def abandon(self) -> bool:
        """Interrupt the threads of a stuck node, and take the node off the graph.

        Returns:
            True if all threads have ended, each within half a second.
        """
        ended = all([interrupt(thread) for thread in self.threads()])
        self._leave_graph()
        return ended


def _end_spinning() -> NoReturn:
    """Raise Interrupted, which ends the spin that runs this task.

    If that spin is nested, the callback around it ends, too.
    """
    raise Interrupted


def waits_for_others(thread: threading.Thread) -> bool:
    """Return True if a thread is within `rclpy.spin` or its like, or waits for a server.

    A callback that the spin runs counts as within it.
    """
    frame = sys._current_frames().get(thread.ident or 0)
    while frame is not None:
        module = frame.f_globals.get("__name__", "")
        if frame.f_code.co_name in _WAITING_FUNCTIONS and module.partition(".")[0] == "rclpy":
            return True
        frame = frame.f_back
    return False


def without_file_name(file: UserFile, text: str) -> str:
    """Shorten `FILE:31: NameError: ...` to `line 31: NameError: ...`, for places that name FILE.

    `FILE: ...` without a line becomes `...`; any other text is returned as it is.
    """
    prefix = f"{file}:"
    if not text.startswith(prefix):
        return text
    rest = text.removeprefix(prefix)
    return f"line {rest}" if rest[:1].isdigit() else rest.strip()


def destroy(node: Node) -> None:
    """Take a node off the graph, with its action servers and clients.

    rclpy leaves action servers and clients on the graph until they are garbage collected. Beside
    the next node of the same name, they would be second servers of its actions.
    """
    for waitable in list(getattr(node, "waitables", ())):
        destroy = getattr(waitable, "destroy", None)
        if destroy is not None:
            destroy()
    node.destroy_node()


def served_names(node: Node) -> tuple[str, ...]:
    """Return the full names of a node's services and actions, sorted.

    Services below the node's own name (`NODE/...`), such as those of its parameters, and those of
    which an action consists are left out.
    """
    own = f"{node.get_fully_qualified_name()}/"
    names = {service.service_name for service in node.services}
    services = {name for name in names if not name.startswith(own) and "/_action/" not in name}
    actions = get_action_server_names_and_types_by_node(node, node.get_name(), node.get_namespace())
    return tuple(sorted(services | {name for name, _ in actions}))
