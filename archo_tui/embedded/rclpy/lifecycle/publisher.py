"""The module `rclpy.lifecycle.publisher`."""

from __future__ import annotations

from typing import Any, TypeVar

from rclpy.lifecycle.managed_entity import SimpleManagedEntity
from rclpy.publisher import Publisher

MsgT = TypeVar("MsgT")


class LifecyclePublisher(SimpleManagedEntity, Publisher[MsgT]):
    """A publisher that is silent unless it has been activated with its node.

    `LifecycleNode.create_lifecycle_publisher` makes it, silent also if the node is active by then.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, *args, **kwargs)

    @SimpleManagedEntity.when_enabled
    def publish(self, msg: MsgT | bytes) -> None:
        """Send a message as `Publisher.publish` does; do nothing while not `is_activated`."""
        Publisher.publish(self, msg)
