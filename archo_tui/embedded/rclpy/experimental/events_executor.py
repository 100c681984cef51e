"""`rclpy.experimental.EventsExecutor`."""

from __future__ import annotations

from collections.abc import Iterable

from rclpy._entity import Entity
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor


class EventsExecutor(SingleThreadedExecutor):
    """Runs callbacks one by one in the order in which they became ready, whatever calls them."""

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)

    def _sorted(self, entities: Iterable[Entity]) -> Iterable[Entity]:
        return entities
