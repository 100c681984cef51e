"""The child process of a program on ROS 2: `... child_main REPORTS REQUESTS FILE ...`.

It runs the file as `python FILE ...` does, and reports on a file descriptor, a JSON object a line:
`init` with its imports, each `node`, what they serve, what of its parameters was restored,
warnings, answers and its error. From another one it reads requests: `go_on`, with the parameters
that the operator has set, and what `Probe` answers.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import queue
import select
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

assert sys.platform != "win32"  # As mypy is to know; there the console runs no programs on ROS 2.

_ROSOUT_TIME = 5.0  # Seconds in which a new node finds the console's subscription to its logs.
_POLL = 0.01  # Seconds between two looks for it.
_GRACE = 3.0  # Seconds between SIGINT and SIGKILL, when the console has gone.
MARK = "ARCHO_TUI_PROGRAM"  # A variable in the environment of a program and of all it starts.
_KILL_TIME = 1.0  # Seconds in which a process that gets SIGKILL is gone.


def main() -> int:
    """Run the file of the command line, reporting to the console, and return its exit code."""
    descriptor, requests, given = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    os.set_inheritable(descriptor, False)
    os.set_inheritable(requests, False)
    threading.Thread(target=_end_with_console, args=(descriptor,), daemon=True).start()
    from archo_tui.user_code.file import ProgramFile
    from archo_tui.user_code.program import Program, exit_code

    file = ProgramFile(given)
    at = sys.argv.index("--ros-args")  # The console adds them, after the program's own words.
    reporter = _Reporter(descriptor, requests, Program(file, tuple(sys.argv[at:])))
    sys.argv = sys.argv[3:at]
    threading.excepthook = lambda args: file.print_thread_error(args.exc_value)
    try:
        file.compile()
        file.run(lambda module: sys.modules.update(__main__=module), lambda: reporter.has_begun)
    except SystemExit as error:
        code, text = exit_code(error)
        if text:
            reporter.report(error=f"{given}: {text}")
        return code
    except KeyboardInterrupt:
        return 130  # 128 and the number of SIGINT, as a shell says it.
    except BaseException as error:
        text, traceback = file.explain(error)
        reporter.report(error=text, traceback=traceback)
        return 1
    return 0


class _Reporter:
    """The reports of the nodes to the console, by functions of rclpy that are replaced."""

    def __init__(self, descriptor: int, requests: int, program: Any) -> None:
        import rclpy
        from rclpy.action import ActionServer
        from rclpy.context import Context
        from rclpy.executors import Executor
        from rclpy.node import Node

        from archo_tui.user_code.probe import Probe, SpinWatch, served_names
        from archo_tui.user_code.program import with_ros_args

        file = program.file
        self._descriptor, self.has_begun = descriptor, False
        self._pid = os.getpid()
        self._answers: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._asking = threading.Lock()
        self._nodes = nodes = list[Any]()
        values: dict[str, dict[str, Any]] = {}  # That the operator has set, by node.
        spins = SpinWatch(file, lambda name: values.get(name, {}), self.report)
        init_context, make_node, make_service, make_action, add_node = (
            *(Context.init, Node.__init__, Node.create_service),
            *(ActionServer.__init__, Executor.add_node),
        )

        def init(this: Context, args: Any = None, **options: Any) -> None:
            self._ask(init=[str(path) for path in file.own_modules().values()])
            self.has_begun = True
            words = sys.argv if args is None else args
            init_context(this, with_ros_args(words, program), **options)

        def make(this: Node, *args: Any, **options: Any) -> None:
            make_node(this, *args, **options)
            name = this.get_fully_qualified_name()
            values[name] = self._ask(node=name)["values"]
            nodes.append(this)
            end = time.monotonic() + _ROSOUT_TIME  # What it logs before is heard by nobody.
            while not this.count_subscribers("/rosout") and time.monotonic() < end:
                time.sleep(_POLL)

        def report_services() -> None:
            self.report(serves=sorted({name for node in nodes for name in served_names(node)}))

        def create_service(this: Node, *args: Any, **options: Any) -> Any:
            service = make_service(this, *args, **options)
            report_services()
            return service

        def init_action(this: Any, *args: Any, **options: Any) -> None:
            make_action(this, *args, **options)
            report_services()

        def add(this: Executor, node: Node) -> bool:
            spins.add(node, this, rclpy.get_global_executor())
            return add_node(this, node)

        atexit.register(self._destroy_nodes)  # Behind the end of all threads of the program.
        probe = Probe(file.code, lambda: nodes, threading.enumerate)
        threading.Thread(target=self._read, args=(requests, probe), daemon=True).start()
        Context.init = init  # type: ignore[assignment, method-assign]
        Node.__init__ = make  # type: ignore[assignment, method-assign]
        Node.create_service = create_service  # type: ignore[assignment, method-assign]
        ActionServer.__init__ = init_action  # type: ignore[assignment, method-assign]
        Executor.add_node = add  # type: ignore[assignment, method-assign]

    def report(self, **what: Any) -> None:
        if os.getpid() != self._pid:
            return  # Of a child that it has forked.
        with contextlib.suppress(BrokenPipeError):  # The console was killed, and so is this.
            os.write(self._descriptor, json.dumps(what).encode() + b"\n")

    def _destroy_nodes(self) -> None:
        """Take the nodes off the graph, where Kilted leaves those that are referenced for 20 s."""
        from rclpy.node import Node

        for node in self._nodes:
            with contextlib.suppress(Exception):  # The program may have destroyed parts of it.
                Node.destroy_node(node)  # A program's own does what it did at its end already.

    def _ask(self, **what: Any) -> dict[str, Any]:
        """Report, and wait for the answer of the console, which may end the program."""
        with self._asking:
            self.report(**what)
            answer = self._answers.get()
        if not answer["go_on"]:
            raise KeyboardInterrupt  # A STOP is not released, or the console ends it.
        return answer

    def _read(self, requests: int, probe: Any) -> None:
        with os.fdopen(requests, encoding="utf-8") as lines:
            for line in lines:
                request = json.loads(line)
                if "ask" in request:
                    self.report(answer=probe.answer(request), number=request["number"])
                else:
                    self._answers.put(request)


def _end_with_console(descriptor: int) -> None:
    """Wait until the console no longer reads the reports, because it was killed; then end.

    The process gets SIGINT, and `_GRACE` seconds later SIGKILL, with what it has started.
    """
    poller = select.poll()
    poller.register(descriptor, 0)  # Only POLLERR, which is always told.
    poller.poll()
    atexit.register(_kill_all)  # Also if it ends by the SIGINT.
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(_GRACE)
    _kill_all()


def _kill_all() -> None:
    kill_marked(os.environ[MARK])
    os.killpg(0, signal.SIGKILL)


def kill_marked(mark: str) -> list[int]:
    """Kill every process but this one that has a MARK; return the ids of those still there.

    Daemons, which leave the group, have it, too. Only Linux tells the environment of a process.
    """
    end = time.monotonic() + _KILL_TIME
    while (found := _marked_processes(mark)) and time.monotonic() < end:
        for process in found:
            with contextlib.suppress(OSError):
                os.kill(process, signal.SIGKILL)
        time.sleep(_POLL)
    return found


def _marked_processes(mark: str) -> list[int]:
    found, variable = [], f"{MARK}={mark}".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # It has ended, or belongs to another user.
            if variable in (folder / "environ").read_bytes().split(b"\0"):
                found.append(int(folder.name))
    return [process for process in found if process != os.getpid()]


if __name__ == "__main__":
    sys.exit(main())
