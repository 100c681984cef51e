"""The bases of what an executor gets work from: subscriptions, clients, services and timers."""

from __future__ import annotations

import inspect
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.callback_groups import CallbackGroup

from archo_tui.embedded import absent

if TYPE_CHECKING:
    from rclpy.node import Node


EntityT = TypeVar("EntityT", bound="Entity")


class Destroyable:
    """An object that can be destroyed; using it afterwards raises InvalidHandle."""

    _destroyed = False
    _is_part_of_action = False  # Then the node does not list it.

    @property
    def handle(self) -> Handle:
        """Return the stand-in for rcl's handle of the object."""
        return Handle(self)

    def _use(self) -> None:
        """Raise InvalidHandle if the object has been destroyed."""
        if self._destroyed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")


class Handle:
    """The handle of a destroyable object: `with thing.handle:` raises InvalidHandle after that."""

    def __init__(self, of: Destroyable) -> None:
        self._of = of

    @property
    def pointer(self) -> int:
        """Return a number that no other handle has."""
        return id(self._of)

    def __enter__(self) -> None:
        self._of._use()

    def __exit__(self, *_: object) -> None:
        """Do nothing: entering holds nothing."""


class Entity(Destroyable):
    """A part of a node that has callbacks to run."""

    # The order in a round: actions, timers, subscriptions, clients, services.
    _rank = 1
    callback: Any = None
    _taken_by: Entity | None = None  # An entity that takes the work of several.

    def __init__(self, node: Node, callback_group: CallbackGroup) -> None:
        self._node = node
        self.callback_group = callback_group
        callback_group.add_entity(self)

    def destroy(self) -> None:
        """End all callbacks; the node's own `destroy_...` does this too."""
        self._destroyed = True

    def __enter__(self: EntityT) -> EntityT:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def _take(self) -> Callable[[], Any] | None:
        """Return the next piece of work as a function (or coroutine function), or None."""
        raise NotImplementedError

    def _is_awaited(self) -> bool:
        """Return True if a coroutine that the work returns must be awaited."""
        return inspect.iscoroutinefunction(self.callback)

    def _waiting(self) -> int:
        """Return how many pieces of work wait."""
        return 0

    def _notify(self) -> None:
        """Tell the executor that there is work; the work waits until the node has one."""
        executor = self._node._executor
        if executor is not None:
            executor._make_ready(self._taken_by or self)


class TimedEntity(Entity):
    """An entity that the executor must look at when its time has come."""

    _next_ns = 0  # Monotonic time, in ns.

    def _is_due(self) -> bool:
        """Return True if there is, or may be, work by now."""
        raise NotImplementedError

    def _schedule(self) -> None:
        """Tell the executor when to look."""
        raise NotImplementedError


class ServiceEnd(Destroyable):
    """A client or a service."""

    _node: Node
    _service_name: str
    configure_introspection = absent.Attribute()

    @property
    def service_name(self) -> str:
        """Return the name on the graph; raise InvalidHandle after `destroy()`."""
        self._use()
        return self._service_name

    @property
    def logger_name(self) -> str:
        """Return the name of the node's logger."""
        return self._node.get_logger().name


class QueueEntity(Entity):
    """An entity with a bounded queue; if it is full, the oldest item is lost.

    Its executor takes one item a round, so that no full queue keeps another entity waiting.
    """

    def __init__(self, node: Node, callback_group: CallbackGroup, size: int | None) -> None:
        super().__init__(node, callback_group)
        self._queue: deque[Any] = deque(maxlen=size)  # append and popleft are thread-safe.

    def _deliver(self, item: Any) -> None:
        if not self._destroyed:
            self._queue.append(item)
            self._notify()

    def _take(self) -> Callable[[], Any] | None:
        try:
            item = self._queue.popleft()
        except IndexError:
            return None
        return None if self._destroyed else self._work(item)

    def _work(self, item: Any) -> Callable[[], Any]:
        """Return the function to call for an item."""
        return partial(self._handle, item)

    def _handle(self, item: Any) -> Any:
        raise NotImplementedError

    def _waiting(self) -> int:
        return 0 if self._destroyed or self._taken_by else len(self._queue)
