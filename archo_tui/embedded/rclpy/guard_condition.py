"""`rclpy.guard_condition.GuardCondition`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy._entity import QueueEntity
from rclpy.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from rclpy.node import Node


class GuardCondition(QueueEntity):
    """Has a callback run once for all triggers since it ran. Made by `create_guard_condition`."""

    _rank = 3

    def __init__(
        self, node: Node, callback: Callable[[], Any], callback_group: CallbackGroup
    ) -> None:
        super().__init__(node, callback_group, 1)
        self.callback = callback

    def trigger(self) -> None:
        """Have the callback run, from any thread. Raises InvalidHandle after `destroy()`."""
        self._use()
        self._deliver(None)

    def destroy(self) -> None:
        """Never run again."""
        self._destroyed = True

    def _handle(self, item: None) -> Any:
        return self.callback()
