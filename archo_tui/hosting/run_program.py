"""The child process of a program on ROS 2: `... run_program REPORTS ANSWERS FILE ...`.

It runs the file as `python FILE ...` does, and reports on a file descriptor, a JSON object a line:
each node that is made, what they serve, and what the file raised. From another one it reads the
console's answer: whether the file may go on with a node.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import threading
import time
from typing import Any
from weakref import WeakSet

assert sys.platform != "win32"  # As mypy is to know; there the console runs no programs on ROS 2.

_GRACE = 3.0  # Seconds between SIGINT and SIGKILL, when the console has gone.


def main() -> int:
    """Run the file of the command line, reporting to the console, and return its exit code.

    The code is that of a SystemExit, 1 after another exception, and 130 after Ctrl-C or if the
    console refuses a node; otherwise 0.
    """
    descriptor, answerer, given = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    os.set_inheritable(descriptor, False)
    os.set_inheritable(answerer, False)
    answers, asking = os.fdopen(answerer, encoding="utf-8"), threading.Lock()
    threading.Thread(target=_end_with_console, args=(descriptor,), daemon=True).start()
    from rclpy.action import ActionServer
    from rclpy.node import Node

    from archo_tui.hosting.hosted_node import served_names
    from archo_tui.hosting.hosted_program import exit_code
    from archo_tui.hosting.program_file import ProgramFile

    def report(**what: Any) -> None:
        os.write(descriptor, json.dumps(what).encode() + b"\n")

    nodes: WeakSet[Node] = WeakSet()
    make_node, make_service, make_action = (
        Node.__init__,
        Node.create_service,
        ActionServer.__init__,
    )

    def init(self: Node, *args: Any, **options: Any) -> None:
        make_node(self, *args, **options)
        imported = [str(path) for path in file.own_modules().values()]
        with asking:
            report(node=self.get_fully_qualified_name(), imported=imported)
            if answers.readline().strip() != "true":
                raise KeyboardInterrupt  # A STOP is not released.
        nodes.add(self)

    def report_services() -> None:
        report(serves=sorted({name for node in list(nodes) for name in served_names(node)}))

    def create_service(self: Node, *args: Any, **options: Any) -> Any:
        service = make_service(self, *args, **options)
        report_services()
        return service

    def init_action(self: ActionServer, *args: Any, **options: Any) -> None:
        make_action(self, *args, **options)
        report_services()

    file = ProgramFile(given)
    Node.__init__ = init  # type: ignore[method-assign]
    Node.create_service = create_service  # type: ignore[method-assign]
    ActionServer.__init__ = init_action  # type: ignore[method-assign]
    sys.argv = sys.argv[3:]
    try:
        file.compile()
        file.run(lambda module: sys.modules.update(__main__=module))
    except SystemExit as error:
        code, text = exit_code(error)
        if text:
            report(error=f"{given}: {text}")
        return code
    except KeyboardInterrupt:
        return 130  # 128 and the number of SIGINT, as a shell says it.
    except BaseException as error:
        text, traceback = file.explain(error)
        report(error=text, traceback=traceback)
        return 1
    return 0


def _end_with_console(descriptor: int) -> None:
    """Wait until the console no longer reads the reports, because it was killed; then end.

    The process gets SIGINT, and `_GRACE` seconds later SIGKILL.
    """
    poller = select.poll()
    poller.register(descriptor, 0)  # Only POLLERR, which is always told.
    poller.poll()
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(_GRACE)
    os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    sys.exit(main())
