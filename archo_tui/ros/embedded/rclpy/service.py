"""The module `rclpy.service`."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from rclpy._entity import ServiceEnd

if TYPE_CHECKING:
    from rclpy.client import Client

SrvRequestT = TypeVar("SrvRequestT")
SrvResponseT = TypeVar("SrvResponseT")


class RequestHeader(NamedTuple):
    """The client that sent a request, and the number of the request, which that client counts."""

    client: Client[Any, Any]
    sequence_number: int


class Service(ServiceEnd, Generic[SrvRequestT, SrvResponseT]):
    """A server of a service, made by `Node.create_service`.

    A full queue drops the oldest request.
    """

    _rank = 5

    def __init__(self, callback: Callable[[Any, Any], Any], *end: Any) -> None:
        super().__init__(*end)
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
