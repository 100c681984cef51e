"""ARCHO's own nodes in this process, each with the thread that spins it."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

import archo_tui
from archo_tui.base.errors import in_one_line
from archo_tui.robot.messages.types import kinds
from archo_tui.robot.messages.values import filled
from archo_tui.robot.outcome import outcome_of
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.user_code.errors import traceback_without
from archo_tui.user_code.hosted import HostedThread
from archo_tui.user_code.probe import destroy, served_names


class OwnNode(HostedThread):
    """A node of ARCHO's own, which is on the graph at once and spins from `begin` on."""

    def __init__(
        self,
        make: Callable[..., Node],
        context: Context,
        on_crash: Callable[[OwnNode], None],
        rename: str = "",
    ) -> None:
        self.make, self._context, self._on_crash, self._rename = make, context, on_crash, rename
        options = {"cli_args": ["--ros-args", "-r", f"__node:={rename}"]} if rename else {}
        self.node = make(context=context, **options)
        super().__init__(
            Hosted(self.node.get_fully_qualified_name(), serves=served_names(self.node))
        )
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)

    def make_again(self, rename: str = "") -> OwnNode:
        """Make another node of the same maker, and name if there is no new one."""
        return OwnNode(self.make, self._context, self._on_crash, rename or self._rename)

    def serves(self, service: str) -> bool:
        """Return True if the node has a service (not an action) of that full name."""
        return any(found.service_name == service for found in self.node.services)

    def carry_out_stop(self, service: str, request: Mapping[str, Any]) -> str:
        """Call the STOP callback of a node that does not spin yet; return why it did not confirm.

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

    def _run(self) -> None:
        try:
            while not self.is_stopping and self._context.ok():
                self._executor.spin_once()
        except ExternalShutdownException:
            return
        except BaseException as error:  # SystemExit ends the node, not the console.
            report = traceback_without(error, rclpy, archo_tui)
            self.state = self.state._replace(
                life=Life.CRASHED, error=in_one_line(error), traceback=report
            )
            self._executor.remove_node(self.node)
            destroy(self.node)
            self._on_crash(self)

    def interrupt(self) -> None:
        self._executor.create_task(lambda: None)  # A running callback runs to its end.

    def release(self) -> None:
        self._executor.shutdown(0)
        destroy(self.node)


def _value_of(coroutine: Coroutine[Any, Any, Any]) -> Any:
    """Return what a coroutine returns; raise ValueError if it waits for something."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        return end.value
    coroutine.close()
    raise ValueError("its callback waits for something")
