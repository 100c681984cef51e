"""The module `rclpy.lifecycle.publisher`."""

from __future__ import annotations

from typing import Any, TypeVar

from rclpy.lifecycle.managed_entity import SimpleManagedEntity
from rclpy.publisher import Publisher

MsgT = TypeVar("MsgT")


class LifecyclePublisher(SimpleManagedEntity, Publisher[MsgT]):
    """A publisher that is silent unless its node is active.

    `LifecycleNode.create_lifecycle_publisher` makes it.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        SimpleManagedEntity.__init__(self)
        Publisher.__init__(self, *args, **kwargs)

    @SimpleManagedEntity.when_enabled
    def publish(self, msg: MsgT | bytes) -> None:
        """Send the message as `Publisher.publish` does; do nothing while the node is not active."""
        Publisher.publish(self, msg)
