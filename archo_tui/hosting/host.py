"""Runs nodes in this process, each spun in its own thread; one that fails does so alone."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Mapping, Sequence
from functools import partial
from itertools import count
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
from archo_tui.hosting.global_executor import GlobalExecutor
from archo_tui.hosting.limited import Interrupted, interrupt, raise_in, run_limited, stack_of
from archo_tui.hosting.node_files import FileNode, NodeFile, NodeFileError
from archo_tui.hosting.tracebacks import own_frames
from archo_tui.hosting.watch import Stamps
from archo_tui.hosting.workers import Workers, multi_threaded
from archo_tui.robot import message_classes
from archo_tui.robot.fields import filled
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import Hosted, Life

CONSTRUCTION_TIME = 2.0  # s that a node of a file may take to be made before others are started
JOIN_TIMEOUT = 3.0  # s a node's callback may still take when the node is stopped
END_TIMEOUT = 1.5  # s for all of them when the console ends
_CONSTRUCTOR_POLL = 0.05  # s between two looks at a constructor
_WAITING = {  # functions of rclpy that return when other nodes have done something
    *("spin", "spin_once", "spin_until_future_complete"),
    *("wait_for_server", "wait_for_service", "wait_for_services"),
}
_LOCK_WAIT = 0.05  # s for the lock, before a late node looks whether it is being stopped


class HostedNode:
    """One node and the thread that constructs and spins it."""

    node: Node  # once it is made

    def __init__(
        self,
        make: Callable[..., Node],
        context: Context,
        on_change: Callable[[HostedNode], None],
        on_event: Callable[[str, str, str], None],
        on_late: Callable[[HostedNode], None],
        on_early: Callable[[HostedNode], object],
        rename: str = "",
    ) -> None:
        """Begin to construct the node; `wait` tells what comes of it.

        Args:
            make: Makes the node, given the context.
            context: The rclpy context of the node.
            on_change: Called, in the node's thread, when the node has crashed.
            on_event: Called from the node's threads with level, source and text.
            on_late: Called, in the node's thread, when it is made and `wait` has given it up.
            on_early: Called, in the node's thread, before its constructor spins it.
            rename: The name of the node; "" for the one that it gives itself.
        """
        self.make, self._context, self._rename = make, context, rename
        self._on_change, self._on_event = on_change, on_event
        self._on_late, self._on_early = on_late, on_early
        self.file = make.file if isinstance(make, FileNode) else None
        self.kept: Callable[[str], Mapping[str, Any]] = lambda _: {}
        self._global = GlobalExecutor(context, self._added)
        self._executor: Executor = self._global
        self._workers: Workers | None = None
        self._begun: list[Node] = []  # a node of a file whose constructor runs, or has run
        self._name = ""  # once it is made
        self._name_before = "/" if self.file is None else f"/{self.file.path.stem}"
        self.state = Hosted(self.name, Life.STARTING)
        if self.file is not None:
            named, saved = self.file.path.name, self.file.saved
            self.state = self.state._replace(file=named, saved=saved)
        self._stopping = False
        self._was_taken = False
        self.was_told_early = False  # of the STOP that holds, before its constructor spun it
        self.crash = ""  # FILE:LINE and what it raised
        self._failure: BaseException | None = None  # of the constructor
        self._is_late = False
        self._began = time.monotonic()
        self._lock = threading.Lock()
        self._has_returned = False  # the constructor
        self._is_over = threading.Event()  # all that is to be done before the node is spun
        self._may_spin = threading.Event()
        # what the constructor prints is known by the name of the thread
        name = "construction" if self.file is None else f"/{self.file.path.stem}"
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def name(self) -> str:
        """Fully qualified; of a node that has none yet the name of its file."""
        if self._name:
            return self._name
        for node in self._begun:
            with contextlib.suppress(Exception):  # how far its constructor is nobody knows
                self._name_before = node.get_fully_qualified_name()
        return self._name_before

    @property
    def is_made(self) -> bool:
        """True when its constructor has returned."""
        return bool(self._name)

    @property
    def is_late(self) -> bool:
        """True when it was not made in time: it is started when it is made."""
        return self._is_late

    @property
    def is_stopping(self) -> bool:
        """True when the thread is to end."""
        return self._stopping

    def look(self) -> Hosted:
        """Return how the node is doing; of one that starts, where its constructor is."""
        state = self.state
        if state.life is not Life.STARTING or self.file is None:
            return state
        where, line = self.file.place(stack_of(self._thread))
        said = in_its_file(self.file, f"{where}{line}")
        return state._replace(name=self.name, error=said, serves=self._serves_by_now())

    def _serves_by_now(self) -> tuple[str, ...]:
        """Return what a node serves whose constructor runs, which may spin it for good."""
        with contextlib.suppress(Exception):  # how far its constructor is nobody knows
            return tuple(sorted({name for node in self._begun for name in _served(node)}))
        return ()

    def wait(self) -> bool:
        """Wait until the node is made. Raises what its constructor raises.

        Returns:
            False when the constructor of a node of a file waits for other nodes, or takes longer
            than CONSTRUCTION_TIME; it goes on.
        """
        while not self._is_over.wait(None if self.file is None else _CONSTRUCTOR_POLL):
            if not (self.is_overdue or self._waits_for_others()):
                continue
            with self._lock:
                self._is_late = not self._is_over.is_set()
            break
        if self._failure is not None and not self._is_late:
            raise self._failure
        return not self._is_late

    @property
    def is_overdue(self) -> bool:
        """True when CONSTRUCTION_TIME has passed since the constructor began."""
        return time.monotonic() - self._began >= CONSTRUCTION_TIME

    def _waits_for_others(self) -> bool:
        """Return whether the constructor is in a function of rclpy that waits for other nodes."""
        frame = sys._current_frames().get(self._thread.ident or 0)
        while frame is not None:
            module = frame.f_globals.get("__name__", "")
            if frame.f_code.co_name in _WAITING and module.partition(".")[0] == "rclpy":
                return True
            frame = frame.f_back
        return False

    def lateness(self) -> str:
        """Return where the constructor of a node of a file is, which takes its time."""
        assert isinstance(self.make, FileNode)
        where, line = self.make.file.place(stack_of(self._thread))
        limit = f"did not return within {CONSTRUCTION_TIME:g} s"
        does = limit if self.is_overdue else "waits for other nodes"
        return f"{where}: {self.make.class_name}.__init__ {does}{line}"

    def wait_longer(self, seconds: float) -> str:
        """Wait for a node that is late.

        Returns:
            Where its constructor is, or what it raised; "" when the node is made.
        """
        self._is_over.wait(seconds)
        if self._failure is not None:
            return str(self._failure)
        return "" if self._is_over.is_set() else self.lateness()

    def _run(self) -> None:
        """Construct the node, and spin it once that is allowed."""
        global_executor.use(self._global)
        with contextlib.suppress(Interrupted):  # it is stopped as it is constructed
            try:
                self._construct()
            except Exception as error:
                self._failure = error
            self._thread.name = f"waiting {self.name}"  # no spinning thread's: those begin with /
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
        serves = _served(self.node)
        self.state = self.state._replace(name=name, life=Life.UP, serves=serves)
        self._name = name

    def _main_executor(self, name: str) -> tuple[Executor, Workers | None]:
        """Return what spins the node as `main()` does, and its threads if there are several.

        Where `main()` calls `rclpy.spin(node)`, that is the global executor.
        """
        if not isinstance(self.make, FileNode) or not self.make.has_executor:
            return self._global, None
        if self.make.threads is None:
            return SingleThreadedExecutor(context=self._context), None
        begin = partial(global_executor.use, self._global)
        return multi_threaded(self._context, self.make.threads, name, begin)

    def _added(self, node: Node) -> None:
        """Look at a node that its own code is about to spin, by `rclpy.spin` and its like."""
        if not self._is_over.is_set():
            if self._begun and not self._has_returned:
                self._on_early(self)
        elif node.executor not in (None, self._global):
            self._taken(node)

    def _taken(self, node: Node) -> None:
        """Warn that a nested spin takes the node from the executor of `main()`, as on ROS 2."""
        if node.executor is not self._executor or self._was_taken or self.file is None:
            return
        self._was_taken = True
        where, line = self.file.place(extract_stack())
        name = node.get_name()
        said = f"takes {name} from the executor of main(), which calls nothing of {name} any more"
        self._on_event("WARN", name, f"{where}: {said}: pass executor=self.executor{line}")

    def start(self) -> None:
        """Begin to spin."""
        self._thread.name = self.name
        self._may_spin.set()

    def serves(self, service: str) -> bool:
        """Return whether the node has that service, also while it is constructed."""
        return self._service(service) is not None

    def _service(self, name: str) -> Any:
        nodes = [self.node] if self.is_made else self._begun
        services = [service for node in nodes for service in node.services]
        return next((found for found in services if found.service_name == name), None)

    def take_stop(self, service: str, request: Mapping[str, Any]) -> str:
        """Have a node that does not spin yet carry out a STOP.

        Args:
            service: Its full name.
            request: What is sent, by field: all the fields that the request must have.

        Returns:
            Why that is not confirmed; empty: it is.
        """
        served = self._service(service)
        kind = served.srv_type

        def stop() -> Any:
            if message_classes.fields(kind.Request) != set(request):
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
            outcome = message_classes.outcome_of(answer)
        except Exception as error:  # whatever the user's callback raises
            return in_one_line(error)
        return "" if outcome.ok else outcome.text

    def again(self) -> HostedNode:
        """Another node of the same kind and name, as it was at the start."""
        told = self._on_change, self._on_event, self._on_late, self._on_early
        return HostedNode(self.make, self._context, *told, self._rename)

    def _spin(self) -> None:
        try:
            while not self._stopping and self._context.ok():
                self._executor.spin_once()
        except (ExternalShutdownException, Interrupted):
            return
        except BaseException as error:  # SystemExit, too: it ends the node, not the console
            self._crashed(error)

    def _crashed(self, error: BaseException) -> None:
        said = in_one_line(error)
        report = own_frames(error, rclpy, archo_tui)
        if isinstance(error, NodeFileError):
            self.crash, report = str(error), error.report
        elif self.file is not None:
            self.crash = self.file.said(error)[0]
        if self.file is not None:
            said = in_its_file(self.file, self.crash)
        name = self.name
        self.state = self.state._replace(name=name, life=Life.CRASHED, error=said, traceback=report)
        self._leave_graph()
        self._on_change(self)

    def _leave_graph(self) -> None:
        if self.is_made:
            self._executor.remove_node(self.node)
            _destroy(self.node)
        else:  # as far as it was made
            for node in self._begun:
                with contextlib.suppress(Exception):
                    _destroy(node)

    def threads(self) -> list[threading.Thread]:
        """Those that run: the one that spins, and its workers'."""
        workers = self._workers.threads if self._workers is not None else ()
        return [thread for thread in (self._thread, *workers) if thread.is_alive()]

    def begin_to_stop(self) -> None:
        """Have the thread end when the callback returns that it runs, or spins in itself.

        A constructor is interrupted.
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
        """End the thread and destroy the node; False when a callback takes longer than that (s)."""
        self.begin_to_stop()
        end = time.monotonic() + timeout
        # asked anew each time: until it has ended, the one that spins starts workers
        while (threads := self.threads()) and time.monotonic() < end:
            threads[0].join(max(end - time.monotonic(), 0.0))
        if self.threads():
            self.state = self.state._replace(name=self.name, life=Life.STUCK)
            return False
        self._executor.shutdown(0)
        if self._global is not self._executor:
            self._global.shutdown(0)
        if self.is_made:
            _destroy(self.node)
        if self.state.life != Life.CRASHED:
            self.state = self.state._replace(name=self.name, life=Life.STOPPED, error="")
        return True

    def abandon(self) -> bool:
        """Take a node off the graph whose callback does not return; False when that goes on."""
        ended = all([interrupt(thread) for thread in self.threads()])
        self._leave_graph()
        return ended


def _end_spinning() -> NoReturn:
    """End a spin from within, also one in a callback, with the callback around it."""
    raise Interrupted


def in_its_file(file: NodeFile, said: str) -> str:
    """What is wrong with a file, where its name is seen already: `line 31: NameError: ...`."""
    prefix = f"{file}:"
    if not said.startswith(prefix):
        return said
    rest = said.removeprefix(prefix)
    return f"line {rest}" if rest[:1].isdigit() else rest.strip()


def _destroy(node: Node) -> None:
    """Take a node off the graph, with its actions.

    rclpy leaves their servers there until they are collected: beside the node that is started next
    they would be second servers of its actions.
    """
    for waitable in list(getattr(node, "waitables", ())):
        destroy = getattr(waitable, "destroy", None)
        if destroy is not None:
            destroy()
    node.destroy_node()


def _served(node: Node) -> tuple[str, ...]:
    """The services and actions of a node, but for those of its parameters: every node has them."""
    own = f"{node.get_fully_qualified_name()}/"
    names = {service.service_name for service in node.services}
    services = {name for name in names if not name.startswith(own) and "/_action/" not in name}
    actions = get_action_server_names_and_types_by_node(node, node.get_name(), node.get_namespace())
    return tuple(sorted(services | {name for name, _ in actions}))


class Host:
    """The nodes of this process. Changing them may take JOIN_TIMEOUT: never on the UI thread."""

    def __init__(
        self,
        context: Context,
        on_event: Callable[[str, str, str], None],
        on_end: Callable[[Sequence[str]], None],
        stop_to_tell: Callable[[], tuple[str, Mapping[str, Any]]] = lambda: ("", {}),
        told_stop: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Host no node yet.

        Args:
            context: The rclpy context of the nodes.
            on_event: Called from the nodes' threads with level, source and text.
            on_end: Called with the services and actions that went with a node of this process.
            stop_to_tell: Returns the service of a STOP that is not released, or "", and a request.
            told_stop: Called with the name of a node that has confirmed it before it spins.
        """
        self._context = context
        self._on_event, self._on_end = on_event, on_end
        self._stop_to_tell, self._told_stop = stop_to_tell, told_stop
        self._changing = threading.Lock()
        self._has_started = False
        self.nodes: list[HostedNode] = []

    def add(self, make: Callable[..., Any]) -> None:
        """Construct a node; `start()` spins it. Raises what the constructor raises."""
        with self._changing:
            hosted = self._hosted(make)
            self._wait(hosted)
            self.nodes.append(hosted)

    def _hosted(self, make: Callable[..., Any], rename: str = "") -> HostedNode:
        told = self._crashed, self._on_event, self._made_late, self._tell_stop_early
        return HostedNode(make, self._context, *told, rename)

    def _wait(self, hosted: HostedNode) -> None:
        """Wait for a node, or say where its constructor is. Raises what that raises."""
        if not hosted.wait():
            level = "WARN" if hosted.is_overdue else "INFO"
            self._on_event(level, hosted.name.lstrip("/"), hosted.lateness())

    def start(self) -> None:
        """Spin every node."""
        with self._changing:
            self._has_started = True
            for hosted in self.nodes:
                if hosted.is_made:
                    hosted.start()

    def wait_longer(self, seconds: float) -> list[str]:
        """Wait for the nodes that are late; returns what is wrong with each that is not made."""
        end = time.monotonic() + seconds
        late = [hosted for hosted in self.nodes if hosted.is_late]
        waited = (hosted.wait_longer(max(end - time.monotonic(), 0.0)) for hosted in late)
        return [wrong for wrong in waited if wrong]

    def states(self) -> tuple[Hosted, ...]:
        """How each is doing; from any thread."""
        return tuple(hosted.look() for hosted in self.nodes)

    def start_node(self, name: str) -> Outcome:
        """Construct a stopped or crashed node again and spin it."""
        with self._changing:
            named = [hosted for hosted in self.nodes if hosted.name == name]
            old = next((h for h in named if not h.state.life.is_running), named[0])
            if old.state.life.is_running:
                does = "starting" if old.state.life is Life.STARTING else "running"
                return Outcome(Code.REFUSED, f"{name} is {does}")
            said = f"{name} started"
            if not old.stop():  # it may be stuck; a crashed one releases what it holds
                said += self._left(old)
                self._gone(old)
            return self._spin(old.again, said, instead_of=old)

    def stop_node(self, name: str) -> Outcome:
        """Stop a node; the others are not affected."""
        with self._changing:
            hosted = self._find(name)
            if not hosted.stop():
                return Outcome(Code.TIMEOUT, f"{name} does not stop: its callback does not return")
            self._gone(hosted)
            holds = self._stop_to_tell()[0] in hosted.state.serves
            held = "; it held the STOP, and is told of it again before it starts" if holds else ""
            return Outcome(Code.DONE, f"{name} stopped{held}")

    def copy_node(self, name: str) -> Outcome:
        """Run one more node of the same kind, under the next free name: `dashboard_2`."""
        with self._changing:
            kind = self._find(name).make
            first = next(hosted for hosted in self.nodes if hosted.make is kind)
            taken = {hosted.name for hosted in self.nodes}
            number = next(n for n in count(2) if f"{first.name}_{n}" not in taken)
            short = f"{first.name.rpartition('/')[2]}_{number}"
            return self._spin(lambda: self._hosted(kind, short), f"{short} started")

    def reload(self, file: NodeFile, kept: Callable[[str], Mapping[str, Any]]) -> None:
        """Run the nodes of a file as it stands now, in place of those of its text before.

        Where it cannot be imported these run on; where a node cannot be constructed they are
        constructed again. `kept(name)` are parameters that the operator has set.
        """
        with self._changing:
            olds = [hosted for hosted in self.nodes if hosted.file is file]
            try:
                makers = file.load()
            except NodeFileError as error:
                self._not_run(olds, file, error)
                return
            for old in olds:
                if not old.stop():
                    self._on_event("WARN", old.name.lstrip("/"), self._left(old).lstrip(", "))
                self._gone(old)
            failed: NodeFileError | None = None
            news: list[HostedNode] = []
            try:
                for make in makers:
                    news.append(self._hosted(make))
                    news[-1].kept = kept
                    self._wait(news[-1])
            except Exception as error:  # NodeFileError, or what rclpy says of a name
                failed = error if isinstance(error, NodeFileError) else NodeFileError(str(error))
                for new in news:
                    new.stop()
                file.back()
                news = self._constructed(olds)
            names = {new.name for new in news}
            for other in [h for h in self.nodes if h not in olds and h.name in names]:
                other.stop()  # a node of the robot's own, whose place it takes
                olds.append(other)
            made = [new for new in news if not new.is_late]
            for new in made:
                self._set_again(new)
            self.nodes = sorted(
                [*(hosted for hosted in self.nodes if hosted not in olds), *news],
                key=lambda hosted: hosted.name,
            )
            stopped = "".join([self._begin(new).text for new in made])
        if failed is not None:
            self._not_run(news, file, failed)
        else:
            restarted = ", ".join(sorted(names))
            said = f"{file.path.name} was saved: {restarted} restarted{stopped}"
            self._on_event("YOU", "console", said)
            if file.not_run:
                self._on_event("WARN", file.path.name, file.not_run)

    def _begin(self, new: HostedNode) -> Outcome:
        """Spin a node; behind a STOP that is not released it first carries that out.

        Returns:
            What becomes of the STOP; its text is put behind that the node was started.
        """
        outcome = self._tell_stop(new)
        new.start()
        return outcome

    def _tell_stop(self, new: HostedNode) -> Outcome:
        """Have a node started here carry out a STOP that is not released, if it serves it."""
        service, request = self._stop_to_tell()
        if not service or not new.serves(service):
            return Outcome(Code.DONE, "")
        refusal = new.take_stop(service, request)
        if refusal:
            why = f"the STOP is not confirmed by it ({refusal}): use the hardware stop"
            self._on_event("ERROR", new.name.lstrip("/"), why)
            return Outcome(Code.NOT_CONFIRMED, f"; {why}")
        self._told_stop(new.name)
        return Outcome(Code.DONE, f"; {new.name} was told STOP first, and is stopped")

    def _tell_stop_early(self, new: HostedNode) -> None:
        """Do so before the node's constructor spins it for the first time behind that STOP.

        Behind a later spin the node takes the request itself.
        """
        is_told, new.was_told_early = new.was_told_early, bool(self._stop_to_tell()[0])
        if not is_told:
            self._tell_stop(new)

    def _made_late(self, hosted: HostedNode) -> None:
        """Start a node that was not made in time; it may have the name of one of the robot's own.

        In the node's thread: whoever stops the node waits for that, and may hold the lock.
        """
        while not self._changing.acquire(timeout=_LOCK_WAIT):
            if hosted.is_stopping:
                return
        try:
            if hosted.is_stopping:
                return
            self._set_again(hosted)
            for other in [h for h in self.nodes if h.file is None and h.name == hosted.name]:
                other.stop()
                self.nodes.remove(other)
                self._gone(other)
            self._on_event("INFO", hosted.name.lstrip("/"), "its constructor has returned")
            if self._has_started:
                self._begin(hosted)
        finally:
            self._changing.release()

    def _constructed(self, olds: list[HostedNode]) -> list[HostedNode]:
        """Nodes as they were, as far as they still can be."""
        found = []
        for old in olds:
            try:
                again = old.again()
                self._wait(again)
                found.append(again)
            except Exception as error:
                self._on_event(
                    "ERROR", old.name.lstrip("/"), f"cannot be started again: {in_one_line(error)}"
                )
        return found

    def _not_run(self, nodes: list[HostedNode], file: NodeFile, error: NodeFileError) -> None:
        """Say why the new text does not run."""
        for hosted in nodes:
            said = in_its_file(file, str(error))
            hosted.state = hosted.state._replace(error=said, traceback=error.report)
        self._on_event("ERROR", file.path.name, f"the saved text does not run: {error}")

    def _set_again(self, hosted: HostedNode) -> None:
        """Parameters of a node that does not spin yet; those that do not fit are said."""
        for name, value in hosted.kept(hosted.name).items():
            try:
                result = run_limited(
                    lambda name=name, value=value: hosted.node.set_parameters(  # type: ignore[misc]
                        [Parameter(name, value=value)]
                    )[0],
                    CONSTRUCTION_TIME,
                    hosted.name,
                )
                reason = "" if result.successful else result.reason or "refused"
            except Exception as error:
                reason = in_one_line(error)
            if reason:
                said = f"{name} was not set again: {reason}"  # its value may be a secret
                self._on_event("WARN", hosted.name.lstrip("/"), said)

    def _left(self, old: HostedNode) -> str:
        """Go on without a stuck node; returns what is left of it."""
        if old.abandon():
            return ", the one before did not return and was interrupted"
        return ", the one before is stuck: its callback still runs"

    def _spin(
        self, make: Callable[[], HostedNode], said: str, instead_of: HostedNode | None = None
    ) -> Outcome:
        try:
            new = make()
            self._wait(new)
        except Exception as error:  # whatever the node's constructor raises
            return Outcome(Code.REFUSED, in_one_line(error))
        kept = [hosted for hosted in self.nodes if hosted is not instead_of]
        self.nodes = sorted([*kept, new], key=lambda hosted: hosted.name)
        if new.is_late:
            return Outcome(Code.DONE, f"{said}; {new.lateness()}")
        outcome = self._begin(new)
        return outcome._replace(text=said + outcome.text)

    def _find(self, name: str) -> HostedNode:
        return next(hosted for hosted in self.nodes if hosted.name == name)

    def stop(self) -> list[str]:
        """Stop every node; returns the names of those that did not end within END_TIMEOUT."""
        end = time.monotonic() + END_TIMEOUT
        changed = self._changing.acquire(timeout=END_TIMEOUT / 2)  # a file may hang in its import
        try:
            for hosted in self.nodes:
                hosted.begin_to_stop()
            return [n.name for n in self.nodes if not n.stop(max(end - time.monotonic(), 0.0))]
        finally:
            if changed:
                self._changing.release()

    def _gone(self, hosted: HostedNode) -> None:
        """Tell of what nobody here serves any more."""
        others = [one for one in self.nodes if one is not hosted and one.state.life == Life.UP]
        left = {name for one in others for name in one.state.serves}
        self._on_end([name for name in hosted.state.serves if name not in left])

    def _crashed(self, hosted: HostedNode) -> None:
        self._gone(hosted)
        self._on_event("ERROR", hosted.name.lstrip("/"), f"crashed: {hosted.state.error}")


class HostedFile:
    """A node file that is watched: its nodes are restarted when it was saved."""

    def __init__(
        self, host: Host, file: NodeFile, kept: Callable[[str], Mapping[str, Any]]
    ) -> None:
        """`kept(node)` are the parameters that the operator has set."""
        self._host, self._file, self._kept = host, file, kept

    @property
    def loaded(self) -> Stamps:
        """Of the text that was last loaded, or tried."""
        return self._file.loaded

    def look(self) -> Stamps:
        """As it is now, with what it imports from its folder."""
        return self._file.look()

    def reload(self) -> None:
        """Run it as it is now."""
        self._host.reload(self._file, self._kept)
