"""The executor that `rclpy.spin` and its like use in a hosted node's own code.

On ROS 2 each process has one, which `main()` spins by `rclpy.spin(node)`. Here several nodes share
a process, so each has its own, by the thread that asks.
"""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node

# Python gives each new thread an empty context, so a thread that a node starts has rclpy's own one.
_of_thread: ContextVar[Executor] = ContextVar("global executor")


class GlobalExecutor(SingleThreadedExecutor):
    """An executor for the code of one hosted node, which reports each node before adding it.

    `rclpy.spin` and its like use it in the threads where `use` has set it.
    """

    def __init__(self, context: Context, on_add: Callable[[Node], None]) -> None:
        """Create an executor without nodes.

        Args:
            context: The rclpy context of the node.
            on_add: Called, in the thread that spins, before a node is added.
        """
        super().__init__(context=context)
        self._on_add = on_add

    def add_node(self, node: Node) -> bool:
        """Call `on_add`, then add the node; return False, as rclpy does, if it was added before."""
        self._on_add(node)
        return super().add_node(node)


def use(executor: Executor) -> None:
    """Set the executor that rclpy, after `install`, uses as the calling thread's global one."""
    _of_thread.set(executor)


def install() -> Callable[[], None]:
    """Make rclpy use the executor that `use` has set for the calling thread as its global one.

    In threads without such an executor, rclpy uses that of the process.

    Returns:
        A function that restores rclpy's own behaviour.
    """
    module: Any = rclpy
    original = module.get_global_executor

    def get_global_executor() -> Executor:
        executor = _of_thread.get(None)
        return original() if executor is None else executor

    def uninstall() -> None:
        module.get_global_executor = original

    module.get_global_executor = get_global_executor
    return uninstall
