"""The embedded engine's `rclpy`: the part of ROS 2's Python client library that nodes use.

All of it runs in one process, without ROS. What fails on ROS 2 fails here, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rclpy import _process
from rclpy import logging as logging
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions as SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import get_default_context
from rclpy.utilities import get_rmw_implementation_identifier as get_rmw_implementation_identifier
from rclpy.utilities import ok as ok
from rclpy.utilities import shutdown as shutdown
from rclpy.utilities import try_shutdown as try_shutdown

if TYPE_CHECKING:
    from rclpy.executors import Executor
    from rclpy.node import Node


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> InitContextManager:
    """Begin to use rclpy: begin a context."""
    context = context or get_default_context()
    context.init(args, domain_id=domain_id)
    return InitContextManager(context)


class InitContextManager:
    """The result of `init`: a context manager that shuts the context down at its end."""

    def __init__(self, context: Context) -> None:
        self.context = context

    def __enter__(self) -> InitContextManager:
        return self

    def __exit__(self, *_: object) -> None:
        try_shutdown(context=self.context)


def create_node(node_name: str, **options: Any) -> Node:
    """Create a Node and return it; the options are those of `Node`."""
    from rclpy.node import Node

    return Node(node_name, **options)


def get_global_executor() -> Executor:
    """Return the executor that `spin` uses if none is given.

    The first call makes a single-threaded one of the default context, which lasts until `shutdown`
    or `try_shutdown`.
    """
    process = _process.current()
    if process.executor is None:
        from rclpy.executors import SingleThreadedExecutor

        process.executor = SingleThreadedExecutor()
    return process.executor


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run callbacks until the context is shut down or a callback raises; then remove the node.

    What the callback raises is raised here.
    """
    executor = executor or get_global_executor()
    executor.add_node(node)
    try:
        while executor.context.ok():
            executor.spin_once()
    finally:
        executor.remove_node(node)


def spin_once(
    node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Run one callback or task of the executor, unless none comes in time.

    The callback may be that of another node. What it raises is raised here.
    """
    with _added(node, executor) as found:
        found.spin_once(timeout_sec=timeout_sec)


def spin_until_future_complete(
    node: Node,
    future: Future[Any],
    executor: Executor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run callbacks until the future ends, the time is up, or context or executor is shut down.

    A future ends when it is done or cancelled. What a callback raises is raised here.
    """
    with _added(node, executor) as found:
        found.spin_until_future_complete(future, timeout_sec)


@contextmanager
def _added(node: Node, executor: Executor | None) -> Iterator[Executor]:
    """Add a node to an executor, and remove it again unless it was there before."""
    executor = executor or get_global_executor()
    added = executor.add_node(node)
    try:
        yield executor
    finally:
        if added:
            executor.remove_node(node)
