"""A program on the embedded engine: threads with an rclpy state of their own."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
import weakref
from collections import UserList
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType
from typing import Any

from rclpy import _process
from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.context import Context
from rclpy.executors import Executor, MultiThreadedExecutor
from rclpy.node import Node

from archo_tui.user_code.interrupt import Interrupted, raise_in
from archo_tui.user_code.output import NodeOutput, share_output
from archo_tui.user_code.probe import (
    Probe,
    SpinWatch,
    destroy,
    served_names,
    waits_for_others,
)
from archo_tui.user_code.program import (
    Callbacks,
    HostedProgram,
    Program,
    ProgramEnd,
    exit_code,
    with_ros_args,
)
from archo_tui.user_code.usage import Usage, of_threads

_SERVES_PERIOD = 1.0  # Seconds for which the names of what it serves are kept.
_OWN_END = 0.2  # Seconds in which its threads end by themselves once its contexts are shut down.


class _Process(_process.Process):
    """The rclpy state of one program, as if it were a process, with its nodes and threads."""

    def __init__(self, hosted: ProgramThread) -> None:
        program = hosted.program
        super().__init__(program.domain_id)
        self.arguments = [str(program.file.path), *program.arguments]
        if program.sees_ros_args:
            self.arguments += program.ros_args
        self.file, self.hosted = program.file, hosted
        self.exit_code: int | None = None  # That of `exit`.
        self.main_thread = threading.current_thread()
        self.main: ModuleType | None = None
        self.nodes: list[weakref.ref[Node]] = []
        self.threads: weakref.WeakSet[threading.Thread] = weakref.WeakSet()
        self.awaited: weakref.WeakSet[threading.Thread] = weakref.WeakSet()  # As non-daemons.
        self.pools: weakref.WeakSet[ThreadPoolExecutor] = weakref.WeakSet()
        # Held while a thread starts another one: until that runs, CPython before 3.12 knows it by
        # its starter's number, and what is raised in the starter ends the new thread unseen.
        self.starting = threading.Lock()
        self._spins = SpinWatch(
            self.file, hosted.callbacks.operator_values, lambda **what: hosted.take_report(what)
        )

    def use_as_main(self, module: ModuleType) -> None:
        """Make a module the `__main__` that the threads of this program see."""
        self.main = module

    def begin_context(self, args: Sequence[str] | None) -> Sequence[str]:
        if not self.hosted.begin_context():
            raise KeyboardInterrupt
        return with_ros_args(self.arguments if args is None else args, self.hosted.program)

    def add_node(self, node: Node) -> None:
        self.nodes.append(weakref.ref(node))
        if not self.hosted.accept_node(node.get_fully_qualified_name()):
            raise KeyboardInterrupt

    def spin_node(self, node: Node, executor: Executor) -> None:
        self._spins.add(node, executor, self.executor)

    def living_nodes(self) -> list[Node]:
        """Return the program's nodes that are on the graph, the oldest first."""
        nodes = [node for reference in list(self.nodes) if (node := reference()) is not None]
        return [node for node in nodes if node in node._graph.nodes]

    def contexts(self) -> set[Context]:
        """Return the rclpy contexts that the program uses."""
        used = {node.context for reference in list(self.nodes) if (node := reference())}
        return used | ({self.default_context} if self.default_context is not None else set())


def _current() -> _Process | None:
    """Return the process of the program whose thread this is, or None."""
    process = _process.current()
    return process if isinstance(process, _Process) else None


class _Arguments(UserList[str]):
    """The stand-in for `sys.argv`: in the threads of a program its own words."""

    def __init__(self, original: list[str]) -> None:
        self._original = original

    @property
    def data(self) -> list[str]:  # type: ignore[override]
        process = _current()
        return process.arguments if process is not None else self._original

    def __getitem__(self, index: Any) -> Any:
        return self.data[index]

    def __add__(self, other: Iterable[str]) -> Any:
        return [*self.data, *other]


class _MainModule(ModuleType):
    """The stand-in for `__main__`, which acts as the main module of the program of a thread.

    In other threads it acts as the console's own. Dataclasses with postponed annotations look for
    their module there, and so does pickle.
    """

    def __init__(self, original: ModuleType) -> None:
        super().__init__("__main__")
        object.__setattr__(self, "_original", original)

    def __getattribute__(self, name: str) -> Any:
        process = _current()
        main = process.main if process is not None else None
        return getattr(main or object.__getattribute__(self, "_original"), name)


