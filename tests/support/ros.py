"""Nodes for tests: one context a test, each node spun in a thread of its own."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions

from tests.support import chosen
from tests.support.waiting import wait_until


def begin(node: Node, work: Callable[..., object], *given: Any, **options: Any) -> Any:
    """Have the thread that spins the node do it; returns the future of what it returns.

    A goal that another thread sends may be answered before rclpy's client waits for the answer.
    """
    assert node.executor is not None
    return node.executor.create_task(work, *given, **options)


class Ros:
    """One ROS graph of a test's own."""

    def __init__(self, args: list[str] | None = None, domain_id: int | None = None) -> None:
        self.context = Context()
        rclpy.init(
            args=["--ros-args", "--disable-stdout-logs", *(args or [])],
            context=self.context,
            domain_id=chosen.next_domain() if domain_id is None else domain_id,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.errors: list[BaseException] = []
        self._spun: list[tuple[Any, threading.Thread]] = []
        self._executors: list[Any] = []
        self._nodes: list[Node] = []
        self._ending = False

    def node(self, name: str = "node", kind: Callable[..., Node] = Node, **options: Any) -> Node:
        """A node that nobody spins yet."""
        if kind is Node:
            node = Node(name, context=self.context, **options)
        else:
            node = kind(context=self.context, **options)
        self._nodes.append(node)
        return node

    def executor(self, *nodes: Node) -> SingleThreadedExecutor:
        """An executor with these nodes, for the test's own thread."""
        executor = SingleThreadedExecutor(context=self.context)
        self._executors.append(executor)
        for node in nodes:
            executor.add_node(node)
        return executor

    def topic(self, kind: Any, *nodes: Node, qos: Any = 10) -> tuple[Publisher[Any], list[Any]]:
        """A publisher, and what a subscription receives: of one node, or of the first and the last.

        They have found each other; nobody spins yet.
        """
        received: list[Any] = []
        nodes = nodes or (self.node(),)
        nodes[-1].create_subscription(kind, "topic", received.append, qos)
        publisher = nodes[0].create_publisher(kind, "topic", qos)
        wait_until(lambda: publisher.get_subscription_count() == 1)
        return publisher, received

    def spin(self, *nodes: Node, executor: Any = None) -> Any:
        """Spin the nodes in one new thread until the test ends; errors land in `errors`."""
        executor = executor or SingleThreadedExecutor(context=self.context)
        for node in nodes:
            executor.add_node(node)

        def run() -> None:
            try:
                while not self._ending:
                    executor.spin_once()
            except ExternalShutdownException:
                pass
            except BaseException as error:
                # rclpy may meet a context that is shut down only as it builds its wait set
                if self.context.ok() or "context is not valid" not in str(error):
                    self.errors.append(error)

        thread = threading.Thread(target=run, name="spin", daemon=True)
        thread.start()
        self._spun.append((executor, thread))
        return executor

    def spun(self, name: str = "node", **options: Any) -> Node:
        """A plain node, spun in its own thread."""
        node = self.node(name, **options)
        self.spin(node)
        return node

    def action_client(self, action_type: Any, action: str) -> ActionClient:
        """A client on a node of its own, spun only when it is made: rclpy's is not ready before."""
        node = self.node("action_client")
        client = ActionClient(node, action_type, action)
        self.spin(node)
        return client

    def result(self, future: Any) -> Any:
        """The value of an rclpy future that a spun node will complete."""
        wait_until(lambda: future.done(), "the future")
        return future.result()

    def __enter__(self) -> Ros:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._ending = True
        for executor, thread in self._spun:
            if thread.is_alive():
                executor.create_task(lambda: None)
                thread.join(5)
                assert not thread.is_alive(), "a spinning thread did not end"
            executor.shutdown(0)
        for executor in self._executors:
            executor.shutdown(0)
        for node in self._nodes:
            node.destroy_node()
        self.context.try_shutdown()
        if chosen.ENGINE == "ros2":
            gc.collect()  # rclpy's contexts hold file descriptors until they are collected
