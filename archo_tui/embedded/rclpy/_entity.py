"""What an executor can have work from: subscriptions, clients, services and timers."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from rclpy.node import Node


EntityT = TypeVar("EntityT")


class Entity:
    """Something of a node with callbacks to run."""

    # in a round: actions, timers, subscriptions, guard conditions, clients, services
    _rank = 1

    def __init__(self, node: Node, callback_group: CallbackGroup) -> None:
        self._node = node
        self.callback_group = callback_group
        callback_group.add_entity(self)
        self._destroyed = False

    def destroy(self) -> None:
        """Never call back again; its node's own `destroy_...` does this too."""
        self._destroyed = True

    def __enter__(self: EntityT) -> EntityT:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def _take(self) -> Callable[[], Any] | None:
        """The next piece of work as a function (or coroutine function), None when there is none."""
        raise NotImplementedError

    def _waiting(self) -> int:
        """How many pieces of work wait."""
        return 0

    def _notify(self) -> None:
        """Tell the executor that there is work. Without one it stays until the node gets one."""
        executor = self._node._executor
        if executor is not None:
            executor._make_ready(self)


class QueueEntity(Entity):
    """An entity with a bounded queue; when it is full the oldest item is lost.

    Its executor takes one item a round, so that no full queue keeps another entity waiting.
    """

    def __init__(self, node: Node, callback_group: CallbackGroup, size: int | None) -> None:
        super().__init__(node, callback_group)
        self._queue: deque[Any] = deque(maxlen=size)
        self._queue_lock = threading.Lock()

    def _deliver(self, item: Any) -> None:
        if self._destroyed:
            return
        with self._queue_lock:
            waited = bool(self._queue)
            self._queue.append(item)
        if not waited:
            self._notify()

    def _take(self) -> Callable[[], Any] | None:
        with self._queue_lock:
            if not self._queue or self._destroyed:
                return None
            item = self._queue.popleft()
        return self._work(item)

    def _work(self, item: Any) -> Callable[[], Any]:
        """What is called for one item."""
        return partial(self._handle, item)

    def _handle(self, item: Any) -> Any:
        raise NotImplementedError

    def _waiting(self) -> int:
        return 0 if self._destroyed else len(self._queue)
