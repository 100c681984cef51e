"""`rclpy.subscription.Subscription`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rclpy._entity import QueueEntity
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy.node import Node

MsgT = TypeVar("MsgT")


class Subscription(QueueEntity, Generic[MsgT]):
    """Receives messages of one type from one topic. Made by `Node.create_subscription`."""

    _rank = 2
    _follows_changes = False  # of a status, instead of the whole of it

    def __init__(
        self,
        node: Node,
        msg_type: type[MsgT],
        topic_name: str,
        callback: Callable[[MsgT], Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
    ) -> None:
        super().__init__(node, callback_group, qos_profile.queue_size)
        self.msg_type = msg_type
        self.topic_name = topic_name
        self.callback = callback
        self.qos_profile = qos_profile

    def get_publisher_count(self) -> int:
        """How many publishers match."""
        graph = self._node._graph
        with graph.lock:
            return sum(self in p._matched for p in graph.topics[self.topic_name].publishers)

    def destroy(self) -> None:
        """Leave the topic; what is still queued is dropped."""
        self._destroyed = True
        self._node._graph.remove_subscription(self)
        self._queue.clear()

    def _handle(self, item: Any) -> Any:
        return self.callback(item)
