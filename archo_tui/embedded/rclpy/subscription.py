"""The module `rclpy.subscription`."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypedDict, TypeVar

from rclpy import _time_source
from rclpy._entity import QueueEntity
from rclpy._event_handlers import Endpoint
from rclpy._type_checks import takes_info
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile

from archo_tui.embedded.cdr import encode

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.publisher import Publisher

MsgT = TypeVar("MsgT")


class MessageInfo(TypedDict):
    """The info of a message: when it was sent and received, by whom, and as which of its messages.

    Both times are that of sending, in ns of Unix time. `publication_sequence_number` counts a
    publisher's messages from 1; `reception_sequence_number` is None.
    """

    source_timestamp: int
    received_timestamp: int
    publication_sequence_number: int | None
    reception_sequence_number: int | None
    publisher_gid: Any


class Subscription(QueueEntity, Endpoint, Generic[MsgT]):
    """A subscription to one topic, made by `Node.create_subscription`.

    A full queue drops the oldest message.
    """

    _rank = 2
    _follows_changes = False  # True takes the changes of a status instead of all of it.

    def __init__(
        self,
        node: Node,
        msg_type: type[MsgT],
        topic: str,
        topic_name: str,
        callback: Callable[..., Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
        raw: bool = False,
    ) -> None:
        super().__init__(node, callback_group, qos_profile._queue_size)
        self.msg_type = msg_type
        self.topic = topic  # As given.
        self._topic_name = topic_name  # As on the graph.
        self.callback = callback
        self.qos_profile = qos_profile
        self.raw = raw
        self._gid = list(uuid.uuid4().bytes)

    class CallbackType(Enum):
        """The kinds of callback by what they are called with."""

        MessageOnly = 0
        WithMessageInfo = 1

    @property
    def callback(self) -> Callable[..., Any]:
        """Return the callback: a function of the message, or of the message and its info.

        Setting one that takes neither one nor two arguments raises RuntimeError.
        """
        return self._callback

    @callback.setter
    def callback(self, callback: Callable[..., Any]) -> None:
        self._with_info = takes_info(callback)
        kinds = self.CallbackType
        self._callback_type = kinds.WithMessageInfo if self._with_info else kinds.MessageOnly
        self._callback = callback

    @property
    def topic_name(self) -> str:
        """Return the topic's name on the graph; raise InvalidHandle after `destroy()`."""
        self._use()
        return self._topic_name

    @property
    def logger_name(self) -> str:
        """Return the name of the node's logger."""
        return self._node.get_logger().name

    def get_publisher_count(self) -> int:
        """Return how many publishers match in type and QoS."""
        self._use()
        graph = self._node._graph
        with graph.lock:
            return sum(self in p._matched for p in graph.topics[self._topic_name].publishers)

    def destroy(self) -> None:
        """Leave the topic; messages that are still queued are dropped.

        The node lists the subscription until `destroy_subscription`.
        """
        self._destroyed = True
        self._node._graph.remove_subscription(self)
        self._forget_events()
        self._queue.clear()

    def _receive(self, message: Any, sender: Publisher[Any]) -> None:
        """Queue a copy of a message, with its info if the callback takes it; as bytes if raw."""
        copied = encode(message) if self.raw else message.__received__()
        if not self._with_info:
            self._deliver(copied)
            return
        now = _time_source.time_ns()
        info: MessageInfo = {
            "source_timestamp": now,
            "received_timestamp": now,
            "publication_sequence_number": sender._sent,
            "reception_sequence_number": None,
            "publisher_gid": {"implementation_identifier": "embedded", "data": bytes(sender._gid)},
        }
        self._deliver((copied, info))

    def _work(self, item: Any) -> Callable[[], Any]:
        return partial(self._callback, *item) if self._with_info else partial(self._callback, item)
