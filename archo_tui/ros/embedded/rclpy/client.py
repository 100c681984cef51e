"""The module `rclpy.client`."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any, Generic, TypeVar

from rclpy import _time_source
from rclpy._entity import ServiceEnd
from rclpy.context import Context
from rclpy.service import RequestHeader
from rclpy.task import Future, wait_for

SrvRequestT = TypeVar("SrvRequestT")
SrvResponseT = TypeVar("SrvResponseT")


class Client(ServiceEnd, Generic[SrvRequestT, SrvResponseT]):
    """A client of a service, made by `Node.create_client`.

    A full queue drops the oldest response.
    """

    _rank = 4

    def __init__(self, *end: Any) -> None:
        super().__init__(*end)
        self._lock = threading.Lock()
        self._sequence_number = 0
        self._pending_requests: dict[int, Future[Any]] = {}

    def call_async(self, request: SrvRequestT) -> Future[SrvResponseT]:
        """Send a copy of `request`, and return the future of the response.

        The future stays pending for ever when nobody answers. If several nodes offer the service,
        all get the request, and the first response counts.
        """
        if not isinstance(request, self.srv_type.Request):
            raise TypeError(f"Expected {self.srv_type.Request}, got {type(request)}")
        self._use()
        message: Any = request
        future: Future[Any] = Future(executor=self._node.executor)
        with self._lock:
            self._sequence_number += 1
            number = self._sequence_number
            self._pending_requests[number] = future
        future._when_done(partial(self._pending_requests.pop, number, None))
        for server in self._node._graph.servers(self._service_name, self.srv_type):
            server._deliver((RequestHeader(self, number), message.__received__()))
        return future

    def call(self, request: SrvRequestT, timeout_sec: float | None = None) -> Any:
        """Call and block until answered, while another thread spins the node."""
        future = self.call_async(request)
        if not wait_for(future, timeout_sec):
            future.cancel()
            raise TimeoutError
        return future.result()

    def remove_pending_request(self, future: Future[Any]) -> None:
        """Forget a request by its future; an answer that comes later is dropped.

        A future that is not pending is ignored.
        """
        with self._lock:
            for number, pending in list(self._pending_requests.items()):
                if pending is future:
                    self._pending_requests.pop(number, None)  # It may have been answered just now.

    @property
    def context(self) -> Context:
        """Return the node's context."""
        return self._node.context

    def service_is_ready(self) -> bool:
        """Return True if a node offers the service with this type."""
        self._use()
        return bool(self._node._graph.servers(self._service_name, self.srv_type))

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Block until the service is offered; return False when `timeout_sec` (s) passed before.

        None means no limit, a negative timeout no wait.
        """
        self._use()
        graph = self._node._graph
        with graph.changed:
            _time_source.wait_until(
                graph.changed,
                lambda: self._destroyed or self.service_is_ready(),
                _time_source.patience_ns(timeout_sec),
            )
            return self.service_is_ready()

    def _handle(self, item: tuple[int, Any]) -> None:
        number, response = item
        with self._lock:
            future = self._pending_requests.get(number)
        if future is not None:  # Only the first response counts: every server of the name answers.
            future._set_executor(self._node.executor)
            future.set_result(response)
