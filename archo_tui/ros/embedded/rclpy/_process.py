"""The state that rclpy keeps once a process, here once a program that shares the process."""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rclpy.context import Context
    from rclpy.executors import Executor
    from rclpy.node import Node


class Process:
    """The default context, the global executor and the command line of a program."""

    def __init__(self, domain_id: int | None = None) -> None:
        self.domain_id = domain_id
        self.default_context: Context | None = None
        self.executor: Executor | None = None
        self.lock = threading.Lock()

    def begin_context(self, args: Sequence[str] | None) -> Sequence[str]:
        """Return the command line of a context that begins, which was given `args`."""
        return sys.argv if args is None else args

    def spin_node(self, node: Node, executor: Executor) -> None:
        """Do nothing; a subclass may take note that a node is added to an executor."""

    def add_node(self, node: Node) -> None:
        """Do nothing; a subclass may take note of a node that a thread of the program makes.

        The node has its name and is on the graph, but has no parameters yet.
        """


main = Process()  # Of all threads that belong to no program.
_KEY = "process of rclpy"  # Of a thread's attributes, so that the process ends with its threads.


def current() -> Process:
    """Return the state of the calling thread's program; `main` if the thread belongs to none."""
    found: Process = vars(threading.current_thread()).get(_KEY, main)
    return found


def adopt(thread: threading.Thread, process: Process) -> None:
    """Make a thread belong to a program: `current()` returns `process` on that thread."""
    vars(thread)[_KEY] = process
