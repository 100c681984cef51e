"""ARCHO's own nodes in this process, each with the thread that spins it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

import archo_tui
from archo_tui.errors import in_one_line
from archo_tui.robot.messages.types import kinds
from archo_tui.robot.messages.values import filled
from archo_tui.robot.outcome import outcome_of
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.user_code.errors import traceback_without
from archo_tui.user_code.probe import destroy, served_names

JOIN_TIMEOUT = 3.0  # Seconds that a callback may still take when its node is stopped.


class HostedNode:
    """A node, and the thread that spins it from `start` on."""

    def __init__(
        self,
        make: Callable[..., Node],
        context: Context,
        on_crash: Callable[[HostedNode], None],
        rename: str = "",
    ) -> None:
        self.make, self._context, self._on_crash, self._rename = make, context, on_crash, rename
        options = {"cli_args": ["--ros-args", "-r", f"__node:={rename}"]} if rename else {}
        self.node = make(context=context, **options)
        self.name = self.node.get_fully_qualified_name()
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self.state = Hosted(self.name, Life.UP, serves=served_names(self.node))
        self._stopping = False
        # What it prints is known by the name of the thread.
        self._thread = threading.Thread(target=self._spin, name=self.name, daemon=True)

    def start(self) -> None:
        """Spin the node."""
        self._thread.start()

    def serves(self, service: str) -> bool:
        """Return True if the node has a service (not an action) of that full name."""
        return any(found.service_name == service for found in self.node.services)

    def carry_out_stop(self, service: str, request: Mapping[str, Any]) -> str:
        """Call the STOP callback of a node that does not spin yet.

        A coroutine that waits for something does not confirm the STOP, nor does a service whose
        request has other fields, which is not called.
        """
        served = next(found for found in self.node.services if found.service_name == service)
        kind = served.srv_type
        if kinds(kind.Request).keys() != request.keys():
            return "the request of its service differs: not called"
        try:
            answer = served.callback(filled(kind.Request(), request), kind.Response())
            if isinstance(answer, Coroutine):
                answer = _value_of(answer)
            outcome = outcome_of(answer)
        except Exception as error:  # The callback may raise anything.
            return in_one_line(error)
        return "" if outcome.ok else outcome.text

    def make_again(self) -> HostedNode:
        """Make another node of the same maker and name; this node stays as it is."""
        return HostedNode(self.make, self._context, self._on_crash, self._rename)

    def _spin(self) -> None:
        try:
            while not self._stopping and self._context.ok():
                self._executor.spin_once()
        except ExternalShutdownException:
            return
        except BaseException as error:  # SystemExit ends the node, not the console.
            report = traceback_without(error, rclpy, archo_tui)
            self.state = self.state._replace(
                life=Life.CRASHED, error=in_one_line(error), traceback=report
            )
            self._leave_graph()
            self._on_crash(self)

    def _leave_graph(self) -> None:
        self._executor.remove_node(self.node)
        destroy(self.node)

    def begin_to_stop(self) -> None:
        """Ask the thread to end, without waiting for it; a running callback runs to its end."""
        self._stopping = True
        if self._thread.is_alive():
            self._executor.create_task(lambda: None)

    def stop(self, timeout: float = JOIN_TIMEOUT) -> bool:
        """End the thread and destroy the node; its state becomes STOPPED, unless it has crashed."""
        self.begin_to_stop()
        end = time.monotonic() + timeout
        if self._thread.is_alive():
            self._thread.join(max(end - time.monotonic(), 0.0))
        if self._thread.is_alive():
            self.state = self.state._replace(life=Life.STUCK)
            return False
        self._executor.shutdown(0)
        destroy(self.node)
        if self.state.life != Life.CRASHED:
            self.state = self.state._replace(life=Life.STOPPED, error="")
        return True


def _value_of(coroutine: Coroutine[Any, Any, Any]) -> Any:
    """Return what a coroutine returns; raise ValueError if it waits for something."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        return end.value
    coroutine.close()
    raise ValueError("its callback waits for something")
