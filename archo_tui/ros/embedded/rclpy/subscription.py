"""The module `rclpy.subscription`."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rclpy import _time_source
from rclpy._entity import Endpoint, QueueEntity
from rclpy.callback_groups import CallbackGroup

from archo_tui.ros.embedded.cdr import encode

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.publisher import Publisher

MsgT = TypeVar("MsgT")


class Subscription(QueueEntity, Endpoint, Generic[MsgT]):
    """A subscription to one topic, made by `Node.create_subscription`.

    A full queue drops the oldest message.
    """

    _rank = 2
    _follows_changes = False  # True takes the changes of a status instead of all of it.

    def __init__(
        self,
        callback: Callable[..., Any],
        callback_group: CallbackGroup,
        raw: bool,
        node: Node,
        *endpoint: Any,
    ) -> None:
        Endpoint.__init__(self, node, *endpoint)
        QueueEntity.__init__(self, node, callback_group, self.qos_profile._queue_size)
        self.callback, self.raw = callback, raw

    @property
    def callback(self) -> Callable[..., Any]:
        """Return the callback: a function of the message, or of the message and its info.

        Setting one that takes neither one nor two arguments raises RuntimeError.
        """
        return self._callback

    @callback.setter
    def callback(self, callback: Callable[..., Any]) -> None:
        self._with_info = _takes_info(callback)
        self._callback = callback

    def get_publisher_count(self) -> int:
        """Return how many publishers match in type and QoS."""
        self._use()
        graph = self._node._graph
        with graph.lock:
            return sum(self in p._matched for p in graph.topics[self._topic_name].publishers)

    def destroy(self) -> None:
        super().destroy()
        self._node._graph.remove_subscription(self)
        self._queue.clear()

    def _receive(self, message: Any, sender: Publisher[Any]) -> None:
        """Queue a copy of a message, with its info if the callback takes it; as bytes if raw."""
        copied = encode(message) if self.raw else message.__received__()
        if not self._with_info:
            self._deliver(copied)
            return
        now = _time_source.time_ns()
        # Both times are that of sending; publications are counted from 1, receptions are not.
        info = {
            "source_timestamp": now,
            "received_timestamp": now,
            "publication_sequence_number": sender._sent,
            "reception_sequence_number": None,
            "publisher_gid": {"implementation_identifier": "embedded", "data": bytes(sender._gid)},
        }
        self._deliver((copied, info))

    def _work(self, item: Any) -> Callable[[], Any]:
        return partial(self._callback, *item) if self._with_info else partial(self._callback, item)


def _takes_info(callback: Any) -> bool:
    """Return True if a callback takes a message and its info, and not a message alone."""
    with contextlib.suppress(TypeError):
        signature = inspect.signature(callback)
        for given in (1, 2):
            with contextlib.suppress(TypeError):
                signature.bind(*[object()] * given)
                return given == 2
    raise RuntimeError("callback should be callable with a message, or with a message and its info")
