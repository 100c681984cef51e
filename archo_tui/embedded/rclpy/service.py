"""The module `rclpy.service`."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from rclpy._entity import QueueEntity, ServiceEnd
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.node import Node

SrvRequestT = TypeVar("SrvRequestT")
SrvResponseT = TypeVar("SrvResponseT")


class RequestHeader(NamedTuple):
    """The client that sent a request, and the number of the request, which that client counts."""

    client: Client[Any, Any]
    sequence_number: int


class Service(QueueEntity, ServiceEnd, Generic[SrvRequestT, SrvResponseT]):
    """A server of a service, made by `Node.create_service`.

    A full queue drops the oldest request.
    """

    _rank = 5

    def __init__(
        self,
        node: Node,
        srv_type: Any,
        srv_name: str,
        service_name: str,
        callback: Callable[[Any, Any], Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
    ) -> None:
        super().__init__(node, callback_group, qos_profile._queue_size)
        self.srv_type = srv_type
        self.qos_profile = qos_profile
        self.srv_name = srv_name  # As given.
        self._service_name = service_name  # As on the graph.
        self.callback = callback

    def send_response(self, response: SrvResponseT, header: RequestHeader) -> None:
        """Send a copy of `response` to the client of a request."""
        if not isinstance(response, self.srv_type.Response):
            raise TypeError(f"Expected {self.srv_type.Response}, got {type(response)}")
        if not isinstance(header, RequestHeader):
            raise TypeError(f"Expected the header of a request, got {type(header)}")
        self._use()
        message: Any = response
        client, number = header
        client._deliver((number, message.__received__()))

    def destroy(self) -> None:
        super().destroy()
        graph = self._node._graph
        graph.remove_named(graph.services, self._service_name, self)

    def _handle(self, item: tuple[RequestHeader, Any]) -> Any:
        header, request = item
        response = self.callback(request, self.srv_type.Response())
        if inspect.iscoroutine(response) and self._is_awaited():
            return self._answer_later(response, header)
        return self.send_response(response, header)

    async def _answer_later(self, response: Any, header: RequestHeader) -> None:
        self.send_response(await response, header)


class DeferredService(Service[Any, Any]):
    """A service whose callback takes request and header, and sends the response itself."""

    def _handle(self, item: tuple[RequestHeader, Any]) -> Any:
        header, request = item
        return self.callback(request, header)
