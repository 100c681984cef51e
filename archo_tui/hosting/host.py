"""Runs nodes in this process, each spun in its own thread; one that fails does so alone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Coroutine, Mapping, Sequence
from contextvars import copy_context
from functools import partial
from itertools import count
from traceback import extract_stack
from typing import Any, NoReturn, TypeVar

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
from archo_tui.hosting.limited import Interrupted, interrupt, run_limited
from archo_tui.hosting.node_files import CONSTRUCTION_TIME, FileNode, NodeFile, NodeFileError
from archo_tui.hosting.tracebacks import own_frames
from archo_tui.hosting.watch import Stamps
from archo_tui.hosting.workers import Workers, multi_threaded
from archo_tui.robot import message_classes
from archo_tui.robot.fields import filled
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import Hosted, Life

T = TypeVar("T")

JOIN_TIMEOUT = 3.0  # s a node's callback may still take when the node is stopped
END_TIMEOUT = 1.5  # s for all of them when the console ends


class HostedNode:
    """One node and the thread that spins it."""

    def __init__(
        self,
        make: Callable[..., Node],
        context: Context,
        on_change: Callable[[HostedNode], None],
        on_event: Callable[[str, str, str], None],
        rename: str = "",
    ) -> None:
        """Construct the node: what its constructor raises comes out here.

        Args:
            make: Makes the node, given the context.
            context: The rclpy context of the node.
            on_change: Called, in the node's thread, when the node has crashed.
            on_event: Called from the node's threads with level, source and text.
            rename: The name of the node; "" for the one that it gives itself.
        """
        self.make, self._context, self._rename = make, context, rename
        self._on_event = on_event
        self._global = self._global_executor()
        options = {"cli_args": ["--ros-args", "-r", f"__node:={rename}"]} if rename else {}
        construct = partial(make, context=context, **options)
        self.node: Node = copy_context().run(self._in_its_thread, construct)
        self.name: str = self.node.get_fully_qualified_name()
        self.file = make.file if isinstance(make, FileNode) else None
        self.state = Hosted(self.name, serves=_served(self.node))
        if self.file is not None:
            named, saved = self.file.path.name, self.file.saved
            self.state = self.state._replace(file=named, saved=saved)
        self._on_change = on_change
        self._stopping = False
        self._was_taken = False
        self.crash = ""  # FILE:LINE and what it raised
        self._executor, self._workers = self._main_executor()
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name=self.name, daemon=True)

    def _global_executor(self) -> Executor:
        """Return what `rclpy.spin` and its like use in the node's code."""
        if isinstance(self.make, FileNode) and self.make.has_executor:
            return GlobalExecutor(self._context, self._taken)
        return SingleThreadedExecutor(context=self._context)

    def _main_executor(self) -> tuple[Executor, Workers | None]:
        """Return what spins the node as `main()` does, and its threads if there are several.

        Where `main()` calls `rclpy.spin(node)`, that is the global executor.
        """
        if not isinstance(self.make, FileNode) or not self.make.has_executor:
            return self._global, None
        if self.make.threads is None:
            return SingleThreadedExecutor(context=self._context), None
        begin = partial(global_executor.use, self._global)
        return multi_threaded(self._context, self.make.threads, self.name, begin)

    def _in_its_thread(self, work: Callable[[], T]) -> T:
        global_executor.use(self._global)
        return work()

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
        self._thread.start()

    def take_stop(self, service: str, request: Mapping[str, Any]) -> str:
        """Have a node that does not spin yet carry out a STOP.

        Args:
            service: Its full name.
            request: What is sent, by field: all the fields that the request must have.

        Returns:
            Why that is not confirmed; empty: it is.
        """
        served = next(found for found in self.node.services if found.service_name == service)
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
        return HostedNode(self.make, self._context, self._on_change, self._on_event, self._rename)

    def _spin(self) -> None:
        global_executor.use(self._global)
        try:
            while not self._stopping and self._context.ok():
                self._executor.spin_once()
        except (ExternalShutdownException, Interrupted):
            return
        except BaseException as error:  # SystemExit, too: it ends the node, not the console
            said = in_one_line(error)
            report = own_frames(error, rclpy, archo_tui)
            if self.file is not None:
                self.crash = self.file.said(error)[0]
                said = in_its_file(self.file, self.crash)
            self.state = self.state._replace(life=Life.CRASHED, error=said, traceback=report)
            self._executor.remove_node(self.node)
            _destroy(self.node)
            self._on_change(self)

    def threads(self) -> list[threading.Thread]:
        """Those that run: the one that spins, and its workers'."""
        workers = self._workers.threads if self._workers is not None else ()
        return [thread for thread in (self._thread, *workers) if thread.is_alive()]

    def begin_to_stop(self) -> None:
        """Have the thread end when the callback returns that it runs, or spins in itself."""
        self._stopping = True
        if self._thread.is_alive():
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
            self.state = self.state._replace(life=Life.STUCK)
            return False
        self._executor.shutdown(0)
        if self._global is not self._executor:
            self._global.shutdown(0)
        _destroy(self.node)
        if self.state.life != Life.CRASHED:
            self.state = self.state._replace(life=Life.STOPPED)
        return True

    def abandon(self) -> bool:
        """Take a node off the graph whose callback does not return; False when that goes on."""
        ended = all([interrupt(thread) for thread in self.threads()])
        self._executor.remove_node(self.node)
        _destroy(self.node)
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
        self.nodes: list[HostedNode] = []

    def add(self, make: Callable[..., Any]) -> HostedNode:
        """Construct a node; `start()` spins it. Raises what the constructor raises."""
        hosted = HostedNode(make, self._context, self._crashed, self._on_event)
        self.nodes.append(hosted)
        return hosted

    def start(self) -> None:
        """Spin every node."""
        for hosted in self.nodes:
            hosted.start()

    def states(self) -> tuple[Hosted, ...]:
        """How each is doing; from any thread."""
        return tuple(hosted.state for hosted in self.nodes)

    def start_node(self, name: str) -> Outcome:
        """Construct a stopped or crashed node again and spin it."""
        with self._changing:
            named = [hosted for hosted in self.nodes if hosted.name == name]
            old = next((h for h in named if h.state.life != Life.UP), named[0])
            if old.state.life == Life.UP:
                return Outcome(Code.REFUSED, f"{name} is running")
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
            return self._spin(
                lambda: HostedNode(kind, self._context, self._crashed, self._on_event, short),
                f"{short} started",
            )

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
                    news.append(HostedNode(make, self._context, self._crashed, self._on_event))
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
            for new in news:
                self._set_again(new, kept(new.name))
            self.nodes = sorted(
                [*(hosted for hosted in self.nodes if hosted not in olds), *news],
                key=lambda hosted: hosted.name,
            )
            stopped = "".join([self._begin(new).text for new in news])
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
        service, request = self._stop_to_tell()
        outcome = Outcome(Code.DONE, "")
        if service in new.state.serves:
            refusal = new.take_stop(service, request)
            if refusal:
                why = f"the STOP is not confirmed by it ({refusal}): use the hardware stop"
                self._on_event("ERROR", new.name.lstrip("/"), why)
                outcome = Outcome(Code.NOT_CONFIRMED, f"; {why}")
            else:
                self._told_stop(new.name)
                told = f"; {new.name} was told STOP first, and is stopped"
                outcome = Outcome(Code.DONE, told)
        new.start()
        return outcome

    def _constructed(self, olds: list[HostedNode]) -> list[HostedNode]:
        """Nodes as they were, as far as they still can be."""
        found = []
        for old in olds:
            try:
                found.append(old.again())
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

    def _set_again(self, hosted: HostedNode, kept: Mapping[str, Any]) -> None:
        """Parameters of a node that does not spin yet; those that do not fit are said."""
        for name, value in kept.items():
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
        except Exception as error:  # whatever the node's constructor raises
            return Outcome(Code.REFUSED, in_one_line(error))
        kept = [hosted for hosted in self.nodes if hosted is not instead_of]
        self.nodes = sorted([*kept, new], key=lambda hosted: hosted.name)
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
