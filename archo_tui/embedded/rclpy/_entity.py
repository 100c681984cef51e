"""The bases of what an executor gets work from: subscriptions, clients, services and timers."""

from __future__ import annotations

import inspect
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from rclpy.node import Node


EntityT = TypeVar("EntityT", bound="Entity")


class Destroyable:
    """The base of objects that can be destroyed; using a destroyed one raises InvalidHandle."""

    _destroyed = False
    _is_part_of_action = False  # Then the node does not list it.

    @property
    def handle(self) -> Handle:
        """Return a stand-in for rcl's handle, also for a destroyed object."""
        return Handle(self)

    def _use(self) -> None:
        """Raise InvalidHandle if the object has been destroyed."""
        if self._destroyed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")


class Handle:
    """The stand-in for rcl's handle of an object.

    `with thing.handle:` raises InvalidHandle if the object has been destroyed.
    """

    def __init__(self, of: Destroyable) -> None:
        self._of = of

    @property
    def pointer(self) -> int:
        """Return a number that no handle of another living object has; in rclpy, an address."""
        return id(self._of)

    def __enter__(self) -> None:
        self._of._use()

    def __exit__(self, *_: object) -> None:
        """Do nothing: entering holds nothing."""


class Entity(Destroyable):
    """The base of what gives an executor work: timers, subscriptions, clients, services, events.

    A new entity joins its callback group. Leaving a `with` destroys the entity.
    """

    # The order in a round: actions, timers, subscriptions, clients, services.
    _rank = 1
    callback: Any = None
    _taken_by: Entity | None = None  # An entity that takes the work of several.

    def __init__(self, node: Node, callback_group: CallbackGroup) -> None:
        self._node = node
        self.callback_group = callback_group
        callback_group.add_entity(self)

    def destroy(self) -> None:
        """Start no further callback; one that runs goes on.

        The node still lists the entity, unlike after the node's own `destroy_...`.
        """
        self._destroyed = True

    def __enter__(self: EntityT) -> EntityT:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def _take(self) -> Callable[[], Any] | None:
        """Take the next piece of work off, and return it as a function; return None without work.

        The function may return a coroutine: see `_is_awaited`.
        """
        raise NotImplementedError

    def _is_awaited(self) -> bool:
        """Return True if the callback is an `async def`: the executor then awaits its coroutine."""
        return inspect.iscoroutinefunction(self.callback)

    def _waiting(self) -> int:
        """Return the number of pieces of work that wait to be taken."""
        return 0

    def _notify(self) -> None:
        """Tell the node's executor that this entity has work.

        Without an executor nothing happens: the work waits until the node is added to one.
        """
        executor = self._node._executor
        if executor is not None:
            executor._make_ready(self._taken_by or self)


class TimedEntity(Entity):
    """The base of entities that have work at certain times: timers."""

    _next_ns = 0  # Monotonic time, in ns.

    def _is_due(self) -> bool:
        """Return True if the time has come, so that `_take` probably finds work."""
        raise NotImplementedError

    def _schedule(self) -> None:
        """Let the node's executor check this entity when it is next due.

        Without an executor nothing happens.
        """
        raise NotImplementedError


class ServiceEnd(Destroyable):
    """The base of a service's client and server, which know its name and have a logger."""

    _node: Node
    _service_name: str

    @property
    def service_name(self) -> str:
        """Return the service's name on the graph; raise InvalidHandle after `destroy()`."""
        self._use()
        return self._service_name

    @property
    def logger_name(self) -> str:
        """Return the name of the node's logger."""
        return self._node.get_logger().name


class QueueEntity(Entity):
    """An entity with a queue of received items; a full queue drops its oldest item.

    Its executor takes one item a round, so that no full queue keeps another entity waiting. A
    `size` of None means no bound. An item that comes after `destroy()` is dropped.
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
        """Return the function that an executor calls for an item."""
        return partial(self._handle, item)

    def _handle(self, item: Any) -> Any:
        raise NotImplementedError

    def _waiting(self) -> int:
        return 0 if self._destroyed or self._taken_by else len(self._queue)
