"""Service calls that always end: answered, or given up at their deadline. ROS thread only."""

from __future__ import annotations

import time
from typing import Any

from rclpy.node import Node

DEADLINE = 2.0  # s; "no answer in 2 s"
_SWEEP_PERIOD = 0.1  # s


class Calls:
    """Makes clients as they are needed and keeps an eye on what is pending."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[tuple[str, Any], Any] = {}
        self._pending: list[tuple[float, Any, Any]] = []
        self._timer = node.create_timer(_SWEEP_PERIOD, self._sweep)
        self._timer.cancel()

    def client(self, srv_type: Any, name: str) -> Any:
        """The client of that service."""
        key = (name, srv_type)
        if key not in self._clients:
            self._clients[key] = self._node.create_client(srv_type, name)
        return self._clients[key]

    async def call(self, srv_type: Any, name: str, request: Any) -> Any:
        """The response, or None when nobody answered within DEADLINE."""
        client = self.client(srv_type, name)
        future = client.call_async(request)
        self.watch(future, client)
        return await future

    def watch(self, future: Any, client: Any = None) -> None:
        """Cancel the future when its deadline passes: awaiting it then gives None."""
        self._pending.append((time.monotonic() + DEADLINE, future, client))
        if self._timer.is_canceled():
            self._timer.reset()

    def _sweep(self) -> None:
        now = time.monotonic()
        waiting = []
        for deadline, future, client in self._pending:
            if future.done() or future.cancelled():
                continue
            if deadline > now:
                waiting.append((deadline, future, client))
                continue
            if client is not None:
                client.remove_pending_request(future)
            future.cancel()
        self._pending = waiting
        if not waiting:
            self._timer.cancel()