class _MainThread(threading.Thread):
    """The daemon thread of a program, which appears as no daemon to the program itself.

    So the threads that the program starts are no daemons either, unless the program says so.
    """

    @property
    def daemon(self) -> bool:
        return threading.current_thread() is not self and super().daemon

    @daemon.setter
    def daemon(self, value: bool) -> None:
        threading.Thread.daemon.__set__(self, value)  # type: ignore[attr-defined]


class ProgramThread(HostedProgram):
    """A program in threads of this process, on the embedded engine."""

    thread_class = _MainThread

    def __init__(self, program: Program, callbacks: Callbacks, is_held: bool = False) -> None:
        super().__init__(program, callbacks, is_held)
        self._process = _Process(self)
        self._serves_read = 0.0
        self._serves: tuple[str, ...] = ()

    def run_once(self) -> ProgramEnd:
        self._process = _Process(self)
        _adopt(threading.current_thread(), self._process)
        try:
            console = os.getpid()
            end = self._run_main()
            if os.getpid() != console:  # A fork: the console's copy in it must do nothing.
                os._exit(end.code)
            if end.code and any(thread.is_alive() for thread in self._process.awaited):
                # As Python prints it at once, while other threads run on.
                text = f"{end.error or f'exit code {end.code}'}: its other threads run on"
                self.callbacks.on_event("ERROR", self.name.lstrip("/"), text)
            # Python, too, lets the work of pools end, and awaits threads, before a process ends.
            for pool in list(self._process.pools):
                pool.shutdown(wait=False)
            for thread in list(self._process.awaited):
                thread.join()
        except (Interrupted, KeyboardInterrupt):
            end = ProgramEnd(130)  # 128 and the number of SIGINT, as a shell says it.
        finally:
            self._leave_graph()
            self._end_other_threads()
            if isinstance(sys.stdout, NodeOutput):
                sys.stdout.end_line()
        code = self._process.exit_code
        return end if code is None else ProgramEnd(code)

    def _run_main(self) -> ProgramEnd:
        try:
            self.file.run(self._process.use_as_main, self.has_begun.is_set)
        except SystemExit as error:
            code, text = exit_code(error)
            return ProgramEnd(code, f"{self.file}: {text}" if text else "")
        except (Interrupted, KeyboardInterrupt):
            raise
        except BaseException as error:
            return ProgramEnd(1, *self.file.explain(error))
        return ProgramEnd(0)

    def _other_threads(self) -> list[threading.Thread]:
        threads = list(self._process.threads)
        return [t for t in threads if t is not self._thread and t.is_alive()]

    def _end_other_threads(self) -> None:
        """Wait `_OWN_END` seconds for the threads that the program started; then interrupt them.

        Work that waits in its thread pools is cancelled. Return without waiting for interrupted
        threads.
        """
        for pool in list(self._process.pools):
            pool.shutdown(wait=False, cancel_futures=True)
        end = time.monotonic() + _OWN_END
        for thread in self._other_threads():
            thread.join(max(end - time.monotonic(), 0.0))
        self._raise_in(self._other_threads())

    def _raise_in(
        self, threads: Iterable[threading.Thread], error: type[BaseException] = Interrupted
    ) -> None:
        with self._process.starting:
            for thread in threads:
                raise_in(thread, error)

    def _leave_graph(self) -> None:
        """Destroy the program's nodes and shut down its contexts, as the end of a process does.

        `served` keeps what they have served.
        """
        self.served = self._read_serves() or self.served
        for node in self._process.living_nodes():
            with contextlib.suppress(Exception):
                if isinstance(node.executor, MultiThreadedExecutor):
                    node.executor.shutdown(0, wait_for_threads=False)
                elif node.executor is not None:
                    node.executor.shutdown(0)
            with contextlib.suppress(Exception):
                destroy(node)
        for context in self._process.contexts():
            with contextlib.suppress(Exception):
                context.try_shutdown()

    def node_names(self) -> tuple[str, ...]:
        names: list[str] = []
        for node in self._process.living_nodes():
            with contextlib.suppress(InvalidHandle):  # It is destroyed just now.
                names.append(node.get_fully_qualified_name())
        return tuple(names)

    def serves_now(self) -> tuple[str, ...]:
        now = time.monotonic()
        if now - self._serves_read > _SERVES_PERIOD:
            self._serves_read, self._serves = now, self._read_serves()
        return self._serves

    def _read_serves(self) -> tuple[str, ...]:
        found: set[str] = set()
        for node in self._process.living_nodes():
            with contextlib.suppress(Exception):  # It may be made or destroyed just now.
                found.update(served_names(node))
        return tuple(sorted(found))

    def is_at_rest(self) -> bool:
        threads = [self._thread, *self._other_threads()]
        return self._has_node and any(waits_for_others(thread) for thread in threads)

    def usage(self) -> Usage | None:
        return of_threads([self._thread, *self._other_threads()])

    def constructor_line(self) -> str:
        line: str = self.ask({"ask": "constructor"}).get("constructor", "")
        return line

    def ask(self, request: Mapping[str, Any]) -> dict[str, Any]:
        threads = (self._thread, *self._other_threads())
        return Probe(self.file.code, self._process.living_nodes, lambda: threads).answer(request)

    def interrupt(self) -> None:
        self._raise_in((self._thread,), KeyboardInterrupt)
        for context in self._process.contexts():  # As rclpy does when it gets the signal.
            with contextlib.suppress(Exception):
                context.try_shutdown()

    def release(self) -> None:
        self._leave_graph()

    def force_end(self) -> None:
        if self._thread.is_alive():
            self._leave_graph()
            self._raise_in((*self._other_threads(), self._thread))

    def exit(self, code: int) -> None:
        """End the program at once, on any of its threads, as `os._exit` does; -N is signal N."""
        self._process.exit_code = code
        self.force_end()
        raise Interrupted


