"""Runs nodes in this process, each spun in a thread of its own; one that fails fails alone."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

JOIN_TIMEOUT = 3.0  # s a node's callback may still take at the end


@dataclass(frozen=True)
class Crash:
    """What a callback raised."""

    error: str
    traceback: str


class HostedNode:
    """One node and the thread that spins it."""

    def __init__(
        self, make: Callable[..., Node], context: Context, on_crash: Callable[[HostedNode], None]
    ) -> None:
        """Constructs the node: what its constructor raises comes out here."""
        self.node = make(context=context)
        self.name: str = self.node.get_fully_qualified_name()
        self.crash: Crash | None = None
        self._on_crash = on_crash
        self._stopping = False
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name=self.name, daemon=True)

    def start(self) -> None:
        """Begin to spin."""
        self._thread.start()

    def _spin(self) -> None:
        try:
            while not self._stopping:
                self._executor.spin_once()
        except ExternalShutdownException:
            return
        except Exception as error:
            self.crash = Crash(f"{type(error).__name__}: {error}", traceback.format_exc())
            self._executor.remove_node(self.node)
            self.node.destroy_node()
            self._on_crash(self)

    def stop(self) -> bool:
        """End the thread and destroy the node; False when a callback did not return in time."""
        self._stopping = True
        if self._thread.is_alive():
            self._executor.create_task(lambda: None)
            self._thread.join(JOIN_TIMEOUT)
            if self._thread.is_alive():
                return False
        self._executor.shutdown(0)
        self.node.destroy_node()
        return True


class Host:
    """The nodes of this process."""

    def __init__(self, context: Context, on_event: Callable[[str, str, str], None]) -> None:
        """`on_event(level, source, text)` is told what befalls the nodes, from their threads."""
        self._context = context
        self._on_event = on_event
        self.nodes: list[HostedNode] = []

    def add(self, make: Callable[..., Any]) -> HostedNode:
        """Construct a node; it is spun from `start()` on. Raises what the constructor raises."""
        hosted = HostedNode(make, self._context, self._crashed)
        self.nodes.append(hosted)
        return hosted

    def start(self) -> None:
        """Spin every node."""
        for hosted in self.nodes:
            hosted.start()

    def stop(self) -> list[str]:
        """Stop every node; returns the names of those that did not end."""
        return [hosted.name for hosted in self.nodes if not hosted.stop()]

    def _crashed(self, hosted: HostedNode) -> None:
        assert hosted.crash is not None
        self._on_event("ERROR", hosted.name.lstrip("/"), f"crashed: {hosted.crash.error}")