def _adopt(thread: threading.Thread, process: _Process) -> None:
    _process.adopt(thread, process)
    process.threads.add(thread)


def install() -> Callable[[], None]:
    """Patch Python's threading so that threads and pools belong to the program that makes them.

    In the threads of a program, `__main__` is the program's module, an exception that ends a thread
    is printed as one line, and what would end the process ends the program. The console's end waits
    for none of these threads. Other threads are as before.
    """
    start, hook = threading.Thread.start, threading.excepthook
    main, arguments = sys.modules["__main__"], sys.argv
    make_pool, exit_process, kill = ThreadPoolExecutor.__init__, os._exit, os.kill
    console = os.getpid()

    def start_in_program(self: threading.Thread) -> None:
        process = _current()
        if process is None:
            start(self)
            return
        _adopt(self, process)
        share_output(self, process.main_thread)
        if self.name.startswith("ThreadPoolExecutor"):  # As an executor of threads has one.
            self.name = process.main_thread.name
        if not self.daemon:
            process.awaited.add(self)
            self.daemon = True  # The end of the console waits for none.
        with process.starting:
            start(self)

    def make_pool_in_program(self: ThreadPoolExecutor, *args: Any, **options: Any) -> None:
        make_pool(self, *args, **options)
        if process := _current():
            process.pools.add(self)

    def hook_of_program(args: threading.ExceptHookArgs) -> None:
        process = _current()
        if process is None:
            hook(args)
        elif args.exc_type is not Interrupted:  # Its program has not ended.
            process.file.print_thread_error(args.exc_value)

    def exit_program(status: int) -> None:
        if (process := _current()) and os.getpid() == console:  # It may be a fork.
            process.hosted.exit(status & 0xFF)
        exit_process(status)

    def kill_from_program(pid: int, number: int) -> None:
        process = _current()
        if process is None or not (pid == console == os.getpid() and number):
            kill(pid, number)
        elif number in (signal.SIGINT, signal.SIGTERM):
            process.hosted.interrupt()
        else:
            process.hosted.exit(-number)

    def uninstall() -> None:
        os._exit, os.kill = exit_process, kill
        threading.Thread.start, threading.excepthook = start, hook  # type: ignore[method-assign]
        ThreadPoolExecutor.__init__ = make_pool  # type: ignore[method-assign]
        sys.modules["__main__"], sys.argv = main, arguments

    os._exit, os.kill = exit_program, kill_from_program  # type: ignore[assignment]
    threading.Thread.start = start_in_program  # type: ignore[method-assign]
    threading.excepthook = hook_of_program
    sys.modules["__main__"] = _MainModule(main)
    sys.argv = _Arguments(arguments)  # type: ignore[assignment]
    ThreadPoolExecutor.__init__ = make_pool_in_program  # type: ignore[method-assign]
    return uninstall
